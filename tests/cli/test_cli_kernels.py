"""What verbs compile: nothing where kernels came along, and what they say where they did not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from commandline import assert_refused, program, run
from shared import CHECKOUT

from patterndb.system.caches import KERNELS_VARIABLE
from patterndb.system.kernellist import read_list
from patterndb.system.kernelpack import PACK_VARIABLE, get_pack_path
from patterndb_app.cli.program import SECTIONS

sys.path.insert(0, str(CHECKOUT / "scripts"))
from verb_runs import RUNS

#: Verbs that have nothing of their own to run: what they do is asked of the others.
ABOUT_THE_PROGRAM = {"warmup", "report", "serve"}

#: Those that are run here; benchmarks and CI run them all (scripts/verb_runs.py --none-compiled).
QUICK = ("list", "meshes", "show", "export")


def test_every_verb_is_run_when_kernels_are_recorded() -> None:
    verbs = {verb for section in SECTIONS.values() for verb in section}
    assert verbs == RUNS.keys() | ABOUT_THE_PROGRAM


@pytest.mark.parametrize("verb", QUICK)
def test_nothing_is_compiled_where_kernels_came_along(verb: str, tmp_path: Path) -> None:
    path = get_pack_path()
    if path is None or not path.is_file():
        pytest.skip("no kernels are packed here: make patterndb/data/kernels")
    script = CHECKOUT / "scripts" / "verb_runs.py"
    done = subprocess.run(
        [sys.executable, script, "--none-compiled", verb],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), KERNELS_VARIABLE: str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


#: Loads all kernels that are kept; numba's own functions, which compiling needs, must not be among
#: what that imports. Symbols that code lacks would end the process.
LOADING = """
import sys
from patterndb.system.kernellist import find_kernel, read_list
n = 0
for listed in read_list():
    found = find_kernel(listed)
    if found is not None and found[0]._cache.is_kept(found[1]):
        assert found[0].compile(found[1]) is not None, listed
        n += 1
assert "numba.np.arraymath" not in sys.modules
print(n)
"""


def test_kernels_are_loaded_without_what_compiling_needs() -> None:
    if get_pack_path() is None:
        pytest.skip("no kernels are packed here: make patterndb/data/kernels")
    done = subprocess.run(
        [sys.executable, "-c", LOADING],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 0.9 * len(read_list())


def test_a_verb_says_what_it_compiles_and_then_not_again(tmp_path: Path) -> None:
    cold = {PACK_VARIABLE: "", KERNELS_VARIABLE: str(tmp_path / "kernels")}
    listed = ("list", "--class=3", "--limit=2")
    first = program(*listed, environment=cold)
    again = program(*listed, environment=cold)
    assert first.code == again.code == 0 and first.out == again.out
    assert any(path.is_file() for path in (tmp_path / "kernels").rglob("*"))
    assert "compil" not in again.err


class TestWarmup:
    def test_unknown_verbs_are_refused(self) -> None:
        assert_refused(run("warmup", "no-such-verb"), 2, "no-such-verb", "query")

    def test_compiles_what_is_missing_once(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        few = [k for k in read_list() if k.module == "patterndb.core.polychord"]
        assert few
        monkeypatch.setattr("patterndb.system.kernellist.read_list", lambda verbs=None: few)
        monkeypatch.setenv(KERNELS_VARIABLE, str(tmp_path))
        monkeypatch.setattr("patterndb.system.kernels.find_shipped", lambda: (None, "for a test"))
        monkeypatch.setenv(PACK_VARIABLE, "")  # for the processes that compile
        first = run("warmup", "--json").document()
        assert first["compiled"] == first["listed"] == len(few) and first["failed"] == []
        assert not first["shipped"] and first["reason"] == "for a test"
        assert any(path.is_file() for path in tmp_path.rglob("*"))
        again = run("warmup")
        assert again.code == 0 and "nothing to compile" in again.out

    def test_without_a_folder_it_says_so(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "file").touch()
        monkeypatch.setenv(KERNELS_VARIABLE, str(tmp_path / "file" / "below"))
        monkeypatch.setattr("patterndb.system.kernels.find_shipped", lambda: (None, "for a test"))
        assert_refused(run("warmup", "list"), 3, "no folder", "PATTERNDB_CACHE")
