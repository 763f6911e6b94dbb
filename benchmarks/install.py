"""What an installation costs: megabytes, packages, and the seconds to a first answer.

    python -m build --outdir dist .
    python benchmarks/install.py dist/patterndb-*.whl

Each row is a new environment (``python -m venv``) with a new pip cache, a new user cache folder and
nothing of this checkout in reach: the wheel alone, with [viewer], with [all], and beside them
sqlite-utils with datasette, trimesh, and pyvista, each with a first answer of its own kind.

- download: megabytes of the wheels that ``pip download`` fetches.
- installed: megabytes in site-packages, byte code included, without pip and setuptools.
- first answer: wall and CPU seconds of a first run in that environment, of all its processes; what
  patterndb unpacks is in it. again: the same a second time.
- memory: the greatest resident set of a process of the first run, in megabytes.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

#: What trimesh and pyvista are asked: the volume of a box, and a picture of a ball.
BOX = "import trimesh; print(trimesh.creation.box((1, 2, 3)).volume)"
BALL = (
    "import pyvista; p = pyvista.Plotter(off_screen=True); "
    "p.add_mesh(pyvista.Sphere()); p.screenshot('ball.png'); print('ball.png')"
)
SQL = "sqlite-utils memory 'select 1 + 1' && datasette --get '/_memory.json?sql=select+1'"
QUERY = "patterndb query --sides 3,5,4,6 --limit 3"
PICTURE = f"{QUERY} --image fills.png"
SURFACE = "patterndb surface teacup.json -o teacup.obj"


@dataclass(frozen=True, slots=True)
class Row:
    """An environment: its name, what pip installs, and the first answer that it gives."""

    name: str
    packages: tuple[str, ...]
    answer: str


@dataclass(frozen=True, slots=True)
class Run:
    """A command's wall and CPU seconds, and the greatest megabytes of one of its processes."""

    wall: float
    cpu: float
    memory: float


def measure(command: str, folder: Path, environment: dict[str, str]) -> Run:
    """Run a shell's command in a child that reports what its children used."""
    script = (
        "import resource, subprocess, sys\n"
        "done = subprocess.run(['sh', '-ec', sys.argv[1]], stdout=subprocess.DEVNULL)\n"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss)\n"
        "sys.exit(done.returncode)\n"
    )
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", script, command],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    wall = time.perf_counter() - began
    cpu, memory = map(float, done.stdout.split())
    return Run(wall, cpu, memory / 1000.0)


def sum_megabytes(folder: Path, names: str = "*", without: tuple[str, ...] = ()) -> float:
    """Megabytes of the files below a folder."""
    return (
        sum(
            path.stat().st_size
            for path in folder.rglob(names)
            if path.is_file() and path.relative_to(folder).parts[0].split("-")[0] not in without
        )
        / 1e6
    )


def measure_row(row: Row, root: Path, python: str) -> str:
    """Make the environment of a row, ask it, and return the row of the table."""
    folder = root / "".join(c for c in row.name if c.isalnum())
    work, wheels, venv = folder / "work", folder / "wheels", folder / "venv"
    work.mkdir(parents=True)
    (work / "teacup.json").write_bytes(
        (Path(__file__).parents[1] / "examples" / "networks" / "teacup.json").read_bytes()
    )
    subprocess.run([python, "-m", "venv", venv], check=True)
    pip = [venv / "bin" / "python", "-m", "pip", "--quiet", "--disable-pip-version-check"]
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("PATTERNDB", "PYTHON"))}
    began = time.perf_counter()
    subprocess.run([*pip, "download", "--dest", wheels, *row.packages], check=True, env=plain)
    subprocess.run(
        [*pip, "install", "--no-index", "--find-links", wheels, *row.packages],
        check=True,
        env=plain,
    )
    installing = time.perf_counter() - began
    listed = subprocess.run(
        [*pip[:3], "list", "--format=freeze"], check=True, capture_output=True, text=True
    )
    names = [n for line in listed.stdout.split() if (n := line.split("=")[0]) not in TOOLS]
    (site,) = (venv / "lib").glob("python3.*/site-packages")
    environment = plain | {
        "PATH": f"{venv / 'bin'}{os.pathsep}{plain['PATH']}",
        "PATTERNDB_CACHE": str(folder / "cache"),
    }
    first = measure(row.answer, work, environment)
    again = measure(row.answer, work, environment)
    # After the first run, which writes what byte code pip has not.
    installed = sum_megabytes(site, without=TOOLS)
    return (
        f"| {row.name} | {sum_megabytes(wheels):.0f} | {installed:.0f} | {len(names)} | "
        f"{installing:.0f} | {first.wall:.1f} | {first.cpu:.1f} | {again.wall:.1f} | "
        f"{first.memory:.0f} |"
    )


#: What every environment has, and no row counts.
TOOLS = ("pip", "setuptools", "_distutils_hack", "pkg_resources", "distutils")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("wheel", type=Path, help="the wheel of patterndb")
    parser.add_argument("--python", default=sys.executable, help="makes the environments")
    parser.add_argument("--only", metavar="WORD", default="", help="rows whose name has this word")
    arguments = parser.parse_args()
    wheel = str(arguments.wheel.resolve())
    rows = (
        Row("patterndb", (wheel,), QUERY),
        Row("patterndb, a picture", (wheel,), PICTURE),
        Row("patterndb[viewer]", (f"{wheel}[viewer]",), PICTURE),
        Row("patterndb[all]", (f"{wheel}[all]",), SURFACE),
        Row("sqlite-utils, datasette", ("sqlite-utils", "datasette"), SQL),
        Row("trimesh", ("trimesh",), f'python -c "{BOX}"'),
        Row("pyvista", ("pyvista",), f'python -c "{BALL}"'),
    )
    print(
        "| environment | download MB | installed MB | packages | installing s | first answer s | "
        "CPU s | again s | memory MB |"
    )
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|", flush=True)
    for row in rows:
        if arguments.only in row.name:
            with tempfile.TemporaryDirectory() as name:
                print(measure_row(row, Path(name), arguments.python), flush=True)


if __name__ == "__main__":
    main()
