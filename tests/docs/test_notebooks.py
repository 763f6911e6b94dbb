"""The example notebooks run from their first cell to their last, and draw what they show."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

from tests.support.shared import CHECKOUT

NOTEBOOKS = sorted((CHECKOUT / "examples" / "notebooks").glob("*.ipynb"))


def test_there_are_three() -> None:
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_what_it_writes(path: Path) -> None:
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    shutil.copytree(
        CHECKOUT / "examples", tmp_path / "examples", ignore=shutil.ignore_patterns("__pycache__")
    )
    notebook = nbformat.read(path, as_version=4)
    environment = os.environ | {"PYTHONPATH": str(CHECKOUT)}
    client = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3")
    client.execute(cwd=str(tmp_path), env=environment)
    written = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    assert not [out for out in written if out.output_type == "error"]
    assert any("image/svg+xml" in out.get("data", {}) for out in written)
    assert any(out.output_type == "stream" for out in written)
