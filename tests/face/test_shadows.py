"""A script of the user's own that is called like one of our packages is named in one sentence."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from shared import CHECKOUT

from patterndb.errors import HiddenPackageError
from patterndb.system.shadows import ORDINARY_NAMES, refuse_hidden_packages


def run(folder: Path, *words: str, path: str = str(CHECKOUT)) -> subprocess.CompletedProcess[str]:
    """Run Python in the folder, our packages found by PYTHONPATH."""
    environment = {**os.environ, "PYTHONPATH": path}
    return subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("name", ORDINARY_NAMES)
def test_a_script_in_its_folder_is_named(tmp_path: Path, name: str) -> None:
    script = tmp_path / f"{name}.py"
    script.write_text("import patterndb\nprint(patterndb.open())\n")
    done = run(tmp_path, script.name)
    assert done.returncode == 1 and not done.stdout
    last = done.stderr.strip().splitlines()[-1]
    wanted = f"{os.path.realpath(script)} hides patterndb's own package {name!r}: rename it"
    assert last == f"patterndb.errors.HiddenPackageError: {wanted}"


def test_so_is_a_package_and_a_file_beside_the_script(tmp_path: Path) -> None:
    (tmp_path / "query").mkdir()
    (tmp_path / "query" / "__init__.py").touch()
    (tmp_path / "mine.py").write_text("import patterndb\n")
    for words in (["mine.py"], ["-c", "import patterndb"]):
        done = run(tmp_path, *words)
        assert "query hides patterndb's own package 'query': rename it" in done.stderr
        assert "__init__" not in done.stderr.strip().splitlines()[-1]


def test_the_command_line_says_so_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "viewer.py").touch()
    done = run(tmp_path, "-m", "patterndb", "--help")
    assert done.returncode == 3 and not done.stdout
    where = os.path.realpath(tmp_path / "viewer.py")
    assert done.stderr == f"patterndb: {where} hides patterndb's own package 'viewer': rename it\n"


def test_it_is_an_import_error_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "something_else.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    other = tmp_path / "ours"
    other.mkdir()
    (other / "something_else.py").touch()
    with pytest.raises(HiddenPackageError, match=r"something_else\.py hides") as caught:
        refuse_hidden_packages(str(other), ["something_else"])
    assert isinstance(caught.value, ImportError)
    refuse_hidden_packages(str(tmp_path), ["something_else"])
    refuse_hidden_packages(str(other), ["is_nowhere"])


@pytest.mark.parametrize("words", [["-c", "import patterndb"], ["-m", "patterndb", "--help"]])
def test_nothing_is_said_where_nothing_is_hidden(tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "query").mkdir()  # hides nothing, for it is no package
    (tmp_path / "sketch.py").touch()
    linked = tmp_path / "linked"
    linked.symlink_to(CHECKOUT)
    for folder, path in (
        (CHECKOUT, ""),
        (CHECKOUT, str(CHECKOUT)),
        (CHECKOUT / "patterndb_app", str(CHECKOUT)),
        (tmp_path, str(CHECKOUT)),
        (tmp_path, str(linked)),
        (linked, str(CHECKOUT)),
    ):
        done = run(folder, *words, path=path)
        assert done.returncode == 0, done.stderr
