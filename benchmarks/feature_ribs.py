"""Ribs across a curve: cut out clean, and repaired by way of a picture.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/feature_ribs.py

100 ribs of 201 samples along a feature of a car-like body, clean and in a state as models are
found; least and middle of 9 runs, in milliseconds for all ribs. The last line is the repair of
one rib, without its slice and samples: the paper has 300 ms for that.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from patterndb._native.features.ribs.rib import slice_segments, trace_outline
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.polyline import sample_polyline
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import RADIUS
from patterndb_sketch.features.ribs import STITCH, build_ribs, find_plane

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, body, degrade

RIBS, RUNS, SEED = 100, 9, 1


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """The least and the middle of the runs, in milliseconds, after one that does not count."""
    work()
    taken: list[float] = []
    for _ in range(RUNS):
        begin = time.perf_counter()
        work()
        taken.append(1e3 * (time.perf_counter() - begin))
    return min(taken), float(np.median(taken))


def main() -> None:
    car = body(sorted(CARS)[0], resolution=1.4, whole=True)
    mess = degrade(
        car, SEED, uneven=True, cuts=3, gaps=0.001, crossings=0.003, flips=0.5,
        interior=True, exterior=True, shuffle=True,
    )  # fmt: skip
    models = {
        "clean": Surface.from_soup(PolygonMesh.from_faces(car.vertices, car.triangles)),
        "messy": Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles)),
    }
    for state, model in models.items():
        print(f"{state}: {len(model.triangles):,} triangles, {model.n_components} parts")
        for name in ("roof_rail", "shoulder", "roof_profile", "front_arch"):
            line = sample_polyline(car.feature(name).smooth, RIBS + 1)
            origins, tangents = model.nearest(line[1:-1]).points, line[2:] - line[:-2]
            ribs = build_ribs(model, origins, tangents)
            least, middle = timed(lambda m=model, o=origins, t=tangents: build_ribs(m, o, t))
            count = sum(rib.repaired for rib in ribs)
            pictures = sum(rib.rounds > 0 for rib in ribs)
            print(
                f"  {name:14} {least:7.1f} {middle:7.1f} ms, {count} of {len(ribs)} repaired, "
                f"{pictures} of them by a picture"
            )
    model = models["messy"]
    parts = (model.corners, model.triangles, model.components, *model.boxes)
    radius, tolerance = RADIUS * model.diagonal, STITCH * model.diagonal
    lone: list[float] = []
    line = sample_polyline(car.feature("shoulder").smooth, 31)
    for origin, tangent in zip(line[1:-1], line[2:] - line[:-2], strict=True):
        cut = slice_segments(*parts, *find_plane(origin, tangent), radius, tolerance)
        points, offsets, closed, rims, gap, about, _, _ = cut
        if gap >= 0.0:
            given = (points, offsets, closed, rims, about, 1.0, radius, 0, gap, tolerance)
            lone.append(timed(lambda g=given: trace_outline(*g))[0])
    middle, most = np.median(lone), np.max(lone)
    print(f"repair of one rib: {middle:.2f} ms, at most {most:.2f} ({len(lone)} ribs)")


if __name__ == "__main__":
    main()
