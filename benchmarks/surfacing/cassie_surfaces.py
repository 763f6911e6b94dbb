"""Sketches drawn by people: every cycle found in the CASSIE networks, surfaced by all methods.

    python benchmarks/surfacing/cassie_surfaces.py ../shared/data/curves/cassie/graph

Prints Markdown for RESULTS.md, one row per network: curves, cycles, CPU seconds to find and to
surface them, and how much area each method has beyond the exact triangulation of least area
(medians over the cycles; inner vertices can bring it below 1). No intended surface is known here.
Peers need the extra ``benchmark``.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from filling import Filling
from synthetic_cycles import Fill, methods

from patterndb_sketch.curvenetwork.network import InvalidNetworkError
from patterndb_sketch.surfacing.cycles import find_cycles
from patterndb_sketch.surfacing.networkfile import read_network
from patterndb_sketch.surfacing.sampling import (
    Loop,
    loop_of,
    sample,
)
from patterndb_sketch.surfacing.tessellation import area, find_self_intersections

#: Of the methods, those in the table: MeshLib's other metrics add nothing without a known surface.
SHOWN = ("chords", "area", "MeshLib default", "MeshLib area", "CGAL")

#: The measure that others are related to.
EXACT = "area"


@dataclass(slots=True)
class Tally:
    """What a method did over some cycles.

    seconds, ratios (areas to the exact), crossings: one of each per cycle that it answered;
    no ratio where a cycle encloses no area.
    failed: where and why it did not.
    stood_in: where the least area stood in for it, for a piece or for all.
    """

    seconds: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    crossings: list[int] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    stood_in: list[str] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        self.seconds += other.seconds
        self.ratios += other.ratios
        self.crossings += other.crossings
        self.failed += other.failed
        self.stood_in += other.stood_in


@dataclass(frozen=True, slots=True)
class Row:
    """A network: its size, seconds for finding its cycles, and a tally of each method.

    small: cycles too small for the spacing, which no method was given.
    """

    name: str
    curves: int
    cycles: int
    vertices: int
    finding: float
    tallies: dict[str, Tally]
    small: list[str]


def surfaced(
    where: str, loops: list[Loop], spacing: float, every: dict[str, Fill]
) -> dict[str, Tally]:
    tallies = {name: Tally() for name in every}
    for number, loop in enumerate(loops):
        exact = 0.0
        for name in sorted(every, key=lambda n: n != EXACT):
            tally = tallies[name]
            try:
                found: Filling = every[name](loop, spacing)
            except Exception as error:  # a peer may raise anything
                tally.failed.append(f"{where}, cycle {number}: {type(error).__name__}: {error}")
                continue
            size = area(found.vertices, found.triangles)
            exact = size if name == EXACT else exact
            if found.note:
                tally.stood_in.append(f"{where}: {number}")
            tally.seconds.append(found.seconds)
            if exact > 0.0:  # else the cycle runs to and fro on a line
                tally.ratios.append(size / exact)
            tally.crossings.append(len(find_self_intersections(found.vertices, found.triangles)))
    return tallies


def measured(path: Path, every: dict[str, Fill]) -> Row:
    network = read_network(path)
    started = time.process_time()
    found = find_cycles(network).cycles
    finding = time.process_time() - started
    sampling = sample(network)
    loops: list[Loop] = []
    small: list[str] = []
    for cycle in found:
        try:
            loops.append(loop_of(network, sampling, cycle))
        except InvalidNetworkError as error:  # fewer than three vertices at this spacing
            small.append(f"{path.stem}: {error}")
    tallies = surfaced(path.stem, loops, sampling.spacing, every)
    vertices = sum(len(loop.points) for loop in loops)
    return Row(path.stem, len(network.curves), len(loops), vertices, finding, tallies, small)


def line(row: Row) -> str:
    cells = [row.name, str(row.curves), str(row.cycles), str(row.vertices), f"{row.finding:.2f}"]
    cells += [f"{1000 * sum(t.seconds):.0f}" for t in row.tallies.values()]
    cells += [
        f"{np.median(t.ratios):.3f} / {np.percentile(t.ratios, 90):.3f}" if t.ratios else "-"
        for name, t in row.tallies.items()
        if name != EXACT
    ]
    cells += [f"{sum(c > 0 for c in t.crossings)}" for t in row.tallies.values()]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("networks", type=Path, help="a folder of CASSIE graphs")
    parser.add_argument("--only", default="", help="networks whose name contains this")
    arguments = parser.parse_args()
    every = {name: fill for name, fill in methods().items() if name in SHOWN}
    paths = sorted(arguments.networks.glob("*.json"))
    measured(min(paths, key=lambda path: path.stat().st_size), every)  # compiles
    heads = ["network", "curves", "cycles", "vertices around them", "find s"]
    heads += [f"{name} ms" for name in every]
    heads += [f"{name} area, median / 90%" for name in every if name != EXACT]
    heads += [f"{name} crossed" for name in every]
    print(f"| {' | '.join(heads)} |\n| --- |{' ---: |' * (len(heads) - 1)}")
    rows: list[Row] = []
    for path in paths:
        if arguments.only in path.stem:
            rows.append(measured(path, every))
            print(line(rows[-1]), flush=True)
    whole = {name: Tally() for name in every}
    for row in rows:
        for name, tally in row.tallies.items():
            whole[name].add(tally)
    print(
        line(
            Row(
                "all",
                sum(row.curves for row in rows),
                sum(row.cycles for row in rows),
                sum(row.vertices for row in rows),
                sum(row.finding for row in rows),
                whole,
                [],
            )
        )
    )
    small = [one for row in rows for one in row.small]
    print(f"\ncycles left out for all methods: {len(small)}")
    for one in small:
        print(f"* {one}")
    for name, tally in whole.items():
        ms = 1000 * np.array(tally.seconds)
        print(
            f"\n{name}: median {np.median(ms):.2f} ms a cycle, most {ms.max():.1f} ms; failed on "
            f"{len(tally.failed)} cycles"
        )
        for one in tally.failed:
            print(f"* {one}")
        if tally.stood_in:
            print(
                f"* the least area stood in for some piece or all of {len(tally.stood_in)} cycles "
                f"(network: cycle): {', '.join(tally.stood_in)}"
            )


if __name__ == "__main__":
    main()
