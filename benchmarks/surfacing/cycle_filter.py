"""Would a learned score tell which of the cycles that are found are patches?

    python benchmarks/surfacing/cycle_filter.py [--shared ../shared]

The cycles found in every second CASSIE sketch by name, "even" or "odd", teach a logistic
regression on FEATURES; then cycles whose odds are below a threshold are dropped, in the other half
too. Recall and precision are counted as benchmarks/cycles.py does. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
from patterndb_sketch.curvenetwork.polylines import measure_angles
from patterndb_sketch.surfacing import find_cycles
from patterndb_sketch.surfacing.cycles.closing import find_dangling, list_half_curves
from patterndb_sketch.surfacing.cycles.measures import measure_cycles, rate_badness
from patterndb_sketch.surfacing.networkfile import read_network, read_recorded_patches

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cycles import Strokes, patches_of, strokes_of

FEATURES = (
    "badness", "flatness", "bending", "cuts", "curves", "curves less strokes", "corners",
    "length over the median curve's", "turning at nodes, off a full turn",
    "share of length with a second patch", "mean cosine between the surface and neighbours'",
    "greatest of these cosines", "mean badness with neighbours",
)  # fmt: skip

#: The weight of the squared coefficients of standardised features.
RIDGE = 30.0

STEPS = 30

#: Logarithms of odds below which cycles are dropped; the first drops none.
THRESHOLDS = (-np.inf, -0.5, 0.0, 0.5, 1.0)


@dataclass(frozen=True, slots=True)
class FoundSketch:
    """The cycles found in a sketch: their strokes, features (k, f), and whether each is one of
    the recorded patches."""

    patches: set[Strokes]
    strokes: list[Strokes]
    features: NDArray[np.float64]
    right: NDArray[np.bool_]


def describe(network: CurveNetwork, cycles: Sequence[Cycle]) -> NDArray[np.float64]:
    """(k, len(FEATURES)) what is known of cycles that were chosen together."""
    measures = measure_cycles(network, list_half_curves(network, ~find_dangling(network)), cycles)
    strokes = np.array([len(strokes_of(network, cycle.curves)) for cycle in cycles], float)
    sizes = np.array([len(cycle.steps) for cycle in cycles], float)
    bad = rate_badness(measures, sizes, strokes)
    first = np.r_[0, np.cumsum(sizes.astype(int))]
    beside: dict[int, list[tuple[int, NDArray[np.float64]]]] = {}
    for i, cycle in enumerate(cycles):
        for k, curve in enumerate(cycle.curves):
            beside.setdefault(curve, []).append((i, measures.inward[first[i] + k]))
    length = np.array([curve.length for curve in network.curves])
    rows: list[list[float]] = []
    for i, cycle in enumerate(cycles):
        cosines, others, shared = [-1.0], [bad[i]], 0.0
        for curve in cycle.curves:
            own = next(way for j, way in beside[curve] if j == i)
            for j, way in beside[curve]:
                if j != i:
                    cosines.append(float(own @ way))
                    others.append(bad[j])
                    shared += length[curve]
        around = [network.along(step) for step in cycle.steps]
        arriving = np.array([points[-1] - points[-2] for points in around])
        leaving = np.array([points[1] - points[0] for points in around])
        turning = float(measure_angles(np.roll(arriving, 1, axis=0), leaving).sum())
        rows.append(
            [
                bad[i], measures.flatness[i], measures.bending[i], measures.cuts[i] / sizes[i],
                sizes[i], sizes[i] - strokes[i], measures.corners[i],
                np.log(measures.length[i] / np.median(length)), abs(turning - 2.0 * np.pi),
                shared / measures.length[i], float(np.mean(cosines)), max(cosines),
                float(np.mean(others)),
            ]
        )  # fmt: skip
    return np.array(rows, float).reshape(len(cycles), len(FEATURES))


def learn(sketches: Sequence[FoundSketch]) -> tuple[NDArray[np.float64], ...]:
    """Mean and spread of features, and coefficients, the constant last."""
    features = np.concatenate([one.features for one in sketches])
    right = np.concatenate([one.right for one in sketches]).astype(float)
    # Sketches count by the root of their cycles: means are over sketches, noise over cycles.
    weights = np.concatenate(
        [np.full(len(s.right), max(1, len(s.right)) ** -0.5) for s in sketches]
    )
    weights *= len(weights) / weights.sum()
    mean, spread = features.mean(axis=0), features.std(axis=0) + 1e-9
    design = np.c_[(features - mean) / spread, np.ones(len(features))]
    ridge = np.diag(np.r_[np.full(design.shape[1] - 1, RIDGE), 0.0])
    at = np.zeros(design.shape[1])
    for _ in range(STEPS):
        share = 1.0 / (1.0 + np.exp(-(design @ at)))
        slope = design.T @ (weights * (right - share)) - ridge @ at
        at = at + np.linalg.solve(
            (design.T * (weights * share * (1 - share))) @ design + ridge, slope
        )
    return mean, spread, at


def rate(
    sketches: Sequence[FoundSketch], model: tuple[NDArray[np.float64], ...], threshold: float
) -> NDArray[np.float64]:
    """Mean recall and precision of the cycles that are kept."""
    mean, spread, at = model
    rows: list[tuple[float, float]] = []
    for one in sketches:
        kept = (one.features - mean) / spread @ at[:-1] + at[-1] >= threshold
        strokes = [s for s, keep in zip(one.strokes, kept.tolist(), strict=True) if keep]
        recall = len(one.patches.intersection(strokes)) / len(one.patches)
        rows.append((recall, one.right[kept].sum() / max(1, len(strokes))))
    return np.array(rows).mean(axis=0)


def read_sketch(path: Path) -> FoundSketch:
    network = read_network(path)
    patches = patches_of(path, network)
    bare = CurveNetwork(network.curves, network.nodes)
    cycles = find_cycles(bare).cycles
    strokes = [strokes_of(network, cycle.curves) for cycle in cycles]
    right = np.array([one in patches for one in strokes], bool)
    return FoundSketch(patches, strokes, describe(bare, cycles), right)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    args = parser.parse_args()
    graphs = sorted((args.shared / "data" / "curves" / "cassie" / "graph").glob("*.json"))
    sketches = [read_sketch(path) for path in graphs if read_recorded_patches(path)]
    halves = sketches[::2], sketches[1::2]
    heads = "recall there | precision there | recall, other half | precision, other half"
    print(f"| learned on | dropped below | {heads} |")
    print("|---|---:|---:|---:|---:|---:|")
    for half, name in enumerate(("even", "odd")):
        model = learn(halves[half])
        for threshold in THRESHOLDS:
            both = np.r_[
                rate(halves[half], model, threshold), rate(halves[1 - half], model, threshold)
            ]
            below = "none" if np.isinf(threshold) else f"{threshold:g}"
            print(f"| {name} | {below} | {' | '.join(f'{v:.3f}' for v in both)} |")


if __name__ == "__main__":
    main()
