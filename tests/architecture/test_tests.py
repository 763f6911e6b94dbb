"""The tests themselves: what they import, and that what they need is with them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from tests.support.shared import CHECKOUT

TESTS = CHECKOUT / "tests"

#: Folders of programs that tests do not import, though these may import tests.support.
PROGRAMS = ("benchmarks", "scripts")

#: Their tests are the exceptions: docs are what scripts write, and the page is driven by one.
OF_SCRIPTS = ("docs", "patterndb_app/web")


def list_tests() -> list[Path]:
    """Return all Python files of the tests that are held to the rules."""
    apart = [TESTS / folder for folder in OF_SCRIPTS]
    return [
        path for path in sorted(TESTS.rglob("*.py")) if not any(a in path.parents for a in apart)
    ]


def test_tests_import_no_programs() -> None:
    names = {path.stem for folder in PROGRAMS for path in (CHECKOUT / folder).rglob("*.py")}
    programs = "|".join(sorted(names | set(PROGRAMS)))
    importing = re.compile(rf"^\s*(?:import|from) (?:{programs})\b", re.MULTILINE)
    assert importing.search("    from benchmarks.holes import main")
    assert not [path for path in list_tests() if importing.search(path.read_text("utf-8"))]


def test_the_conftest_loads_little() -> None:
    script = "import sys, tests.conftest; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert not {"scipy", "query", "ingest"} & set(done.stdout.split())


def test_recipes_name_tests_that_exist() -> None:
    recipes = [CHECKOUT / "Makefile", CHECKOUT / ".ci" / "run"]
    named = {
        name
        for recipe in recipes
        for name in re.findall(r"\btests/[\w/]+(?:\.py)?", recipe.read_text("utf-8"))
    }
    assert "tests/core" in named
    assert [name for name in sorted(named) if not (CHECKOUT / name).exists()] == []
