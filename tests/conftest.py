"""What all tests share: the settings of hypothesis, what to do without a shared folder, and the
starter database."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings

import patterndb
from tests.support.shared import SHARED

if TYPE_CHECKING:
    from query.engine import PatternSource

# No test asserts a time, nor does hypothesis for it.
settings.register_profile(
    "random",
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
# A change is judged by the same examples in every run; --hypothesis-profile random finds others.
settings.register_profile("repeatable", settings.get_profile("random"), derandomize=True)
settings.load_profile("repeatable")


#: How a test module names what lies in the shared folder.
NEEDS_SHARED = re.compile(
    r"\b(SHARED|GOLDEN|MESHES|oracle|support\.query\.(cases|placing)|support\.viewer\.disks)\b"
)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say at the end, where -q leaves out the head, that there is no shared folder."""
    if not SHARED.is_dir():
        terminalreporter.write_line(
            f"no shared folder at {SHARED}: the test modules that compare with it are skipped"
        )


class SkippedModule(pytest.Module):
    """A test module that needs the shared folder where there is none; it is not imported."""

    def collect(self) -> list[pytest.Item]:
        pytest.skip("compares with the shared folder, which is not there", allow_module_level=True)


def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> pytest.Module | None:
    """Skip, where there is no shared folder, the modules that need it, named ones too."""
    if SHARED.is_dir() or not NEEDS_SHARED.search(module_path.read_text(encoding="utf-8")):
        return None
    return SkippedModule.from_parent(parent, path=module_path)


@pytest.fixture(scope="session")
def source() -> Iterator[PatternSource]:
    """The starter database."""
    with patterndb.open() as opened:
        yield opened
