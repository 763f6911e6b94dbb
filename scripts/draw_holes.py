"""Draw the pictures of docs/holes.md.

    python scripts/draw_holes.py --out docs/images

A hole before and after, six of its fills, caps of simple bodies, and holes cut from the examples
whose own fill is not the first: what was there beside what is proposed. The starter database
answers; it has not learned the examples, and mirror twins are not looked for.
"""

from __future__ import annotations

import argparse
from itertools import islice
from pathlib import Path

import numpy as np
from cut_holes import Cut, cut_holes, read_topology

import patterndb
from patterndb._native.query.recognition import weld_quads
from patterndb.store import Database
from query.holes import HoleFill, fill_holes
from query.recognition import hash_quads
from viewer.camera import fit_view
from viewer.holes import (
    HALF,
    REMOVED,
    HolePanel,
    choose_view,
    draw_holes,
    draw_panels,
    show_fills,
    show_holes,
)

ROOT = Path(__file__).resolve().parents[1]

#: A vertex of the hole on the nose of docs/meshes/head.obj.
NOSE = 36

#: Holes cut from each example in search of misses, and misses that are drawn.
PER_MESH, DRAWN = 16, 3


def key_of(fill: HoleFill) -> bytes:
    """What tells a fill from any other of its loop."""
    n = len(fill.hole)
    twin, _ = weld_quads(fill.local, n + len(fill.points), n)
    return hash_quads(fill.local, twin, False)


def find_misses(db: Database) -> list[tuple[Cut, HoleFill, int | None]]:
    """Holes of the examples whose own fill is not the first: the first, and its own place."""
    found: list[tuple[Cut, HoleFill, int | None]] = []
    asked = 0
    for name in ("head", "hand", "dog"):
        topology = read_topology(str(ROOT / "examples" / f"{name}.obj"))
        for cut in cut_holes(name, topology, PER_MESH, 1):
            listed = list(fill_holes(db, cut.hole, limit=20, twins=False))
            keys = [key_of(fill) for fill in listed]
            asked += 1
            if keys[0] != cut.key:
                place = keys.index(cut.key) + 1 if cut.key in keys else None
                found.append((cut, listed[0], place))
    print(f"{len(found)} of {asked} holes of the examples have another fill first")
    return found


def draw_misses(path: Path, misses: list[tuple[Cut, HoleFill, int | None]]) -> None:
    """Draw what was there beside what is proposed, a row a hole."""
    for number, (cut, fill, place) in enumerate(misses[:DRAWN], 1):
        mesh = cut.hole.topology.mesh
        marked = np.zeros(mesh.n_faces, np.bool_)
        marked[cut.hole.removed] = True
        where = "not among twenty" if place is None else f"number {place}"
        own = HolePanel(mesh, marked, REMOVED, "#8a4b00", f"what was there: {where}")
        panels = [own, show_fills([fill], "proposed first")]
        draw_panels(path.with_stem(f"{path.stem}-{number}"), panels, choose_view([fill]), 2, 460)


#: Bodies whose upper end is open: edges around, and the radius and height of each circle.
BODIES = (
    ("a box", 4, [(1.0, 0.0), (1.0, 1.4)]),
    ("6 edges", 6, [(1.0, 0.0), (1.0, 0.7), (1.0, 1.4)]),
    ("12 edges", 12, [(1.0, 0.0), (1.0, 0.7), (1.0, 1.4)]),
    ("16 edges", 16, [(1.0, 0.0), (1.0, 0.7), (1.0, 1.4)]),
    (
        "a bottle",
        16,
        [(1, 0), (1, 0.8), (0.9, 1.1), (0.7, 1.3), (0.5, 1.5), (0.45, 1.7), (0.45, 2)],
    ),
    ("a ball", 16, [(np.sin(t), -np.cos(t)) for t in np.pi * np.arange(1, 9) / 12]),
)


def draw_caps(path: Path, db: Database) -> None:
    """Draw the first fills of the upper ends of bodies, all looked at alike."""
    panels: list[HolePanel] = []
    for title, n, circles in BODIES:
        at = 2 * np.pi * (np.arange(n) + 0.5) / n
        rim = np.stack([np.cos(at), np.sin(at)], axis=1)
        points = np.vstack([np.c_[r * rim, np.full(n, z - circles[-1][1])] for r, z in circles])
        quads = [
            [k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i]
            for k in range(len(circles) - 1)
            for i in range(n)
        ]
        mesh = patterndb.PolygonMesh.from_faces(points, quads)
        fill = next(fill_holes(db, mesh, loop=[len(points) - 1], twins=False))
        lies = "flat" if fill.flat else "smooth"
        count = "one quad" if fill.n_quads == 1 else f"{fill.n_quads} quads"
        panels.append(show_fills([fill], f"{title}: {count}, {lies}"))
    # All alike: from above, in a box around the largest of them.
    box = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1.4, 0.4)])
    view = fit_view(box, (0.35, -0.8, 0.75), (0.0, 0.0, 1.0), HALF, HALF)
    draw_panels(path, panels, view, 3, 620)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    out: Path = parser.parse_args().out
    with patterndb.open() as db:
        mesh = patterndb.read(ROOT / "docs" / "meshes" / "head.obj")
        fills = list(islice(fill_holes(db, mesh, loop=[NOSE]), 6))
        draw_holes(out / "holes-nose.png", fills[:1], 520)
        panels = [
            show_fills([fill], f"{number}: {fill.n_quads} quads, {fill.n_irregular} irregular")
            for number, fill in enumerate(fills, 1)
        ]
        draw_panels(out / "holes-choices.png", panels, choose_view(fills[:1]), 3, 540)
        draw_caps(out / "holes-caps.png", db)
        cheek = next(fill_holes(db, mesh, loop=[475]))
        draw_panels(
            out / "holes-twin.png",
            [show_holes([cheek], "a hole on a cheek"), show_fills([cheek])],
            choose_view([cheek]),
            2,
            520,
        )
        draw_misses(out / "holes-miss.png", find_misses(db))


if __name__ == "__main__":
    main()
