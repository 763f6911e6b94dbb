"""Cases that schemathesis makes of the interface's description, right and wrong ones."""

from __future__ import annotations

import contextlib
from typing import Any

import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Unsatisfiable
from hypothesis.strategies import SearchStrategy
from schemathesis import GenerationMode
from schemathesis.checks import load_all_checks
from schemathesis.config import SchemathesisConfig
from schemathesis.specs.openapi import checks

load_all_checks()

#: What is held against every answer: no 5xx, and status, media type and body as described.
HELD = [
    schemathesis.checks.not_a_server_error,
    checks.status_code_conformance,
    checks.content_type_conformance,
    checks.response_schema_conformance,
]


def ask_cases(described: dict[str, Any], url: str, each: int, number: int) -> tuple[int, list[str]]:
    """Ask ``each`` cases of every operation, drawn from a seed; return how many were asked, and
    what was wrong with their answers."""
    schema = schemathesis.openapi.from_dict(described, config=SchemathesisConfig())
    asked = 0
    failures: list[str] = []
    for found in schema.get_all_operations():
        operation = found.ok()
        for mode in (GenerationMode.POSITIVE, GenerationMode.NEGATIVE):
            made = operation.as_strategy(generation_mode=mode)
            count, wrong = ask_operation(made, operation.label, url, max(each // 2, 1), number)
            asked += count
            failures += wrong
    return asked, failures


def ask_operation(
    made: SearchStrategy[Any], label: str, url: str, cases: int, number: int
) -> tuple[int, list[str]]:
    """Ask cases of one operation, as :func:`ask_cases` does."""
    asked = 0
    failures: list[str] = []

    @seed(number)
    @settings(
        max_examples=cases,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(case=made)
    def ask(case: Any) -> None:
        nonlocal asked
        asked += 1
        try:
            case.call_and_validate(base_url=url, checks=HELD, timeout=60)
        except Exception as error:
            failures.append(f"{label}: {error}")

    # Not every operation has something that can be wrong.
    with contextlib.suppress(Unsatisfiable):
        ask()
    return asked, failures
