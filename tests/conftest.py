"""What all tests share: the settings of hypothesis, and that the shared folder is there."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings
from shared import SHARED

# No test asserts a time, nor does hypothesis for it.
settings.register_profile(
    "patient",
    deadline=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("patient")


def pytest_sessionstart() -> None:
    if not SHARED.is_dir():
        raise pytest.UsageError(f"the tests need the shared folder beside the checkout: {SHARED}")
