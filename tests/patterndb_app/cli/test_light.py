"""What a verb imports: what it uses, and nothing of the optional parts that it does not."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from patterndb.system.extras import EXTRAS
from tests.support.cli.commandline import TINY, Result
from tests.support.shared import CHECKOUT

#: What a verb may do without; packages of ours that are rooms of their own among them.
WATCHED = {
    "query",
    "ingest",
    "viewer",
    "patterndb_sketch",
    "scipy",
    "scipy.sparse",
    "scipy.spatial",
    "ortools",
    "pandas",
    "matplotlib",
    "pyvista",
    "vtkmodules",
    "trimesh",
    "pxr",
}

EXAMPLES = CHECKOUT / "examples"

NETWORK = """{"curves": [{"id": 1, "points": [[0,0,0],[1,0,0]]},
{"id": 2, "points": [[1,0,0],[0,1,0]]}, {"id": 3, "points": [[0,1,0],[0,0,0]]}],
"cycles": [[1, 2, 3]]}"""

VTK_SQUARE = """# vtk DataFile Version 3.0
square
ASCII
DATASET POLYDATA
POINTS 4 float
0 0 0 1 0 0 1 1 0 0 1 0
POLYGONS 1 5
4 0 1 2 3
"""


def run_watched(
    folder: Path, *arguments: object, without: tuple[str, ...] = ()
) -> tuple[Result, set[str]]:
    """Run the program in a process of its own; its result, and which watched packages it imported.

    without: packages that this process shall not find.
    """
    seen = folder / "modules.txt"
    script = (
        "import atexit, pathlib, sys\n"
        f"for name in {without!r}: sys.modules[name] = None\n"
        "names = lambda: ' '.join(m for m, held in sys.modules.items() if held is not None)\n"
        f"atexit.register(lambda: pathlib.Path({str(seen)!r}).write_text(names()))\n"
        f"sys.argv = ['patterndb', *{[str(a) for a in arguments]!r}]\n"
        "from patterndb_app.cli import main\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    return Result(done.returncode, done.stdout, done.stderr), set(
        seen.read_text().split()
    ) & WATCHED


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a database and what the verbs below read."""
    made = tmp_path_factory.mktemp("light")
    (made / "triangle.json").write_text(NETWORK)
    (made / "square.vtk").write_text(VTK_SQUARE)
    (made / "boundary.json").write_text(
        '{"sides": [[[0,0,0],[2,0,0]], [[2,0,0],[2,2,0]], [[2,2,0],[0,2,0]], [[0,2,0],[0,0,0]]],'
        ' "lengths": [2, 2, 2, 2]}'
    )
    result, imported = run_watched(made, "ingest", EXAMPLES / "jug.obj", "--db", "a.db", *TINY)
    assert result.code == 0, result.err
    assert imported == {"ingest"}
    return made


@pytest.mark.parametrize(
    ("arguments", "imported"),
    [
        ("--version", set()),
        ("query --help", {"query"}),  # the table of orders, for the option's help
        ("stats --db a.db", set()),
        ("meshes --db a.db", set()),
        ("verify --db a.db", set()),
        ("query --sides 2,2,2,2 --db a.db --limit 2", {"query"}),
        (
            "query --sides 2,2,2,2 --db a.db --limit 2 --image a.png",
            {"query", "viewer", "scipy", "scipy.sparse"},
        ),
        (
            "gallery --class 4 --db a.db --limit 3 -o a.svg",
            {"query", "viewer", "scipy", "scipy.sparse"},
        ),
        ("fill boundary.json --db a.db -o a.obj", {"query", "scipy", "scipy.sparse"}),
        (
            "surface triangle.json -o a.obj",
            {"ingest", "query", "patterndb_sketch", "scipy", "scipy.sparse", "scipy.spatial"},
        ),
    ],
)
def test_a_verb_imports_what_it_uses(folder: Path, arguments: str, imported: set[str]) -> None:
    result, found = run_watched(folder, *arguments.split())
    assert result.code == 0, result.err
    assert found == imported


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        ("browse --db a.db", "viewer"),
        ("explore --sides 2,2,2,2 --db a.db", "viewer"),
        ("surface triangle.json --view", "viewer"),
        ("features square.vtk --view", "viewer"),
        (f"retopo {EXAMPLES / 'jug.obj'}", "viewer"),
        ("shape-model edit a.npz --drag a=0,0,1 --view", "viewer"),
        ("ingest square.vtk --db b.db", "viewer"),
        ("surface triangle.json --find-cycles -o a.obj", "sketch"),
        ("retopo --script a.jsonl -o a.obj", "sketch"),
        ("query --sides 2,2,2,2 --db a.db --solver cp-sat", "sketch"),
        ("ingest a.usd --db b.db", "usd"),
        ("ingest square.vtk --db b.db --scheduler local:2", "dask"),
    ],
)
def test_a_verb_whose_extra_lacks_says_what_installs_it(
    folder: Path, arguments: str, extra: str
) -> None:
    (folder / "a.usd").write_text("#usda 1.0\n")
    (folder / "a.jsonl").write_text('{"tool": "open", "surface": "square.obj"}\n')
    result, _ = run_watched(folder, *arguments.split(), without=EXTRAS[extra].packages)
    assert result.code == 3 and result.out == ""
    assert EXTRAS[extra].install in result.err
    assert "Traceback" not in result.err and "unforeseen" not in result.err
    assert not (folder / "b.db").exists()


def test_flat_pictures_are_drawn_without_any_extra(folder: Path) -> None:
    without = tuple(package for extra in EXTRAS.values() for package in extra.packages)
    for arguments in (
        "query --sides 2,2,2,2 --db a.db --limit 2 --image fills.png",
        "gallery --class 4 --db a.db -o sheet.png",
        "browse --db a.db -o page.png",
    ):
        result, _ = run_watched(folder, *arguments.split(), without=without)
        assert result.code == 0, result.err
        drawn = folder / arguments.split()[-1]
        assert drawn.read_bytes().startswith(b"\x89PNG")


def test_pictures_in_space_name_the_extra_before_any_work(folder: Path) -> None:
    for arguments in (
        "explore --sides 2,2,2,2 --db a.db -o fill.png",
        "surface triangle.json --picture surface.png",
    ):
        result, _ = run_watched(folder, *arguments.split(), without=EXTRAS["viewer"].packages)
        assert result.code == 3 and "extra viewer" in result.err
        assert not (folder / arguments.split()[-1]).exists()


def test_the_extras_are_those_of_the_package() -> None:
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    offered = project["optional-dependencies"]
    assert set(offered) - {"all", "benchmark", "dev"} == set(EXTRAS)
    assert offered["all"] == [f"patterndb[{','.join(EXTRAS)}]"]
    homes = packages_distributions()
    for extra in EXTRAS.values():
        named = {line.partition(">")[0] for line in offered[extra.name]}
        for package in extra.packages:
            assert named & set(homes.get(package, [])), f"{extra.name} does not bring {package}"
    needed = {line.partition(">")[0] for line in project["dependencies"]}
    assert not needed & {line.partition(">")[0] for e in EXTRAS for line in offered[e]}
