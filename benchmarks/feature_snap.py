"""Curves snapped to the features of car bodies, clean and as models come in: how near are they?

    python benchmarks/feature_snap.py --bodies sedan,suv --seeds 1
    python benchmarks/feature_snap.py --cuts 1000        (the cut against a maximum flow)

Draws rough strokes along every feature of procedural bodies whose feature curves are known, up
to 1 % of the diagonal off, and snaps them. The lateral error of a curve is the larger of two
means: the distance of the feature from the curve, between the feet of the stroke's ends; and
the distance of the curve from the feature, where its foot is not the feature's end. Floor: the
same distance of the feature from the model itself, as gaps along features tear them away.

Beside it, on the model's edge graph: the shortest path between the true ends where edges cost
less the more the surface bends at them, and the shortest path through the stroke's points.
Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.polyline import arc_length, at_lengths
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.fishbone import Fishbone, cut, find_terms, synchronise
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.ribs import build_ribs
from patterndb_sketch.features.snap import Snap, SnapSettings, snap

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, Body, NamedCurve, body, degrade, stroke

#: Strokes are up to this share of the diagonal off.
ERROR = 0.01

#: A curve is good with this share of the stroke's lateral error.
GOOD = 0.25

#: An edge at which the surface bends most costs this share of its length.
CHEAPEST = 0.02

#: States of a body: what degrade() is told, None for the clean half.
STATES: dict[str, dict[str, float | bool] | None] = {
    "clean": None,
    "half the patches flipped": {"flips": 0.5},
    "interior clutter": {"interior": True},
    "shuffled soup, flipped": {"flips": 0.5, "shuffle": True},
    "gaps 0.1 %": {"gaps": 0.001},
    "gaps 0.2 %": {"gaps": 0.002},
    "crossings 0.2 %": {"crossings": 0.002},
    "crossings 0.6 %": {"crossings": 0.006},
    "all, 0.1 % gaps, 0.2 % crossings": {
        "uneven": True, "cuts": 2, "gaps": 0.001, "crossings": 0.002, "flips": 0.5,
        "interior": True, "exterior": True, "shuffle": True,
    },
    "all, 0.4 % gaps, 0.6 % crossings": {
        "uneven": True, "cuts": 2, "gaps": 0.004, "crossings": 0.006, "flips": 0.5,
        "interior": True, "exterior": True, "shuffle": True,
    },
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Lateral:
    """Lateral errors in shares of the diagonal; nan where a rival found nothing."""

    stroke: float
    snapped: float
    floor: float
    weighted: float
    geodesic: float
    seconds: float
    repaired: float


def dense(points: Points, count: int) -> Points:
    return at_lengths(points, np.linspace(0.0, arc_length(points)[-1], count))


def lateral(curve: Points, feature: Points, drawn: Points) -> float:
    """The lateral error of a polyline, see above."""
    true = dense(feature, 4001)
    tree = KDTree(true)
    low, high = np.sort(tree.query(drawn[[0, -1]])[1])
    fine = dense(curve, 4001)
    forth = KDTree(fine).query(true[low : high + 1])[0].mean()
    back, foot = tree.query(fine)
    inside = (foot > 0) & (foot < len(true) - 1)
    return float(max(forth, back[inside].mean() if inside.any() else 0.0))


@dataclass(frozen=True, slots=True)
class Graph:
    """The edges of a model: lengths, and lengths as of how the surface bends at them."""

    points: Points
    tree: KDTree
    plain: csr_array
    weighted: csr_array

    @classmethod
    def of(cls, model: Surface) -> Graph:
        """Where an edge has other than two triangles it does not count as a bend."""
        t = model.triangles.astype(np.int64)
        pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [0, 2]]])
        wings = model.vertices[np.concatenate([t[:, 2], t[:, 0], t[:, 1]])]
        edges, name, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
        name = name.ravel()
        start, along = model.vertices[edges[:, 0]], np.diff(model.vertices[edges], axis=1)[:, 0]
        length = np.linalg.norm(along, axis=1)
        unit = along / length[:, None]
        out = wings - start[name]
        out -= np.einsum("ij,ij->i", out, unit[name])[:, None] * unit[name]
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
        total = np.zeros((len(edges), 3))
        np.add.at(total, name, out)
        # |a + b| = 2 sin(bend / 2) for unit vectors along two triangles away from their edge.
        bend = 2.0 * np.arcsin(np.clip(np.linalg.norm(total, axis=1) / 2.0, 0.0, 1.0))
        bend[count != 2] = 0.0
        share = np.clip(bend / max(np.percentile(bend, 99.5), 1e-9), 0.0, 1.0)
        shape = (len(model.vertices), len(model.vertices))
        where = (edges[:, 0], edges[:, 1])
        return cls(
            model.vertices,
            KDTree(model.vertices),
            csr_array((length, where), shape),
            csr_array((length * np.maximum(1.0 - share, CHEAPEST), where), shape),
        )

    def path(self, costs: csr_array, through: Points) -> Points | None:
        """The cheapest path through the vertices nearest to points, None where torn."""
        stops = np.atleast_1d(self.tree.query(through)[1])
        stops = stops[np.r_[True, np.diff(stops) != 0]]
        every: list[int] = [int(stops[0])]
        for a, b in pairwise(stops):
            _, before = dijkstra(costs, directed=False, indices=a, return_predecessors=True)
            leg = [int(b)]
            while leg[-1] != a:
                if before[leg[-1]] < 0:
                    return None
                leg.append(int(before[leg[-1]]))
            every += leg[-2::-1]
        return self.points[every] if len(every) > 1 else None


def modelled(made: Body, state: str, seed: int) -> Surface:
    wanted = STATES[state]
    if wanted is None:
        return Surface.from_soup(PolygonMesh.from_faces(made.points, made.triangles))
    mess = degrade(made, seed, **wanted)  # pyright: ignore[reportArgumentType]
    return Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))


def drawable(made: Body) -> Iterator[NamedCurve]:
    """The features that the surface shows; the others are lines on smooth surfaces."""
    for feature in made.features:
        if feature.kind in ("crease", "round", "arch"):
            yield feature


def measured(
    made: Body, model: Surface, graph: Graph | None, feature: NamedCurve, seed: int
) -> Lateral:
    drawn = stroke(made, feature.name, ERROR, seed)
    sketch = find_initial_curve(model, drawn).samples
    start = time.perf_counter()
    curve = snap(model, drawn)
    seconds = time.perf_counter() - start

    def error(points: Points | None) -> float:
        if points is None:
            return np.nan
        return lateral(points, feature.points, drawn) / made.diagonal

    tree = KDTree(feature.points)
    low, high = np.sort(tree.query(drawn[[0, -1]])[1])
    floor = model.measure_distances(dense(feature.points[low : high + 1], 201)).mean()
    return Lateral(
        error(sketch),
        error(curve.spline.sample(601)),
        float(floor) / made.diagonal,
        error(graph and graph.path(graph.weighted, feature.points[[0, -1]])),
        error(graph and graph.path(graph.plain, drawn)),
        seconds,
        len(curve.repaired) / len(curve.samples),
    )


def row(state: str, found: list[Lateral], rivals: bool) -> str:
    def good(name: str) -> str:
        if name != "snapped" and not rivals:
            return "- | -"
        errors = np.array([getattr(one, name) for one in found])
        limits = GOOD * np.array([one.stroke for one in found])
        share = np.mean(np.where(np.isnan(errors), False, errors <= limits))
        torn = np.isnan(errors).mean()
        median = np.nanmedian(errors) if torn < 1.0 else np.nan
        return f"{share:.1%} | {1e3 * median:.2f}"

    above = np.mean([one.snapped - one.floor <= GOOD * one.stroke for one in found])
    stroked = 1e3 * statistics.median(one.stroke for one in found)
    floor = 1e3 * statistics.median(one.floor for one in found)
    torn = f"{np.mean([np.isnan(one.geodesic) for one in found]):.0%}" if rivals else "-"
    worse = sum(one.snapped > one.stroke for one in found)
    seconds = 1e3 * statistics.median(one.seconds for one in found)
    mended = statistics.mean(one.repaired for one in found)
    return (
        f"| {state} | {len(found)} | {stroked:.2f} | {good('snapped')} | {worse} | {floor:.2f} | "
        f"{above:.1%} | {good('weighted')} | {good('geodesic')} | {torn} | {mended:.0%} | "
        f"{seconds:.0f} |"
    )


def timings() -> None:
    """100 ribs of 201 samples on some 20,000 triangles."""
    made = body("sedan", resolution=1.8)
    model = Surface.from_soup(PolygonMesh.from_faces(made.points, made.triangles))
    line = made.feature("shoulder").points
    middle = at_lengths(line, np.linspace(0.25, 0.75, 6) * arc_length(line)[-1])
    found = Snap.begin(model, middle)
    count, reach = len(found.origins), found.settings.radius * model.diagonal
    settings = SnapSettings()

    def clock(function: object, rounds: int = 5) -> float:
        spent: list[float] = []
        for _ in range(rounds):
            start = time.perf_counter()
            function()  # pyright: ignore[reportCallIssue]
            spent.append(time.perf_counter() - start)
        return 1e3 * statistics.median(spent)

    def ribs() -> object:
        return build_ribs(model, found.origins, found.tangents, reach, settings.n_samples)

    built = ribs()
    place = found.curve.samples[count // 2] + 0.004 * model.diagonal
    dragged = [(count // 2, model.nearest(place[None]).points[0])]
    print(f"\n{len(model.triangles)} triangles, {count} ribs of {settings.n_samples} samples:\n")
    print("| step | ms |\n|---|---:|")
    window, nearness = settings.window * model.diagonal, settings.nearness * model.diagonal

    def bone() -> Fishbone:
        return synchronise(Fishbone.from_ribs(built))  # pyright: ignore[reportArgumentType]

    def pulls() -> object:
        return find_terms(bone(), window, nearness, (0.0, 0.0, 1.0), 1.0)

    stiff = SnapSettings(alpha=0.7, stiffness=2.0)
    for name, function in (
        ("a rib", lambda: build_ribs(model, found.origins[:1], found.tangents[:1], reach)),
        ("all ribs", ribs),
        ("arrays and synchronising", bone),
        ("the same and the terms", pulls),
        ("the cut alone", lambda: cut(np.random.default_rng(0).random((count, 201)), 0.05)),
        ("a slider: alpha and stiffness", lambda: found.with_settings(stiff)),
        ("a drag: one constraint moved", lambda: found.with_constraints(dragged)),
        ("a stroke, all rounds", lambda: Snap.begin(model, middle)),
    ):
        print(f"| {name} | {clock(function):.2f} |", flush=True)


def cuts_agree(count: int) -> None:
    """The cut against OR-Tools' maximum flow, on random whole costs with holes and held rows."""
    from ortools.graph.python.max_flow import SimpleMaxFlow

    rng = np.random.default_rng(1)
    big = 1 << 40
    same = 0
    for _ in range(count):
        m, k = int(rng.integers(1, 13)), int(rng.integers(1, 16))
        costs = rng.integers(0, 1000, (m, k)).astype(float)
        cross = rng.integers(0, [10, 100, 1500][rng.integers(3)], m - 1).astype(float)
        for i in range(m):
            low = int(rng.integers(0, k))
            costs[i, : low // 2] = np.inf
            costs[i, k - int(rng.integers(0, k - low // 2)) :] = np.inf
            if rng.random() < 0.2:
                kept = int(rng.choice(np.flatnonzero(np.isfinite(costs[i]))))
                costs[i] = np.inf
                costs[i, kept] = 0.0
        flow = SimpleMaxFlow()
        source, sink = m * (k + 1), m * (k + 1) + 1
        for i in range(m):
            top = i * (k + 1)
            flow.add_arc_with_capacity(source, top, big)
            flow.add_arc_with_capacity(top + k, sink, big)
            for j in range(k):
                capacity = int(costs[i, j]) if np.isfinite(costs[i, j]) else big
                flow.add_arc_with_capacity(top + j, top + j + 1, capacity)
                flow.add_arc_with_capacity(top + j + 1, top + j, big)
                if i + 1 < m:
                    flow.add_arc_with_capacity(top + j, top + k + 1 + j, int(cross[i]))
                    flow.add_arc_with_capacity(top + k + 1 + j, top + j, int(cross[i]))
        flow.solve(source, sink)
        same += cut(costs, cross).cost == flow.optimal_flow()
    print(f"\nThe cut costs what the maximum flow is worth in {same} of {count} random cases.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", default=",".join(CARS), help="names, with commas")
    parser.add_argument("--seeds", type=int, default=1, help="strokes per feature")
    parser.add_argument("--states", default="", help="parts of the states' names, with commas")
    parser.add_argument("--no-rivals", action="store_true")
    parser.add_argument("--no-timings", action="store_true")
    parser.add_argument("--worst", action="store_true", help="name the strokes that are not good")
    parser.add_argument("--cuts", type=int, default=0, help="random cuts against a maximum flow")
    arguments = parser.parse_args()
    if arguments.cuts:
        cuts_agree(arguments.cuts)
        return
    print(
        "| state | strokes | stroke | snapped: good | median | worse | floor | good above floor | "
        "weighted path: good | median | geodesic: good | median | torn | ribs mended | ms |"
    )
    print("|---|" + "---:|" * 14)
    asked = [part.strip() for part in arguments.states.split(",") if part.strip()]
    for state in STATES:
        if asked and not any(part in state for part in asked):
            continue
        found: list[Lateral] = []
        for name in arguments.bodies.split(","):
            made = body(name)
            model = modelled(made, state, seed=1)
            graph = None if arguments.no_rivals else Graph.of(model)
            for feature in drawable(made):
                for seed in range(arguments.seeds):
                    one = measured(made, model, graph, feature, seed)
                    found.append(one)
                    if arguments.worst and one.snapped > GOOD * one.stroke:
                        print(f"  {name} {feature.name} {seed}: {one.stroke:.5f} {one.snapped:.5f}")
        print(row(state, found, not arguments.no_rivals), flush=True)
    print("\nErrors in thousandths of the diagonal; good: at most a quarter of the stroke's.")
    if not arguments.no_timings:
        timings()


if __name__ == "__main__":
    main()
