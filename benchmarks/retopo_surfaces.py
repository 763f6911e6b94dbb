"""Whole surfaces retopologised by the scripts of examples/retopo/.

    python benchmarks/retopo_surfaces.py --shared ../shared

Plays every script whose surface is there, and measures the mesh that comes out. "irregular" are
vertices whose number of quads is not 4; "to" and "from" are the greatest distances of the quads
from the surface and of the surface from the quads, at samples, in percent of its diagonal.
"max valence" belongs to an inner vertex. Below each, where there is one, stands the mesh that an
artist made for the same surface: it is the control mesh of a subdivision surface, which lies
outside of the surface itself, and is no measure for distances. For scale, Table 1 of Takayama et
al. 2013 has a head of 808 quads in 73 patches, and a hand of 1548 quads in 223 patches. Seconds
are of playing: drawing, counts and fills after every call; the first script is played once before.
Prints Markdown.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.filling import FilledNetwork
from patterndb_sketch.retopo.filling.report import hausdorff, report_mesh
from patterndb_sketch.retopo.script import Script, play_script, read_script

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "examples" / "retopo"

HEAD = (
    "| surface | triangles | calls | patches by corners | quads | irregular | max valence | "
    "flipped | open edges | Euler | to % | from % | s |\n|---|" + "---:|" * 2 + "---|" + "---:|" * 9
)


@dataclass(frozen=True, slots=True)
class Played:
    """A script, and what came of it. seconds: that playing took."""

    script: Script
    surface: Surface
    found: FilledNetwork
    seconds: float


def played(script: Path, data: Path) -> Played | None:
    """Play a script; None if its surface is not there."""
    wanted = read_script(script)
    path = data / "surfaces" / Path(wanted.surface).name
    if not path.is_file():
        return None
    surface = Surface.from_polygons(read_mesh(path)).orient()
    started = time.perf_counter()
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        for line, outcome in play_script(wanted, editor, _no_export):
            for note in outcome.notes:
                print(f"{script.name}, line {line.number}: {note}", file=sys.stderr)
        found = editor.fill()
    return Played(wanted, surface, found, time.perf_counter() - started)


def row(name: str, one: Played) -> str:
    """The table's row of a script."""
    made = report_mesh(one.found, one.surface)
    sides = ", ".join(f"{count} of {corners}" for corners, count in made.patches.items())
    cells = (
        name,
        f"{len(one.surface.triangles):,}",
        f"{len(one.script.lines)}",
        f"{sum(made.patches.values())}: {sides}",
        f"{made.quads}",
        f"{sum(made.irregular.values())}",
        f"{max(made.irregular, default=4)}",
        f"{made.flipped}",
        f"{made.open_edges}",
        f"{made.euler}",
        f"{100 * made.to_surface:.2f}",
        f"{100 * made.from_surface:.2f}",
        f"{one.seconds:.1f}",
    )
    return "| " + " | ".join(cells) + " |"


def artist_row(name: str, path: Path, surface: Surface) -> str:
    """The row of an artist's mesh, closed, of quads and other polygons."""
    mesh = read_mesh(path)
    arities = mesh.arities()
    follower = np.arange(1, len(mesh.corners) + 1)
    follower[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    tail, head = mesh.corners.astype(np.int64), mesh.corners[follower].astype(np.int64)
    pairs = np.minimum(tail, head) << 32 | np.maximum(tail, head)
    _, uses = np.unique(pairs, return_counts=True)
    valence = np.bincount(mesh.corners)
    covered = Surface.from_polygons(mesh)
    # As quads, the last corner twice: what is measured are triangles.
    faces = covered.triangles[:, [0, 1, 2, 2]]
    to, back = hausdorff(covered.vertices, faces, surface)
    others = int((arities != 4).sum())
    cells = (
        f"{name}, the artist's",
        "",
        "",
        "",
        f"{int((arities == 4).sum())}" + (f" and {others} others" if others else ""),
        f"{int(((valence != 4) & (valence > 0)).sum())}",
        f"{valence.max()}",
        "",
        f"{int((uses == 1).sum())}",
        f"{int((valence > 0).sum()) - len(uses) + mesh.n_faces}",
        f"{100 * to:.2f}",
        f"{100 * back:.2f}",
        "",
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("names", nargs="*", help="scripts to play; all without any")
    options = parser.parse_args()
    data = options.shared / "data"
    names = options.names or [path.stem for path in sorted(SCRIPTS.glob("*.jsonl"))]
    # Once for nothing: the database is unpacked.
    first = played(SCRIPTS / f"{names[0]}.jsonl", data)
    if first is not None:
        print(HEAD)
    for name in names:
        one = played(SCRIPTS / f"{name}.jsonl", data)
        if one is None:
            print(f"{name}: its surface is not in {data / 'surfaces'}", file=sys.stderr)
            continue
        print(row(name, one))
        artist = data / "meshes" / Path(one.script.surface).name
        if artist.is_file():
            print(artist_row(artist.stem, artist, one.surface))


def _no_export(name: str, found: FilledNetwork) -> None:
    """Nothing is written: export lines are for users."""


if __name__ == "__main__":
    main()
