"""Curves that leave the crease that their stroke was drawn along, before and after one pin.

    python benchmarks/feature_creases.py --shared ../shared [--strokes 2] [--worst]

On models of vehicles, which are not part of this project, creases are found: chains of edges at
which two triangles bend by more than SHARP, seen from outside, that go on without a turn. On
generated bodies the features are known. Along each a rough stroke is drawn, up to 1 % of the
diagonal off, and snapped. A curve has left its crease if it is somewhere more than 1 % of the
diagonal from it. Then one pin is put on the crease where the curve is farthest off, and the
stroke is snapped again with it: "pinned" has the same figures of all curves, "of those that had
left" how many of these the one pin brings back. Mean errors in thousandths of the diagonal.

Vehicles and bodies are in two halves: constants were chosen on the first alone. Prints Markdown.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.strokes import FeatureStroke, recover_curve

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, body, stroke

ROOT = Path(__file__).parents[1]

#: The six vehicles with strokes of their own, and the six others, in two halves.
CHOSEN = (
    "audi_chrono",
    "gclass_chrono",
    "q_car_normalcar1",
    "bus_gazebo",
    "prius_gazebo",
    "q_car_suv",
)
TESTED = (
    "suv_patrol_chrono",
    "uazbus_chrono",
    "hatchback_gazebo",
    "ambulance_gazebo",
    "uaz469_chrono",
    "q_car_sportscar",
)

#: Bodies that features were worked out on, as in feature_snap.py; the nine others were not.
CHOSEN_BODIES = ("sedan", "suv", "coupe", "pickup")

#: A crease bends by more than this, and its chain turns by less than this at a vertex, in radians.
SHARP, TURN = np.radians(25.0), np.radians(30.0)

#: The shortest and the longest crease that is drawn along, as shares of the diagonal.
SHORTEST, LONGEST = 0.1, 0.4

#: How many creases of a vehicle are taken at most, the longest first.
MOST = 20

#: Strokes are up to this share of the diagonal off, and a curve that is farther off has left.
ERROR, LEFT = 0.01, 0.01

#: Directions looked along from a crease: it counts if half its length is seen from somewhere.
LOOKS = 32


@dataclass(frozen=True, slots=True)
class Outcome:
    """Mean and greatest distance between a curve and its crease, in shares of the diagonal."""

    mean: float
    most: float


def sharp_edges(model: Surface) -> np.ndarray:
    """(e, 2) the edges of two triangles or more at which the surface bends by more than SHARP."""
    t = model.triangles.astype(np.int64)
    edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    wings = model.vertices[np.concatenate([t[:, 2], t[:, 0], t[:, 1]])]
    pairs, name = np.unique(edges, axis=0, return_inverse=True)
    start, along = model.vertices[pairs[:, 0]], np.diff(model.vertices[pairs], axis=1)[:, 0]
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    name = name.ravel()
    out = wings - start[name]
    out -= np.einsum("ij,ij->i", out, unit[name])[:, None] * unit[name]
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
    total = np.zeros((len(pairs), 3))
    np.add.at(total, name, out)
    bend = 2.0 * np.arcsin(np.clip(np.linalg.norm(total, axis=1) / 2.0, 0.0, 1.0))
    return pairs[(np.bincount(name) == 2) & (bend > SHARP)]


def chains(model: Surface) -> Iterator[Points]:
    """Polylines along sharp edges that go straight on at vertices."""
    edges = sharp_edges(model)
    unit = np.diff(model.vertices[edges], axis=1)[:, 0]
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    at: dict[int, list[int]] = {}
    for number, edge in enumerate(edges.tolist()):
        for vertex in edge:
            at.setdefault(vertex, []).append(number)
    used = np.zeros(len(edges), bool)

    def away(number: int, vertex: int) -> Points:
        return unit[number] if edges[number, 0] == vertex else -unit[number]

    def grow(number: int, vertex: int) -> list[int]:
        found = [vertex]
        while True:
            ahead = [
                (float(away(other, vertex) @ -away(number, vertex)), other)
                for other in at[vertex]
                if not used[other]
            ]
            best = max(ahead, default=(-1.0, -1))
            if best[0] < np.cos(TURN):
                return found
            number = best[1]
            used[number] = True
            vertex = int(edges[number].sum()) - vertex
            found.append(vertex)

    for number in range(len(edges)):
        if used[number]:
            continue
        used[number] = True
        a, b = edges[number].tolist()
        yield model.vertices[grow(number, a)[::-1] + grow(number, b)]


def is_seen(model: Surface, crease: Points) -> bool:
    """Is most of a crease seen from outside?"""
    rng = np.random.default_rng(0)
    looks = rng.normal(size=(LOOKS, 3))
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    places = at_lengths(crease, np.linspace(0.05, 0.95, 15) * arc_length(crease)[-1])
    origins = np.repeat(places, LOOKS, axis=0)
    along = np.tile(looks, (len(places), 1))
    hits = model.cast_rays(origins + 2e-3 * model.diagonal * along, along)
    return bool((~hits.found).reshape(len(places), LOOKS).any(axis=1).mean() > 0.8)


def creases(model: Surface) -> list[Points]:
    """The longest creases that are seen, no two along each other, cut to LONGEST."""
    found: list[Points] = []
    every = sorted(chains(model), key=lambda one: -arc_length(one)[-1])
    for one in every:
        total = arc_length(one)[-1]
        if total < SHORTEST * model.diagonal or len(found) == MOST:
            break
        length = min(total, LONGEST * model.diagonal)
        lengths = np.linspace(0.0, length, 201) + (total - length) / 2.0
        part = at_lengths(one, lengths)
        near = [KDTree(other).query(part)[0].mean() < ERROR * model.diagonal for other in found]
        if not any(near) and is_seen(model, part):
            found.append(part)
    return found


def drawn_along(model: Surface, crease: Points, seed: int) -> Points:
    """A rough stroke of 4 to 8 points, each up to ERROR across the crease, on the model."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    inner = (np.arange(1, count - 1) + rng.uniform(-0.3, 0.3, count - 2)) / (count - 1)
    shares = np.r_[rng.uniform(0.0, 0.05), inner, 1.0 - rng.uniform(0.0, 0.05)]
    total = arc_length(crease)[-1]
    feet = at_lengths(crease, shares * total)
    tangents = at_lengths(crease, shares * total + 1e-3 * total) - at_lengths(
        crease, shares * total - 1e-3 * total
    )
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = rng.normal(size=(count, 3))
    across -= np.einsum("ij,ij->i", across, tangents)[:, None] * tangents
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    sizes = ERROR * model.diagonal * rng.uniform(0.0, 1.0, count)
    return model.nearest(feet + sizes[:, None] * across).points


def compare(
    curve: Points, crease: Points, stroke_ends: Points, diagonal: float
) -> tuple[Outcome, Points]:
    """How far a curve is from its crease, both ways, and the place of the crease farthest off.

    Between the feet of the stroke's ends, for beyond them no curve was asked for.
    """
    true = at_lengths(crease, np.linspace(0.0, arc_length(crease)[-1], 1001))
    tree = KDTree(true)
    low, high = np.sort(np.asarray(tree.query(stroke_ends)[1]))
    fine = at_lengths(curve, np.linspace(0.0, arc_length(curve)[-1], 1001))
    asked = true[low : high + 1]
    forth = np.asarray(KDTree(fine).query(asked)[0])
    back, foot = (np.asarray(part) for part in tree.query(fine))
    back = back[(foot > low) & (foot < high)]
    most = max(forth.max(), back.max(initial=0.0))
    mean = max(forth.mean(), back.mean() if len(back) else 0.0)
    # The ends are the stroke's own.
    inner = slice(len(asked) // 20, len(asked) - len(asked) // 20)
    pin = asked[inner][forth[inner].argmax()]
    return Outcome(float(mean) / diagonal, float(most) / diagonal), pin


def measured(model: Surface, crease: Points, points: Points) -> tuple[Outcome, Outcome]:
    """Before and after one pin."""
    before = recover_curve(model, FeatureStroke("", points)).curve
    first, pin = compare(before.spline.sample(601), crease, points[[0, -1]], model.diagonal)
    after = recover_curve(model, FeatureStroke("", points, pin[None])).curve
    second, _ = compare(after.spline.sample(601), crease, points[[0, -1]], model.diagonal)
    return first, second


HEAD = (
    "| model | curves | left | mean | most | pinned: left | mean | most | of those that had left, "
    "back | made to leave |\n|---|" + "---:|" * 9
)


def row(name: str, found: list[tuple[Outcome, Outcome]]) -> str:
    before, after = ([pair[k] for pair in found] for k in (0, 1))
    left = np.array([one.most > LEFT for one in before])
    still = np.array([one.most > LEFT for one in after])
    cells = [name, str(len(found))]
    for gone, some in ((left, before), (still, after)):
        cells += [
            str(int(gone.sum())),
            f"{1e3 * np.mean([one.mean for one in some]):.3f}",
            f"{1e3 * np.mean([one.most for one in some]):.2f}",
        ]
    cells += [str(int((left & ~still).sum())), str(int((~left & still).sum()))]
    return "| " + " | ".join(cells) + " |"


def report(
    title: str,
    models: Iterator[tuple[str, Surface, list[tuple[Points, list[Points]]]]],
    worst: bool,
) -> None:
    print(f"\n{title}:\n\n{HEAD}")
    every: list[tuple[Outcome, Outcome]] = []
    for name, model, cases in models:
        found: list[tuple[Outcome, Outcome]] = []
        for number, (crease, strokes) in enumerate(cases):
            for seed, points in enumerate(strokes):
                try:
                    found.append(measured(model, crease, points))
                except InvalidFeatureError as error:
                    print(f"  {name} {number} {seed}: {error}", file=sys.stderr)
                    continue
                one, other = found[-1]
                if worst and max(one.most, other.most) > LEFT:
                    print(
                        f"  {name} {number} {seed}: {1e3 * one.mean:.2f} {1e3 * one.most:.1f} -> "
                        f"{1e3 * other.mean:.2f} {1e3 * other.most:.1f}"
                    )
        if found:
            print(row(name, found), flush=True)
            every += found
    if every:
        print(row("all", every), flush=True)


def vehicles(
    data: Path, names: tuple[str, ...], count: int
) -> Iterator[tuple[str, Surface, list[tuple[Points, list[Points]]]]]:
    for name in names:
        found = [data / folder / f"{name}.obj" for folder in ("cad", "meshes")]
        path = next((path for path in found if path.exists()), None)
        if path is None:
            print(f"{name} is left out: it is not in {data}", file=sys.stderr)
            continue
        model = Surface.from_soup(read_mesh(path))
        yield (
            name,
            model,
            [
                (one, [drawn_along(model, one, 100 * i + k) for k in range(count)])
                for i, one in enumerate(creases(model))
            ],
        )


def generated(
    names: tuple[str, ...], count: int
) -> Iterator[tuple[str, Surface, list[tuple[Points, list[Points]]]]]:
    for name in names:
        made = body(name)
        model = Surface.from_soup(PolygonMesh.from_faces(made.points, made.triangles))
        yield (
            name,
            model,
            [
                (one.points, [stroke(made, one.name, ERROR, k) for k in range(count)])
                for one in made.features
                if one.kind in ("crease", "round", "arch")
            ],
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--strokes", type=int, default=1, help="for every crease")
    parser.add_argument("--half", choices=("chosen", "tested", "both"), default="both")
    parser.add_argument("--no-bodies", action="store_true")
    parser.add_argument("--worst", action="store_true", help="name the curves that left")
    arguments = parser.parse_args()
    data, count = arguments.shared / "data", arguments.strokes
    if not data.is_dir():
        parser.error(f"there is no {data}; give --shared, a folder with data/cad and data/meshes")
    others = tuple(name for name in CARS if name not in CHOSEN_BODIES)
    for half, names, bodies in (
        ("chosen", CHOSEN, CHOSEN_BODIES),
        ("tested", TESTED, others),
    ):
        if arguments.half not in (half, "both"):
            continue
        report(f"Vehicles, {half}", vehicles(data, names, count), arguments.worst)
        if not arguments.no_bodies:
            report(f"Bodies, {half}", generated(bodies, count), arguments.worst)


if __name__ == "__main__":
    main()
