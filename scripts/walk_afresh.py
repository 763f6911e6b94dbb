"""Do all that README, tutorial and holes.md say, each in an environment of its own.

    python scripts/walk_afresh.py [FOLDER]

For every page a clone (of the last commit) and a virtual environment are made in the folder. First
README's first step that installs is done, then the page's own steps, in order: what no step
installs, imports or makes is missed. Ends with 1 if a step failed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import walkthrough

ROOT = Path(__file__).parents[1]
PAGES = ("docs/holes.md", "README.md", "docs/tutorial.md")

#: Of the environment of whoever runs this, what would bring other sources or packages in.
LEFT_OUT = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")


def make_clone(folder: Path) -> None:
    """Unpack the last commit into a folder."""
    folder.mkdir(parents=True)
    packed = subprocess.run(
        ["git", "-C", str(ROOT), "archive", "HEAD"], stdout=subprocess.PIPE, check=True
    )
    subprocess.run(["tar", "x", "-C", str(folder)], input=packed.stdout, check=True)


def walk(page: str, folder: Path) -> tuple[int, list[str]]:
    """Do a page's steps; return how many were done and what failed."""
    make_clone(folder)
    first = next(step for step in walkthrough.steps(ROOT / "README.md", afresh=True))
    subprocess.run([sys.executable, "-m", "venv", str(folder / ".venv")], check=True)
    python = str(folder / ".venv" / "bin" / "python")
    steps = walkthrough.steps(ROOT / page, afresh=True)
    done = 0
    failed: list[str] = []
    for step in [first, *(step for step in steps if step != first)]:
        try:
            walkthrough.perform(step, folder, python)
        except RuntimeError as error:
            failed.append(str(error))
        done += 1
        print(f"{step.page}:{step.line}: {'failed' if failed else 'done'}", flush=True)
    return done, failed


def main() -> None:
    """Walk every page and print what failed."""
    for name in LEFT_OUT:
        os.environ.pop(name, None)
    parent = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    broken = 0
    for page in PAGES:
        done, failed = walk(page, parent.resolve() / Path(page).stem)
        broken += len(failed)
        print(f"{page}: {done} steps, {len(failed)} failed", *failed, sep="\n", flush=True)
    sys.exit(1 if broken else 0)


if __name__ == "__main__":
    main()
