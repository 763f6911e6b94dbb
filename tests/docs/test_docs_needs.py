"""The blocks of README, tutorial and guides need nothing that their page does not bring.

What a block needs: packages that it imports, names that it uses, files that it reads, and extras
of the verbs that it runs. What it may have: what the package itself installs, what blocks marked
``install`` on the same page install before it, what a clone holds, what earlier blocks make.
"""

from __future__ import annotations

import ast
import builtins
import re
import shlex
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import pytest

from patterndb.system.extras import EXTRAS

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    "README.md",
    "docs/tutorial.md",
    "docs/concepts.md",
    "docs/holes.md",
    "docs/queries.md",
    "docs/pyvista.md",
)

FENCE = re.compile(r"^```(sh|python)( \w+)?\n(.*?)^```$", re.MULTILINE | re.DOTALL)

OWN = {"patterndb", "ingest", "query", "viewer", "patterndb_sketch", "patterndb_app"}

#: Options and verbs that need an extra, as words of a command.
NEEDS = {
    "surface": "sketch",
    "retopo": "sketch",
    "serve": "service",
    "browse": "viewer",
    "explore": "viewer",
    "--view": "viewer",
    "--picture": "viewer",
    "--server": "client",
    "--scheduler": "dask",
    "cp-sat": "sketch",
}

#: Options whose value a command makes.
MAKES = {"-o", "--output", "--obj", "--picture", "--image", "--db", "--session", "--record", ">"}

#: What a file that is read ends in.
FILES = (".obj", ".ply", ".off", ".json", ".jsonl", ".db", ".npz", ".retopo", ".py")


def read_base() -> set[str]:
    """Read which packages the package itself installs."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return {re.split(r"[^\w]", line)[0].lower() for line in project["dependencies"]}


@dataclass
class Reader:
    """Reads a page's blocks in order. faults: what they need and have not."""

    have: set[str] = field(default_factory=read_base)
    extras: set[str] = field(default_factory=set)
    made: set[str] = field(default_factory=set)
    faults: list[str] = field(default_factory=list)

    def read(self, language: str, kind: str, text: str) -> None:
        if language == "python":
            self.read_python(text)
            return
        for words in list_commands(text):
            if words[:3] == ["python", "-m", "pip"]:
                self.install(words[4:])
            else:
                self.read_command(words)

    def install(self, names: list[str]) -> None:
        for name in names:
            listed = re.search(r"\[([\w,]+)\]", name)
            for extra in listed[1].split(",") if listed else ():
                self.extras.add(extra)
                self.have.update(EXTRAS[extra].packages)
            self.have.add(name.lower())

    def read_command(self, words: list[str]) -> None:
        drawn = "-o" in words or "--script" in words
        for word in words:
            needed = NEEDS.get(word)
            if word == words[0] or needed is None or (word == "browse" and drawn):
                continue
            if needed not in self.extras:
                self.faults.append(f"{' '.join(words)}: the extra {needed} is not installed before")
        written = {b for a, b in pairwise(words) if a in MAKES}
        # Meshes are removed by the names that the database has for them.
        for word in words[1:] if words[1:2] != ["remove"] else ():
            name = word.strip("/")
            if name.endswith(FILES) and name not in written and not self.is_there(name):
                self.faults.append(f"{' '.join(words)}: there is no {name}")
        self.made.update(name.strip("/") for name in written)
        if words[0].endswith("python") and "examples/car_bodies.py" in words:
            self.made.update(f"{words[2]}.{end}" for end in ("obj", "strokes.json"))

    def read_python(self, text: str) -> None:
        tree = ast.parse(text)
        known = set(dir(builtins))
        for node in ast.walk(tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                modules = (
                    [node.module or ""]
                    if isinstance(node, ast.ImportFrom)
                    else [alias.name for alias in node.names]
                )
                for module in modules:
                    top = module.partition(".")[0]
                    if top.lower() not in self.have | OWN | set(sys.stdlib_module_names):
                        self.faults.append(f"import {module}: nothing installs {top} before")
                known.update((a.asname or a.name).partition(".")[0] for a in node.names)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                known.add(node.id)
            elif isinstance(node, ast.arg):
                known.add(node.arg)
        made = set[str]()
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and node.id not in known:
                self.faults.append(f"{node.id} is used, but neither imported nor defined")
            if isinstance(node, ast.Call):
                made.update(list_made(node))
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                name = node.value
                if name.endswith(FILES) and name not in made and not self.is_there(name):
                    self.faults.append(f"there is no {name}")
        self.made.update(made)

    def is_there(self, name: str) -> bool:
        if name in self.made or any(name.startswith(f"{folder}/") for folder in self.made):
            return True
        # Of a clone, what a fresh one holds: the folder of this one has what was made in it.
        return name.startswith(("examples/", "docs/")) and (ROOT / name).exists()


def list_made(call: ast.Call) -> Iterator[str]:
    """List the files that a call makes: of open(name, "create") and mesh.write(name)."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    values = [one.value for one in call.args if isinstance(one, ast.Constant)]
    if (name == "open" and "create" in values) or name in ("write", "save", "savefig"):
        yield from (one for one in values if isinstance(one, str))


def list_commands(text: str) -> Iterator[list[str]]:
    """List the commands of a block of the shell, without what stands in documents."""
    end = ""
    for line in text.replace("\\\n", " ").splitlines():
        if end:
            end = "" if line == end else end
            continue
        found = re.search(r"<<'(\w+)'", line)
        if found:
            end = found[1]
            line = line.replace(found[0], "")
        words = shlex.split(line, comments=True)
        if words and words[0] != "eval":
            yield words


def read_page(text: str) -> list[str]:
    """Read a page; return what its blocks need and have not."""
    reader = Reader()
    for language, kind, body in FENCE.findall(text):
        reader.read(language, kind.strip(), body)
    return reader.faults


@pytest.mark.parametrize("page", PAGES)
def test_a_page_brings_what_its_blocks_need(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    if page == "docs/queries.md":
        # A database of the reader's own, which the text speaks of.
        text = "```sh\npatterndb ingest examples --db own.db\n```\n" + text
    assert read_page(text) == []


@pytest.mark.parametrize(
    ("block", "words"),
    [
        ("python run\nfrom matplotlib.figure import Figure\n", "matplotlib"),
        ("python\nwith patterndb.open() as db:\n    pass\n", "patterndb is used"),
        ('python\nimport patterndb\npatterndb.read("head.obj")\n', "no head.obj"),
        ("sh run\npatterndb surface examples/networks/teacup.json -o a.obj\n", "extra sketch"),
        ("sh run\npatterndb holes head.obj\n", "no head.obj"),
        ("sh run\npatterndb stats --db a.db --server http://127.0.0.1\n", "extra client"),
    ],
)
def test_what_a_page_does_not_bring_is_found(block: str, words: str) -> None:
    (fault,) = read_page(f"```{block}```\n")
    assert words in fault


def test_what_a_page_brings_is_there() -> None:
    page = """
```sh install
python -m pip install '.[sketch]' matplotlib
```

```sh run
patterndb surface examples/networks/teacup.json -o cup.obj
patterndb holes cup.obj
```

```python run
import matplotlib
import patterndb

patterndb.read("cup.obj")
```
"""
    assert read_page(page) == []
