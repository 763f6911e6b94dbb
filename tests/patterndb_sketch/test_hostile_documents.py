"""Damaged documents are read or refused; benchmarks/hostile_documents.py feeds more of them."""

from __future__ import annotations

import pytest

from tests.support.hostiledocuments import KINDS, judge, make_case

CASES = 60


@pytest.mark.parametrize("kind", list(KINDS))
def test_documents_are_read_or_refused(kind: str) -> None:
    make_seeds, make_reader = KINDS[kind]
    seeds, read = make_seeds(), make_reader()
    for seed in seeds:
        assert judge(read, seed)[0] == "read"
    results = {number: judge(read, make_case(kind, seeds, 3, number)) for number in range(CASES)}
    # How long it takes is not judged here.
    wrong = {number: told for number, told in results.items() if told[0] == "unforeseen"}
    assert not wrong
    assert any(told[0] == "refused" for told in results.values())
