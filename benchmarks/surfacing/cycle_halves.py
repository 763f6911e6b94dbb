"""Do the constants that cycles are found with hold on sketches that they were not chosen on?

    python benchmarks/surfacing/cycle_halves.py [--shared ../shared] [--first N]

Every second CASSIE sketch by name, "even" and "odd". Each of the settings below changes one
constant of the measures of cycles. The best on one half, by the harmonic mean of its mean recall
and precision (counted as benchmarks/cycles.py does), is told with what it gives on the other half,
both ways round. --first: the first N settings only. Prints Markdown for RESULTS.md.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing.cycles import find as finding
from patterndb_sketch.surfacing.cycles import find_cycles, measures
from patterndb_sketch.surfacing.networkfile import read_network, read_recorded_patches

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from cycles import Strokes, patches_of, strokes_of

#: What is tried: name, and (module, constant, value).
SETTINGS: tuple[tuple[str, tuple[tuple[ModuleType, str, float], ...]], ...] = (
    ("as it is", ()),
    ("worst 1", ((finding, "WORST", 1.0),)),
    ("worst 0.65", ((finding, "WORST", 0.65),)),
    ("cuts 4.5", ((measures, "CUTS", 4.5),)),
    ("cuts 2", ((measures, "CUTS", 2.0),)),
    ("fold 2", ((measures, "FOLD", 2.0),)),
    ("reward 1.5", ((finding, "REWARD", 1.5),)),
    ("reward 2.5", ((finding, "REWARD", 2.5),)),
    ("stroke 0.1", ((measures, "STROKE", 0.1),)),
    ("stroke 0.02", ((measures, "STROKE", 0.02),)),
    ("bending 0.8", ((measures, "BENDING", 0.8),)),
    ("bending 0.25", ((measures, "BENDING", 0.25),)),
    ("corner 0.3", ((measures, "CORNER", 0.3),)),
    ("narrowness 0.5", ((measures, "NARROWNESS", 0.5),)),
    ("fold 0.5", ((measures, "FOLD", 0.5),)),
)


def rate_sketch(network: CurveNetwork, patches: set[Strokes], worst: float) -> tuple[float, float]:
    """Recall and precision of what is found in a sketch."""
    bare = CurveNetwork(network.curves, network.nodes)
    found = [strokes_of(network, c.curves) for c in find_cycles(bare, worst=worst).cycles]
    recall = len(patches.intersection(found)) / len(patches)
    return recall, sum(strokes in patches for strokes in found) / max(1, len(found))


def combine(means: NDArray[np.float64]) -> float:
    """The harmonic mean of recall and precision."""
    return float(2.0 * means.prod() / means.sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--first", type=int, default=len(SETTINGS))
    args = parser.parse_args()
    graphs = sorted((args.shared / "data" / "curves" / "cassie" / "graph").glob("*.json"))
    sketches = [(p, read_network(p)) for p in graphs if read_recorded_patches(p)]
    known = [(network, patches_of(path, network)) for path, network in sketches]
    print("| setting | recall, even | precision, even | recall, odd | precision, odd |")
    print("|---|---:|---:|---:|---:|")
    tried: list[tuple[str, NDArray[np.float64]]] = []
    for name, changes in SETTINGS[: args.first]:
        with ExitStack() as stack:
            for module, constant, value in changes:
                stack.enter_context(patch.object(module, constant, value))
            rows = np.array([rate_sketch(n, p, finding.WORST) for n, p in known])
        halves = np.array([rows[::2].mean(axis=0), rows[1::2].mean(axis=0)])
        tried.append((name, halves))
        print(f"| {name} | {' | '.join(f'{v:.3f}' for v in halves.ravel())} |", flush=True)
    print()
    print("| chosen on | setting | recall there | precision there | recall on the other half | "
          "precision on the other half |")  # fmt: skip
    print("|---|---|---:|---:|---:|---:|")
    for half, name in enumerate(("even", "odd")):
        setting, rows = max(tried, key=lambda one: combine(one[1][half]))
        both = " | ".join(f"{v:.3f}" for v in (*rows[half], *rows[1 - half]))
        print(f"| {name} | {setting} | {both} |")


if __name__ == "__main__":
    main()
