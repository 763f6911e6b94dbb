"""Spines drawn anywhere: how many of them are accepted.

    python benchmarks/retopo_spines.py --shared ../shared [--strokes 25] [--seed 1] [SURFACE ...]

Draws random strokes, each on the bare surface, twice as long as the spine is wide: from a place
chosen by area, straight ahead in a direction chosen evenly. At the default width, at half and at a
quarter of it. "smooth" are strokes beside which the surface is smooth at that width: within half a
width of the stroke to either side, and along it from end to end of the patch, its triangles turn by
less than 60 degrees from those under the stroke there, and no border is. "off" is the greatest
distance of the new curves from half a width beside the stroke, in parts of it, the median over
smooth strokes that were accepted: how well widths are kept. Beside surfaces of the shared folder
the jug of the examples and balls of few and many triangles. Prints Markdown; what was refused on
stderr.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ingest.formats import read_mesh
from patterndb.geometry.points import Points, units
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry.proposal import spread_points
from patterndb_sketch.retopo.tools.spine import draw_spine
from patterndb_sketch.retopo.tracing import clean_stroke

ROOT = Path(__file__).parents[1]

SURFACES = (
    "boot",
    "goathead",
    "hand_closed",
    "human_man",
    "koala_low",
    "nefertiti_low",
    "penguin",
    "plane_holes",
    "skull_low",
    "spot",
    "wingnut",
)

#: Half-widths, as parts of the default one.
WIDTHS = (1.0, 0.5, 0.25)

#: A stroke's length in half-widths; steps of a walk to a half-width.
LENGTH, STEPS = 4.0, 10

#: The cosine of the turn that is smooth still.
SMOOTH = 0.5


def make_ball(rounds: int) -> Surface:
    """The unit ball, an icosahedron each of whose triangles is quartered so many times."""
    golden = (1.0 + 5.0**0.5) / 2.0
    vertices = [
        point
        for a in (-1.0, 1.0)
        for b in (-golden, golden)
        for point in ((a, b, 0.0), (0.0, a, b), (b, 0.0, a))
    ]
    points = np.array(vertices)
    near = np.linalg.norm(points[:, None] - points, axis=2) < 2.1
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    corner = units(points)[np.array(faces)]
    outward = np.einsum("tc,tc->t", np.cross(corner[:, 1], corner[:, 2]), corner[:, 0]) > 0.0
    corner = np.where(outward[:, None, None], corner, corner[:, ::-1])
    for _ in range(rounds):
        a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
        ab, bc, ca = units(a + b), units(b + c), units(c + a)
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        corner = np.concatenate([np.stack(part, axis=1) for part in parts])
    rounded = np.round(corner.reshape(-1, 3), 12)
    return Surface.from_arrays(rounded, np.arange(len(rounded)).reshape(-1, 3)).orient()


@dataclass(frozen=True, slots=True)
class RandomWalk:
    """points, directions: (n, 3) on the surface, and where the walk goes there. whole: did it get
    to its end, without a border in its way?"""

    points: Points
    directions: Points
    triangles: np.ndarray
    whole: bool


def walk_ahead(
    surface: Surface, start: Points, direction: Points, length: float, n: int
) -> RandomWalk:
    """Walk straight ahead on a surface in n steps, by steps in the tangent plane and back to it."""
    foot = surface.nearest(start[None])
    points, ways, under = [foot.points[0]], [], [int(foot.triangles[0])]
    step, whole = length / n, True
    way = direction
    for _ in range(n):
        up = foot.normals[0]
        way = units((way - (way @ up) * up)[None])[0]
        ways.append(way)
        ahead = foot.points[0] + step * way
        foot = surface.nearest_facing(ahead[None], up[None])
        if np.linalg.norm(foot.points[0] - points[-1]) < 0.5 * step:
            whole = False
            break
        points.append(foot.points[0])
        under.append(int(foot.triangles[0]))
    ways.append(way)
    return RandomWalk(np.array(points), np.array(ways[: len(points)]), np.array(under), whole)


def is_smooth(surface: Surface, along: RandomWalk, half_width: float) -> bool:
    """Is the surface smooth beside a walk, as far as a spine of this half-width reaches?"""
    if not along.whole:
        return False
    corner = surface.vertices[surface.triangles]
    faces = units(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    for k in range(0, len(along.points), 4):
        up = faces[along.triangles[k]]
        for side in (-1.0, 1.0):
            beside = walk_ahead(
                surface,
                along.points[k],
                side * np.cross(along.directions[k], up),
                half_width,
                STEPS,
            )
            if not beside.whole or (faces[beside.triangles] @ up < SMOOTH).any():
                return False
    turned = np.einsum("nc,nc->n", faces[along.triangles[1:]], faces[along.triangles[:-1]])
    return bool((turned > SMOOTH).all())


def measure_off(curves: list[Points], line: Points, half_width: float) -> float:
    """The greatest distance of a patch's flanks from half a width beside the stroke."""
    points = np.concatenate(curves)
    far = np.linalg.norm(points[:, None] - line, axis=2).min(axis=1)
    return float(np.abs(far.max() / half_width - 1.0))


def count_accepted(
    surface: Surface, share: float, strokes: int, seed: int
) -> tuple[int, int, int, list[float], Counter[str]]:
    """Accepted of all strokes; smooth ones, and accepted of these; how far off these are, and why
    others were refused."""
    sizes = Sizes.of(surface.diagonal)
    sizes = replace(sizes, spine=share * sizes.spine)
    rng = np.random.default_rng(seed)
    places = spread_points(surface, 40 * strokes)
    accepted = smooth = both = 0
    off: list[float] = []
    why: Counter[str] = Counter()
    for start in places[rng.choice(len(places), strokes, replace=False)]:
        length = LENGTH * sizes.spine
        along = walk_ahead(surface, start, rng.normal(size=3), length, int(LENGTH) * STEPS)
        clean = is_smooth(surface, along, sizes.spine)
        smooth += clean
        stroke = clean_stroke(along.points, surface, sizes, False)
        network = Network(longest=2.0 * surface.diagonal)
        try:
            edit = draw_spine(network, surface, stroke, sizes)
        except RefusedError as error:
            why[("smooth: " if clean else "") + str(error)] += 1
            continue
        accepted += 1
        both += clean
        if clean:
            chains = edit.network.chains.values()
            off.append(measure_off([c.points for c in chains], stroke.points, sizes.spine))
    return accepted, smooth, both, off, why


def main() -> None:
    """Draw on all surfaces that are named, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--strokes", type=int, default=25)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("surfaces", nargs="*", default=("jug", "ball 80", "ball 1280", *SURFACES))
    options = parser.parse_args()
    print("| surface | triangles | width | accepted | of smooth | off |\n|---|" + "---:|" * 5)
    for name in options.surfaces:
        if name.startswith("ball"):
            surface = make_ball(round(np.log(int(name.split()[1]) / 20.0) / np.log(4.0)))
        else:
            there = ROOT / "examples" if name == "jug" else options.shared / "data" / "surfaces"
            path = there / f"{name}.obj"
            if not path.is_file():
                print(f"{name}: {path} is not there", file=sys.stderr)
                continue
            surface = Surface.from_polygons(read_mesh(path)).orient()
        for share in WIDTHS:
            accepted, smooth, both, off, why = count_accepted(
                surface, share, options.strokes, options.seed
            )
            print(
                f"| {name} | {len(surface.triangles):,} | {share:g} | {accepted} of "
                f"{options.strokes} | {both} of {smooth} | "
                f"{np.median(off) if off else np.nan:.2f} |",
                flush=True,
            )
            for text, times in why.most_common():
                print(f"{name} {share:g}: {times} x {text}", file=sys.stderr)


if __name__ == "__main__":
    main()
