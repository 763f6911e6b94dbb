"""In a clone without the shared folder, the test modules that need it are skipped."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.support.shared import CHECKOUT


def test_a_module_that_needs_it_is_skipped_named_or_not(tmp_path: Path) -> None:
    clone = tmp_path / "clone"
    (clone / "tests" / "support").mkdir(parents=True)
    for name in ("__init__.py", "conftest.py", "support/shared.py"):
        shutil.copy(CHECKOUT / "tests" / name, clone / "tests" / name)
    (clone / "tests" / "test_needs.py").write_text(
        "from tests.support.shared import MESHES\nROWS = (MESHES / 'INDEX.csv').read_text()\n"
        "def test_it(): assert ROWS\n"
    )
    (clone / "tests" / "test_other.py").write_text("def test_it(): pass\n")
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    for words, skipped, passed in (
        (["tests/test_needs.py"], 1, 0),
        (["tests/test_needs.py::test_it"], 1, 0),
        (["tests"], 1, 1),
        (["tests/test_other.py"], 0, 1),
    ):
        command = [sys.executable, "-m", "pytest", "-rs", "-p", "no:cacheprovider", *words]
        done = subprocess.run(
            [*command, "-p", "no:xdist", "-v"],
            cwd=clone,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        said = done.stdout
        assert "Traceback" not in said and " error" not in said, said
        assert ("which is not there" in said) == bool(skipped), said
        assert (f"{passed} passed" in said) == bool(passed), said


def test_the_shared_conftest_loads_no_compiler() -> None:
    script = "import sys, tests.conftest; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert not {"scipy", "query", "ingest"} & set(done.stdout.split())
