"""patterndb report: what a bug report needs, and what is missing told as such."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

import pytest

import patterndb
from patterndb.system.extras import EXTRAS
from patterndb_app.cli.failure import TRACEBACK
from tests.support.cli.commandline import run


def test_it_tells_what_is_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(TRACEBACK, "1")
    monkeypatch.setenv("PATTERNDB_CACHE", str(tmp_path / "cache"))
    document = run("report", "--json").document()
    assert document["program"]["patterndb"] == patterndb.__version__
    assert platform.python_version() in document["program"]["Python"]
    for name in ("numpy", "scipy", "click"):
        assert document["packages"][name] == version(name)
    assert not {"pytest", "ruff"} & set(document["packages"]), "the developers' own tools"
    assert set(document["extras"]) == set(EXTRAS)
    assert str(tmp_path / "cache") in document["cache folders"]["1."]
    assert "not there" in document["cache folders"]["1."]
    assert document["variables"][TRACEBACK] == "1"
    assert document["windows"]["here"]


def test_the_text_says_the_same() -> None:
    document = run("report", "--json").document()
    lines = run("report").out.splitlines()
    for title, entries in document.items():
        assert f"{title}:" in lines
        for name, value in entries.items():
            assert f"  {name:<18} {value}".rstrip() in [line.rstrip() for line in lines]


def test_what_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("patterndb.system.extras.find_spec", lambda name: None)
    document = run("report", "--json").document()
    for name, extra in EXTRAS.items():
        assert document["extras"][name] == f"not installed: {extra.install}"
    assert EXTRAS["viewer"].install in document["windows"]["here"]
