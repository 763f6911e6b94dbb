"""Do what a page tells its reader to do.

A fenced block of a page is a step if its language is followed by the word ``run``:

    ```sh run
    patterndb stats --db my.db
    ```

and a block ``text output`` after it shows what it writes, a line ``…`` standing for lines
left out. The steps of a page are done in order, in a folder that holds copies of examples/ and
docs/meshes/ to begin with, as in a clone. A block followed by the word ``install`` installs what
the page needs from there on; walk_afresh.py does these, too, in an environment of its own.
"""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]

#: The database that blocks of SQL are asked of.
SQL_DATABASE = "my.db"

BLOCK = re.compile(r"^```(\w+) (run|output|install)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True, slots=True)
class Step:
    """One block to run. shown: what the page says it writes, None if it does not say. installs:
    does it install what later steps need?"""

    page: str
    line: int
    language: str
    text: str
    shown: str | None
    installs: bool = False


def steps(page: Path, *, afresh: bool = False) -> list[Step]:
    """The steps of a page, in order; those that install are among them only if all is done
    afresh."""
    text = page.read_text(encoding="utf-8")
    found: list[Step] = []
    for block in BLOCK.finditer(text):
        language, kind, body = block.groups()
        if kind == "output":
            last = found.pop()
            found.append(Step(last.page, last.line, last.language, last.text, body))
        else:
            line = text.count("\n", 0, block.start()) + 1
            found.append(Step(page.name, line, language, body, None, kind == "install"))
    return [step for step in found if afresh or not step.installs]


def begin(folder: Path) -> None:
    """Give a folder what a clone has for its reader."""
    shutil.copytree(
        ROOT / "examples", folder / "examples", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copytree(ROOT / "docs" / "meshes", folder / "docs" / "meshes")


def perform(step: Step, folder: Path, python: str = sys.executable) -> str:
    """Do one step in the folder; return all it writes. Raises RuntimeError if it fails.

    python: that of the environment.
    """
    if step.language == "sql":
        connection = sqlite3.connect(f"file:{folder / SQL_DATABASE}?mode=ro", uri=True)
        try:
            return "".join(f"{row}\n" for row in connection.execute(step.text))
        finally:
            connection.close()
    words = {"sh": ["sh", "-e", "-c"], "python": [python, "-c"]}[step.language]
    here = str(Path(python).parent)
    done = subprocess.run(
        [*words, step.text],
        cwd=folder,
        env=os.environ | {"PATH": here + os.pathsep + os.environ["PATH"]},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        check=False,
    )
    if done.returncode:
        raise RuntimeError(
            f"{step.page}:{step.line}: exit code {done.returncode}\n{step.text}{done.stdout}"
        )
    return done.stdout
