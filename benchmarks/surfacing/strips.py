"""Strips bent around an axis: are they surfaced, and how near to the pipe that they are cut from?

    python benchmarks/surfacing/strips.py [--angles 10] [--heights 10]

Four curves each, two arcs of radius 1 and two straight lines: angles from 90 to 330 degrees by
heights from 0.1 to 3. Nothing but the curves is given; the cycle is found. Prints Markdown for
RESULTS.md: how many strips were surfaced, how many by the method itself, and the mean, the median
and the greatest over the strips of the mean distance both ways, in thousandths of the diagonal.
"""

from __future__ import annotations

import argparse

import numpy as np
from surface_distance import distance

from patterndb.geometry.points import Points
from patterndb_sketch.curvenetwork.joining import network_of_polylines
from patterndb_sketch.curvenetwork.network import CurveNetwork
from patterndb_sketch.surfacing import SurfaceOptions, find_cycles, surface
from patterndb_sketch.surfacing.methods import METHODS
from query.placing import Surface

ANGLES = (90.0, 330.0)
HEIGHTS = (0.1, 3.0)

#: Points of an arc as it is drawn, and columns of the true surface.
DRAWN, FINE = 65, 513


def bend_strip(degrees: float, height: float, columns: int) -> Points:
    """(2, columns, 3) the strip's lower and upper arc."""
    angle = np.radians(degrees) * np.linspace(0.0, 1.0, columns)
    arc = np.stack([np.cos(angle), np.sin(angle), np.zeros(columns)], axis=1)
    return np.stack([arc, arc + np.array([0.0, 0.0, height])])


def draw_strip(degrees: float, height: float) -> CurveNetwork:
    """The four curves of a strip, joined."""
    low, high = bend_strip(degrees, height, DRAWN)
    return network_of_polylines(
        [low, high, np.stack([low[0], high[0]]), np.stack([low[-1], high[-1]])]
    )


def measure_strip(degrees: float, height: float, method: str) -> tuple[float, str] | None:
    """The mean distance of a method's surface to the true one, per diagonal, and who answered.

    None where there is no cycle, or more than one.
    """
    network = draw_strip(degrees, height)
    cycles = find_cycles(network).cycles
    if len(cycles) != 1:
        return None
    made = surface(network, cycles, options=SurfaceOptions(method))
    low, high = bend_strip(degrees, height, FINE)
    at = np.arange(FINE - 1)
    quads = np.stack([at, at + 1, FINE + at + 1, FINE + at], axis=1)
    true = Surface.from_arrays(
        np.concatenate([low, high]), np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    )
    apart = distance(Surface.from_arrays(made.points, made.triangles), true).mean
    return apart / network.diagonal, str(made.patches[0].method)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--angles", type=int, default=10)
    parser.add_argument("--heights", type=int, default=10)
    args = parser.parse_args()
    strips = [
        (float(degrees), float(height))
        for degrees in np.linspace(*ANGLES, args.angles)
        for height in np.geomspace(*HEIGHTS, args.heights)
    ]
    print("| method | strips | surfaced | by itself | mean | median | most |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name, method in METHODS.items():
        if method.needs_database:
            continue
        found = [measure_strip(*strip, name) for strip in strips]
        made = [one for one in found if one is not None]
        far = 1000 * np.array([one[0] for one in made])
        itself = sum(one[1] == name for one in made)
        print(
            f"| {name} | {len(strips)} | {len(made)} | {itself} | {far.mean():.2f} "
            f"| {np.median(far):.2f} | {far.max():.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
