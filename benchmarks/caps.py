"""Flat or smooth: is the shape that a hole's fill gets by itself the artist's?

    python benchmarks/caps.py ../shared/data/meshes
    options: --per-mesh 80  --seed 92  --fills

Regions are cut from artists' meshes: those that creases bound (edges of more than 40 degrees), and
faces and vertices grown up to three times. Their own quads are placed smoothly and in the plane of
their boundary; whichever is nearer to where the artist's vertices lie, across the plane, is right.
Counted are regions for which it matters: the two differ by more than 2 % of the boundary's
diameter, and the better one is within 10 % (what a whole limb is, no boundary shows). The rule was
tuned on the first half of the families of meshes; the second half has had no part in it.

With --fills flat caps at creases are filled, by the ranking alone (shape smooth) and as the program
does: how often is the artist's own fill first, and among five? The models that come with the
package have seen some of these meshes. Prints Markdown.
"""

from __future__ import annotations

import argparse
import random
import sys
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

import patterndb
from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from query.holes import fill_holes
from query.holes.caps import FlatCap, RimPlane, find_cap, measure_walls
from query.holes.neighbourhood import extract_neighbourhood
from query.holes.projection import place_fill
from query.holes.topology import MeshTopology
from query.recognition import hash_quads

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
from cut_holes import Cut, make_cut, read_topology
from train_holes import deal_folds, list_families

#: Edges whose faces turn by more than this are creases, in radians.
CREASE = np.radians(40.0)

#: The most faces of a region at creases, and of another one.
MOST_AT_CREASES, MOST_GROWN = 400, 120

#: Parts of the diameter: boundaries farther from their plane are smooth for all rules; where flat
#: and smooth differ by less it does not matter; where the better one is farther off it is no
#: evidence.
FARTHEST_OFF, MATTERS, EVIDENCE = 0.06, 0.02, 0.1

#: Caps of a mesh that are filled with --fills.
FILLED = 4


@dataclass(frozen=True, slots=True, eq=False)
class CapCase:
    """A region that was cut. flat, smooth: the greatest distance of the artist's vertices, across
    the boundary's plane, from the plane and from a smooth fill, as parts of the diameter."""

    cut: Cut
    half: int
    at_creases: bool
    plane: RimPlane
    cap: FlatCap | None
    flat: float
    smooth: float


def list_regions(
    name: str, topology: MeshTopology, at: dict[int, list[int]], most: int, seed: int
) -> Iterator[tuple[bool, frozenset[int]]]:
    """Regions that creases bound, and up to ``most`` that are grown."""
    t = topology
    points = t.mesh.points
    normals = np.zeros((t.mesh.n_faces, 3))
    np.add.at(normals, t.face, np.cross(points[t.tail], points[t.head]))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    joined = t.twin >= 0
    cosine = (normals[t.face] * normals[t.face[t.twin]]).sum(axis=1)
    joined &= cosine > np.cos(CREASE)
    pairs = (np.ones(joined.sum()), (t.face[joined], t.face[t.twin[joined]]))
    n = t.mesh.n_faces
    _, piece = connected_components(csr_array(pairs, shape=(n, n)), directed=False)
    order = np.argsort(piece, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(piece[order])) + 1):
        if len(group) <= MOST_AT_CREASES:
            yield True, frozenset(group.tolist())
    draw = random.Random(seed * 1_000_003 + zlib.crc32(name.encode()))
    corners = t.mesh.faces()
    seen: set[frozenset[int]] = set()
    for _ in range(20 * most):
        if len(seen) >= most:
            break
        first = draw.randrange(n)
        region = {first} if draw.random() < 0.5 else set(at[draw.choice(corners[first])])
        for _ in range(draw.randint(0, 3)):
            region |= {g for f in region for v in corners[f] for g in at[v]}
            if len(region) > 2 * MOST_GROWN:
                break
        chosen = frozenset(region)
        if len(chosen) <= MOST_GROWN and chosen not in seen:
            seen.add(chosen)
            yield False, chosen


def faces_at_vertices(topology: MeshTopology) -> dict[int, list[int]]:
    """The faces at every vertex."""
    found: dict[int, list[int]] = {}
    for f, face in enumerate(topology.mesh.faces()):
        for v in face:
            found.setdefault(v, []).append(f)
    return found


def cut_case(
    name: str,
    half: int,
    topology: MeshTopology,
    at: dict[int, list[int]],
    at_creases: bool,
    faces: frozenset[int],
) -> CapCase | None:
    """Cut a region and place its own quads; None unless it is a disk of quads near a plane."""
    if (topology.mesh.arities()[sorted(faces)] != 4).any():
        return None
    cut = make_cut(name, topology, faces, at, 4)
    if cut is None:
        return None
    plane = RimPlane.of(cut.hole.points)
    if plane.off > FARTHEST_OFF or plane.diameter <= 0:
        return None
    own = topology.mesh.points[cut.inner]
    placed = place_fill(extract_neighbourhood(cut.hole), cut.quads, len(cut.hole) + len(own)).points

    def measure_off(apart: NDArray[np.float64]) -> float:
        return float(np.abs(apart @ plane.normal).max(initial=0.0)) / plane.diameter

    flat, smooth = measure_off(own - plane.centre), measure_off(own - placed)
    return CapCase(cut, half, at_creases, plane, find_cap(cut.hole), flat, smooth)


def is_steep_to_one_side(case: CapCase) -> bool:
    """Do all faces outside leave the plane by 35 degrees or more, to one side?"""
    walls = measure_walls(case.cut.hole, case.plane)
    return len(walls.angle) > 0 and bool((np.sin(walls.angle) >= np.sin(np.radians(35.0))).all())


RULES = {
    "always smooth": lambda case: False,
    "always flat": lambda case: True,
    "planar within 1 %": lambda case: case.plane.off <= 0.01,
    "planar within 1 %, or within 3 % and steep to one side": lambda case: (
        case.plane.off <= 0.01 or (case.plane.off <= 0.03 and is_steep_to_one_side(case))
    ),
    "auto": lambda case: case.cap is not None,
    "the better one": lambda case: case.flat < case.smooth,
}


def print_decisions(cases: list[CapCase]) -> None:
    """Print how often each rule is right, and how far off what it chooses is."""
    decisions = [
        case
        for case in cases
        if len(case.cut.inner)
        and abs(case.flat - case.smooth) > MATTERS
        and min(case.flat, case.smooth) <= EVIDENCE
    ]
    for title, half in (("all", None), ("first half: tuned", 0), ("second half: left out", 1)):
        chosen = [case for case in decisions if half is None or case.half == half]
        flat = np.array([case.flat for case in chosen])
        smooth = np.array([case.smooth for case in chosen])
        creases = np.array([case.at_creases for case in chosen])
        meshes = len({case.cut.mesh for case in chosen})
        print(f"\n{title}: {len(chosen)} regions of {meshes} meshes, {creases.sum()} at creases\n")
        print("| rule | right | at creases | elsewhere | off, mean | at creases | at 95 % |")
        print("|---|--:|--:|--:|--:|--:|--:|")
        for name, rule in RULES.items():
            is_flat = np.array([rule(case) for case in chosen])
            right = is_flat == (flat < smooth)
            off = 100 * np.where(is_flat, flat, smooth)
            print(
                f"| {name} | {right.mean():.3f} | {right[creases].mean():.3f} | "
                f"{right[~creases].mean():.3f} | {off.mean():.1f} % | "
                f"{off[creases].mean():.1f} % | {np.percentile(off, 95):.1f} % |"
            )


def key_of(quads: Int32Array, n_vertices: int, n: int) -> bytes:
    """Return the key of a fill of a loop of n edges."""
    return hash_quads(quads, weld_quads(quads, n_vertices, n)[0], False)


def print_fills(cases: list[CapCase]) -> None:
    """Print how often the artist's own fill of a flat cap is first, and among five."""
    caps = [c for c in cases if c.at_creases and c.cap is not None and c.cap.apart]
    ranks: dict[str, dict[str, list[int]]] = {}
    filled: dict[str, int] = {}
    with patterndb.open() as db:
        for case in caps:
            mesh = case.cut.mesh
            filled[mesh] = filled.get(mesh, 0) + 1
            if case.flat > MATTERS or filled[mesh] > FILLED:
                continue
            n, quads = len(case.cut.hole), len(case.cut.quads)
            kind = "one quad" if quads == 1 else "one row" if not len(case.cut.inner) else "other"
            for shape in ("smooth", "auto"):
                listed = fill_holes(db, case.cut.hole, limit=5, twins=False, shape=shape)
                keys = [key_of(fill.local, n + len(fill.points), n) for fill in listed]
                rank = keys.index(case.cut.key) if case.cut.key in keys else 5
                ranks.setdefault(kind, {}).setdefault(shape, []).append(rank)
    print("\n| flat caps | | ranking alone: first | among five | auto: first | among five |")
    print("|---|--:|--:|--:|--:|--:|")
    for kind, by_shape in ranks.items():
        cells = [f"{np.mean(np.array(r) < k):.3f}" for r in by_shape.values() for k in (1, 5)]
        print(f"| {kind} | {len(by_shape['auto'])} | " + " | ".join(cells) + " |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--per-mesh", type=int, default=80)
    parser.add_argument("--seed", type=int, default=92)
    parser.add_argument("--fills", action="store_true")
    given = parser.parse_args()
    halves = deal_folds(list_families(given.folder), 2, 5)
    cases: list[CapCase] = []
    for path, half in sorted((path, half) for half, fold in enumerate(halves) for path in fold):
        topology = read_topology(str(path))
        at = faces_at_vertices(topology)
        regions = list_regions(path.name, topology, at, given.per_mesh, given.seed)
        for at_creases, faces in regions:
            case = cut_case(path.name, half, topology, at, at_creases, faces)
            if case is not None:
                cases.append(case)
        print(f"{path.name}: {len(cases)} regions", file=sys.stderr, flush=True)
    print_decisions(cases)
    if given.fills:
        print_fills(cases)


if __name__ == "__main__":
    main()
