"""Random actions in every window; benchmarks/windows_random.py does thousands of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QMessageBox

from tests.support.viewer.events import answer
from tests.support.viewer.randomhand import MAKERS, try_window

ACTIONS = 120


@pytest.mark.parametrize("name", MAKERS)
def test_any_actions_leave_a_window_whole(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer(monkeypatch, QMessageBox.StandardButton.Cancel)

    def name_file(_parent: object, _title: str, _suggested: str, filters: str) -> tuple[str, str]:
        return str(tmp_path / f"saved{filters[1:]}"), filters

    monkeypatch.setattr(QFileDialog, "getSaveFileName", name_file)
    tried = try_window(name, ACTIONS, 7, tmp_path)
    assert tried.actions == ACTIONS and not tried.failures
