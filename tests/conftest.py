"""What all tests share: the settings of hypothesis, what to do without a shared folder, and the
starter database."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from shared import SHARED

import patterndb
from patterndb.system.kernels import VARIABLE, kernel_folder
from query.engine import PatternSource

# Tests that name another cache folder shall not compile all kernels again.
os.environ.setdefault(VARIABLE, str(kernel_folder()))

# No test asserts a time, nor does hypothesis for it.
settings.register_profile(
    "patient",
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("patient")


#: How a test module names what lies in the shared folder.
NEEDS_SHARED = re.compile(
    r"\b(SHARED|GOLDEN|MESHES|oracle|query_cases|placing_cases|viewer_disks)\b"
)


def pytest_report_header() -> str:
    if SHARED.is_dir():
        return f"shared folder: {SHARED}"
    return f"no shared folder at {SHARED}: the test modules that compare with it are left out"


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave out, where there is no shared folder, the modules that need it."""
    if SHARED.is_dir() or not collection_path.name.startswith("test_"):
        return None
    return True if NEEDS_SHARED.search(collection_path.read_text(encoding="utf-8")) else None


@pytest.fixture(scope="session")
def source() -> Iterator[PatternSource]:
    """The starter database."""
    with patterndb.open() as opened:
        yield opened
