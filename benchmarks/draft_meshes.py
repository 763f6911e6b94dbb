"""First drafts of every mesh that there is: artists', vehicles from CAD, scanned surfaces.

    python benchmarks/draft_meshes.py --shared ../shared [--all] [FILE.obj ...]

Each mesh is cut into triangles and drafted at the default edge, after one for nothing (the
database is unpacked). A draft is done if every patch has quads, none is flipped and no
edge tangled, the quads are within 2 % of the diagonal both ways, open edges lie along the rims of
the surface and rims along open edges (that is what "rims" measures: the greatest distance, in
percent), and the Euler number is the surface's, parted where it touches itself. What is not is
faulty, and says why. A refusal is to name a place.

Prints Markdown: what came of all, and the rows of those that are not done; with --all of all.
"""

from __future__ import annotations

import argparse
import re
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

import patterndb
from ingest.formats import read_mesh
from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.frames import TangentFrames
from patterndb_sketch.retopo.draft.manifold import part_touching
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling.mesh import find_open_edges
from patterndb_sketch.retopo.filling.report import report_mesh
from query.engine import PatternSource

ROOT = Path(__file__).parents[1]
FOLDERS = ("meshes", "surfaces", "cad")

#: What a draft may be off, in parts of the diagonal.
MOST_OFF = 0.02

#: A draft that takes longer, by the processor, is slow.
SLOW = 10.0

#: Points along an edge of a rim.
ALONG = np.linspace(0.0, 1.0, 9)[:, None, None]

PLACE = re.compile(r"\(-?\d\S*, -?\d\S*, -?\d\S*\)")
HEAD = (
    "| mesh | triangles | what | patches | quads | irregular | unfilled | flipped | open | rims % "
    "| Euler | off to % | off from % | s cpu |\n|---|---:|---|" + "---:|" * 11
)


@dataclass(frozen=True)
class Row:
    """What came of a mesh: done, faulty, refused, unread or an error, why, and figures."""

    name: str
    triangles: int
    what: str
    why: str
    figures: str
    seconds: float

    def format(self) -> str:
        said = self.what + (f": {self.why}" if self.why else "")
        figures = self.figures or "| " * 10
        return f"| {self.name} | {self.triangles:,} | {said} {figures}| {self.seconds:.1f} |"


def measure_rims(mesh_points: Points, ends: np.ndarray, surface: Surface) -> float:
    """The greatest distance of open edges from the surface's rims, and of these from those, in
    parts of the diagonal; 0 where there are neither, infinite where one has none."""
    border = surface.adjacency.border
    tail = surface.triangles.ravel()[border]
    head = surface.triangles[border // 3, (border % 3 + 1) % 3]
    rims = surface.vertices[np.stack([tail, head], axis=1)]
    edges = mesh_points[ends]
    if not len(rims) or not len(edges):
        return 0.0 if len(rims) == len(edges) else np.inf
    one, two = (
        ((1.0 - ALONG) * line[:, 0] + ALONG * line[:, 1]).reshape(-1, 3) for line in (rims, edges)
    )
    off = max(KDTree(one).query(two)[0].max(), KDTree(two).query(one)[0].max())
    return float(off) / surface.diagonal


def draft_mesh(path: Path, source: PatternSource) -> Row:
    """Draft the mesh of a file, and see what came of it."""
    try:
        surface = Surface.from_polygons(read_mesh(path)).orient()
    except PatternDBError as error:
        return Row(path.stem, 0, "unread", str(error), "", 0.0)
    n = len(surface.triangles)
    editor = Retopology(surface, source)
    began = time.process_time()
    try:
        outcome = editor.do(Call("draft"))
    except Exception as error:  # any is a row of the table
        spent = time.process_time() - began
        return Row(path.stem, n, "error", f"{type(error).__name__}: {error}", "", spent)
    spent = time.process_time() - began
    if outcome.refused is not None:
        what = "refused" if PLACE.search(outcome.refused) else "refused without a place"
        return Row(path.stem, n, what, outcome.refused, "", spent)
    found = editor.fill()
    mesh = editor.mesh(found)
    made = report_mesh(found, surface, mesh)
    sides = 1 if editor.state.plane is None else 2
    parted = part_touching(surface).surface
    rims = measure_rims(mesh.vertices, np.asarray(find_open_edges(mesh)).reshape(-1, 2), parted)
    off = max(made.to_surface, made.from_surface)
    euler = TangentFrames.of(parted).euler
    faults = {
        f"{made.unfilled} unfilled": made.unfilled,
        f"{made.flipped * sides} flipped": made.flipped,
        f"{made.tangled} tangled": made.tangled,
        f"{100 * off:.1f} % off": off > MOST_OFF,
        f"open edges {100 * rims:.1f} % off the rims": rims > MOST_OFF,
        f"Euler number {made.euler} for {euler}": made.euler != euler,
        f"{spent:.0f} s": spent > SLOW,
    }
    why = ", ".join(said for said, wrong in faults.items() if wrong)
    figures = (
        f"| {sides * sum(made.patches.values())} | {made.quads:,} | {sum(made.irregular.values())} "
        f"| {made.unfilled} | {made.flipped * sides} | {made.open_edges} | {100 * rims:.2f} "
        f"| {made.euler} | {100 * made.to_surface:.2f} | {100 * made.from_surface:.2f} "
    )
    if not why and outcome.notes:
        # Such as edges of another length, or what touches.
        why = "; ".join(note for note in outcome.notes if "irregular vertices" not in note)
    return Row(path.stem, n, "faulty" if any(faults.values()) else "done", why, figures, spent)


def main() -> None:
    """Draft all meshes, and print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--all", action="store_true", help="rows of those that are done, too")
    parser.add_argument("files", nargs="*", type=Path)
    options = parser.parse_args()
    folders = [options.shared / "data" / folder for folder in FOLDERS]
    files = options.files or [path for folder in folders for path in sorted(folder.glob("*.obj"))]
    counts: Counter[tuple[str, str]] = Counter()
    print(HEAD)
    with patterndb.open() as database:
        warm = Surface.from_polygons(read_mesh(ROOT / "examples" / "dog.obj")).orient()
        Retopology(warm, database).do(Call("draft"))
        for path in files:
            row = draft_mesh(path, database)
            counts[path.parent.name, row.what] += 1
            if options.all or row.what != "done":
                print(row.format(), flush=True)
    print("\n| folder | what | meshes |\n|---|---|---:|")
    for (folder, what), count in sorted(counts.items()):
        print(f"| {folder} | {what} | {count} |")


if __name__ == "__main__":
    main()
