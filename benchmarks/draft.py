"""First drafts of whole surfaces, beside QuadriFlow.

    python benchmarks/draft.py --shared ../shared [--quadriflow PYTHON] [SURFACE | FILE.obj ...]

Drafts every surface of a body or creature in the shared folder at the default edge, after one for
nothing (kernels are compiled, the database unpacked). "irregular" are vertices whose number of
quads is not 4; "off" the greatest distance of the quads from the surface and of the surface from
the quads, at samples, in percent of its diagonal; "spirals" the closed strips of quads that pass
a quad twice, of all closed strips; "s" seconds of drafting by the processor and by the clock.

With --quadriflow, a Python that has pyQuadriFlow (0.0.4 was used; not a dependency), QuadriFlow
(Huang et al. 2018) is asked for as many quads as the draft has, in the same run; it counts faces
in its own way, so that its quads differ by some. Prints Markdown.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import patterndb
from ingest.formats import read_mesh
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb_sketch.retopo.editor import Call, Editor
from patterndb_sketch.retopo.filling.report import hausdorff, report_mesh
from patterndb_sketch.retopo.ground import Ground

ROOT = Path(__file__).parents[1]

#: Bodies and creatures; then what is expected to be hard or refused.
SURFACES = (
    "spot",
    "penguin",
    "hand_closed",
    "human_man",
    "koala_low",
    "goathead",
    "nefertiti_low",
    "skull_low",
    "wingnut",
    "boot",
    "plane_holes",
)

HEAD = (
    "| surface | by | patches | quads | irregular | flipped | open edges | Euler | off to % | "
    "off from % | spirals | s cpu | s clock |\n|---|---|" + "---:|" * 11
)

#: What the other Python runs: a mesh in, QuadriFlow's quads and its seconds out.
QUADRIFLOW = """
import sys, time
import numpy as np
from pyQuadriFlow.pyQuadriFlow import pyquadriflow
given = np.load(sys.argv[1])
began = time.process_time(), time.perf_counter()
made = pyquadriflow(
    int(sys.argv[3]), 0, given["vertices"], given["triangles"], False, False, False, False, False
)
seconds = time.process_time() - began[0], time.perf_counter() - began[1]
np.savez(sys.argv[2], vertices=made["vertices"], quads=made["faces"], seconds=seconds)
"""


def count_spirals(quads: Int32Array) -> tuple[int, int]:
    """The closed strips of quads that pass a quad twice, and all closed strips."""
    tail, head = quads.ravel().astype(np.int64), np.roll(quads, -1, axis=1).ravel().astype(np.int64)
    key = (np.minimum(tail, head) << 32) | np.maximum(tail, head)
    order = np.argsort(key, kind="stable")
    twin = np.full(len(key), -1)
    same = np.flatnonzero(key[order][1:] == key[order][:-1])
    twin[order[same]], twin[order[same + 1]] = order[same + 1], order[same]
    seen = np.zeros(len(key), bool)
    spirals = closed = 0
    for first in range(len(key)):
        if seen[first]:
            continue
        strip: list[int] = []
        side = first
        while side >= 0 and not seen[side]:
            # Into the quad by one side, out by the opposite one.
            out = 4 * (side // 4) + (side + 2) % 4
            seen[side] = seen[out] = True
            strip.append(side // 4)
            side = int(twin[out])
        if side == first:
            closed += 1
            spirals += len(set(strip)) < len(strip)
    return spirals, closed


def format_row(
    name: str,
    by: str,
    patches: str,
    vertices: Points,
    quads: Int32Array,
    flipped: str,
    seconds: tuple[float, float],
    ground: Ground,
) -> str:
    """The table's row of a mesh of quads."""
    tail, head = quads.ravel().astype(np.int64), np.roll(quads, -1, axis=1).ravel().astype(np.int64)
    key = (np.minimum(tail, head) << 32) | np.maximum(tail, head)
    edges, uses = np.unique(key, return_counts=True)
    valence = np.bincount(quads.ravel(), minlength=len(vertices))
    border = np.zeros(len(vertices), bool)
    lone = edges[uses == 1]
    border[lone >> 32] = border[lone & 0xFFFFFFFF] = True
    irregular = int(((valence != np.where(border, 2, 4)) & (valence > 0)).sum())
    euler = int((valence > 0).sum()) - len(edges) + len(quads)
    to, back = hausdorff(vertices, quads, ground)
    spirals, closed = count_spirals(quads)
    cells = (
        name,
        by,
        patches,
        f"{len(quads):,}",
        f"{irregular}",
        flipped,
        f"{len(lone)}",
        f"{euler}",
        f"{100 * to:.2f}",
        f"{100 * back:.2f}",
        f"{spirals} of {closed}",
        f"{seconds[0]:.1f}",
        f"{seconds[1]:.1f}",
    )
    return "| " + " | ".join(cells) + " |"


def run_quadriflow(
    python: str, ground: Ground, faces: int
) -> tuple[Points, Int32Array, tuple[float, float]]:
    """QuadriFlow's mesh with about so many quads, and its seconds by processor and by clock."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(given, vertices=ground.vertices, triangles=ground.triangles)
        command = [python, "-c", QUADRIFLOW, str(given), str(made), str(faces)]
        subprocess.run(command, check=True, capture_output=True)
        found = np.load(made, allow_pickle=False)
        cpu, clock = found["seconds"].tolist()
        return found["vertices"].astype(float), found["quads"].astype(np.int32), (cpu, clock)


def main() -> None:
    """Draft all surfaces that are named, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--quadriflow", metavar="PYTHON", help="a Python that has pyQuadriFlow")
    parser.add_argument("surfaces", nargs="*", default=SURFACES)
    options = parser.parse_args()
    with patterndb.open() as database:
        warm = Ground.of_polygons(read_mesh(ROOT / "examples" / "dog.obj"))
        Editor(warm, database).do(Call("draft"))
        print(HEAD)
        for name in options.surfaces:
            path = options.shared / "data" / "surfaces" / f"{name}.obj"
            if name.endswith(".obj"):
                path, name = Path(name), Path(name).stem
            if not path.is_file():
                print(f"{name}: {path} is not there", file=sys.stderr)
                continue
            ground = Ground.of_polygons(read_mesh(path))
            editor = Editor(ground, database)
            began = time.process_time(), time.perf_counter()
            outcome = editor.do(Call("draft"))
            seconds = time.process_time() - began[0], time.perf_counter() - began[1]
            if outcome.refused is not None:
                print(f"| {name} | refused in {seconds[1]:.1f} s: {outcome.refused} |" + " |" * 11)
                continue
            for note in outcome.notes:
                print(f"{name}: {note}", file=sys.stderr)
            found = editor.fill()
            mesh = editor.mesh(found)
            made = report_mesh(found, ground, mesh)
            flipped = made.flipped * (2 if editor.state.plane is not None else 1)
            patches = f"{sum(made.patches.values())}"
            print(
                format_row(
                    name, "draft", patches, mesh.vertices, mesh.quads, f"{flipped}", seconds, ground
                ),
                flush=True,
            )
            if options.quadriflow:
                vertices, quads, spent = run_quadriflow(options.quadriflow, ground, len(mesh.quads))
                print(
                    format_row(name, "QuadriFlow", "", vertices, quads, "", spent, ground),
                    flush=True,
                )


if __name__ == "__main__":
    main()
