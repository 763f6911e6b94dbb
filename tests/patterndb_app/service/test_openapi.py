"""The description of the interface: its examples are true, and hostile cases are answered so."""

from __future__ import annotations

import pytest
from jsonschema import Draft202012Validator

from patterndb_app.service.openapi import EXAMPLES
from tests.support.service.hostilecases import ask_cases
from tests.support.service.servedhere import TOKEN, ServedHere

#: Cases of each operation: benchmarks/service_cases.py asks thousands.
CASES = 4


@pytest.mark.parametrize(
    ("path", "title"), [(path, title) for path in EXAMPLES for title in EXAMPLES[path]]
)
def test_every_example_is_answered_as_its_schema_says(
    starter: ServedHere, writable: ServedHere, path: str, title: str
) -> None:
    described = starter.http.get("/openapi.json").json()
    operation = described["paths"][path]["post"]
    body = operation["requestBody"]["content"]["application/json"]["examples"][title]["value"]
    assert body == EXAMPLES[path][title]
    asked = writable if path == "/v1/uses" else starter
    answer = asked.http.post(path, json=body, headers={"Authorization": f"Bearer {TOKEN}"})
    assert answer.status_code == 200, answer.text
    schema = operation["responses"]["200"]["content"]["application/json"]["schema"]
    Draft202012Validator({**schema, "components": described["components"]}).validate(answer.json())
    question = operation["requestBody"]["content"]["application/json"]["schema"]
    Draft202012Validator({**question, "components": described["components"]}).validate(body)


def test_every_call_is_described(starter: ServedHere) -> None:
    described = starter.http.get("/openapi.json").json()
    for path in (
        "/v1/health",
        "/v1/version",
        "/v1/limits",
        "/v1/metrics",
        "/v1/orders",
        "/v1/shapes",
        "/v1/stats",
        "/v1/meshes",
        "/v1/patterns",
        "/v1/patterns/{name}",
        "/v1/patterns/{name}.svg",
        "/v1/patterns/{name}.png",
        "/v1/fills",
        "/v1/surfaces",
        "/v1/holes",
        "/v1/uses",
        "/v1/jobs",
        "/v1/jobs/{id}",
    ):
        assert described["paths"][path]


def test_hostile_cases_are_answered_as_described(writable: ServedHere) -> None:
    described = writable.http.get("/openapi.json").json()
    asked, failures = ask_cases(described, writable.url, CASES, 1)
    assert asked >= CASES * len(described["paths"]) / 2
    assert not failures, failures[:3]
