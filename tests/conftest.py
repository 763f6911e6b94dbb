"""Settings of hypothesis, the starter database, and a note where larger runs are left out."""

from __future__ import annotations

from collections.abc import Iterator
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
# A change is judged by the same examples in every run; --hypothesis-profile random finds others,
# and takes twice as many where a test does not name a number.
settings.register_profile(
    "repeatable", settings.get_profile("random"), derandomize=True, max_examples=50
)
settings.load_profile("repeatable")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Report that larger runs were left out, where the folder for them is missing."""
    if not SHARED.is_dir():
        terminalreporter.write_line(f"no folder at {SHARED}: without larger runs")


@pytest.fixture(scope="session")
def source() -> Iterator[PatternSource]:
    """The starter database."""
    with patterndb.open() as opened:
        yield opened
