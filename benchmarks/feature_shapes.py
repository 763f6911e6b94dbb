"""Thirteen bodies registered to one template, and the shape model that they give.

    python benchmarks/feature_shapes.py [--r 11] [--along 11] [--rounds 1] [--delta 2]

The generated bodies are laid out along their networks, whose curves are as drawn: each is off by
some millimetres and its ends are too long or too short. The models are clean, or torn, turned,
cluttered and shuffled (mirrors, handles, an aerial, wheels; seats, an engine, inner shells).
Distances are from the clean body in thousandths of its length, of all vertices but those that
are no part of its surface: the hidden ones and those along curves that nobody can draw.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Floats
from patterndb.geometry.polyline import arc_length
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import spline_through
from patterndb_sketch.features.registration import Registration, Template, box_template, register
from patterndb_sketch.features.shapemodel import (
    ErrorTable,
    ShapeModel,
    edit,
    measure_errors,
    pull_feature,
)
from patterndb_sketch.features.splines import Spline

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import CARS, Body, body, degrade

SEED = 1

#: Resolution of the body that distances are from, and of the one that is torn.
FINE, TORN = 2.0, 1.0

#: How far drawn curves are off sideways, and their ends along themselves, in metres.
OFF, ENDS = 0.002, 0.02

#: Everything at once.
MESS = {
    "uneven": True, "cuts": 3, "gaps": 0.004, "crossings": 0.005, "flips": 0.5,
    "interior": True, "exterior": True, "shuffle": True,
}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """One body's registration, and its distances (v,) in thousandths of the length, nan for
    vertices that are none of its surface's."""

    registration: Registration
    distance: Floats
    seconds: float


def drawn(shown: Body, seed: int = SEED) -> dict[str, Spline]:
    """The body's curves as somebody might have drawn them; hidden ones are not there."""
    rng = np.random.default_rng(seed)
    result: dict[str, Spline] = {}
    for curve in shown.features:
        if curve.kind == "hidden":
            continue
        points = curve.smooth
        along = arc_length(points)
        share = along / along[-1]
        turn = np.pi * (share[:, None] * rng.uniform(1.0, 3.0, 3) + rng.uniform(0.0, 2.0, 3))
        moved_points = points + OFF / np.sqrt(3.0) * np.sin(turn)
        if curve.kind == "profile":
            moved_points[:, 1] = 0.0
        first, last = np.clip(rng.uniform(-ENDS, ENDS, 2), -0.1 * along[-1], 0.1 * along[-1])
        # Too short: cut off; too long: straight on.
        kept = (along >= max(0.0, -first)) & (along <= along[-1] - max(0.0, -last))
        line = moved_points[kept]
        if first > 0.0:
            line = np.r_[[line[0] + first * _unit(line[0] - line[1])], line]
        if last > 0.0:
            line = np.r_[line, [line[-1] + last * _unit(line[-1] - line[-2])]]
        result[curve.name] = spline_through(line)
    return result


def _unit(vector: Floats) -> Floats:
    return vector / np.linalg.norm(vector)


def surface_vertices(template: Template, laid: Registration) -> NDArray[np.bool_]:
    """(w,) the vertices of the registered half that should be on the body's surface."""
    there = np.zeros(len(laid.points), np.bool_)
    there[: template.n_vertices] = True
    for chain in template.chains:
        if any(step.curve in template.bridged for step in chain.steps):
            there[chain.vertices[1:-1]] = False
    return there & ~laid.occluded


def laid_on(name: str, messy: bool, template: Template, delta: float, rounds: int) -> Laid:
    shown = body(name, FINE, whole=True)
    clean = Surface.from_soup(PolygonMesh.from_faces(shown.points, shown.triangles))
    model = clean
    if messy:
        mess = degrade(body(name, TORN), SEED, **MESS)
        model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
    curves = drawn(shown)
    begun = time.perf_counter()
    found = register(model, curves, template, delta=delta, rounds=rounds)
    seconds = time.perf_counter() - begun
    distance = np.full(len(found.points), np.nan)
    counted = surface_vertices(template, found)
    length = float(np.ptp(shown.points[:, 0]))
    distance[counted] = 1000.0 * clean.measure_distances(found.points[counted]) / length
    return Laid(found, distance, seconds)


def checked(template: Template, found: Registration) -> tuple[float, float]:
    """How far feature vertices are from their curves, and the mesh from its mirror image."""
    off = 0.0
    for chain in template.chains:
        if len(chain.steps) == 1 and chain.steps[0].curve in found.network.curves:
            curve = found.network.curves[chain.steps[0].curve]
            off = max(off, float(_from_polyline(found.points[chain.vertices], curve).max()))
    half = found.points[: template.n_vertices]
    image = found.points[template.n_vertices :]
    twin = half[~template.plane] * (1.0, -1.0, 1.0)
    return off, float(max(np.abs(image - twin).max(), np.abs(half[template.plane, 1]).max()))


def _from_polyline(points: Floats, curve: Spline) -> Floats:
    """(n,) distances from 4,000 chords of a curve, which are some 1e-7 m off it themselves."""
    dense = curve(np.linspace(*curve.domain, 4001))
    k = np.linalg.norm(dense[:, None] - points[None], axis=2).argmin(axis=0)
    away = np.full(len(points), np.inf)
    for first in (np.maximum(k - 1, 0), np.minimum(k, len(dense) - 2)):
        a, along = dense[first], dense[first + 1] - dense[first]
        share = np.einsum("nc,nc->n", points - a, along) / np.einsum("nc,nc->n", along, along)
        at = a + np.clip(share, 0.0, 1.0)[:, None] * along
        away = np.minimum(away, np.linalg.norm(points - at, axis=1))
    return away


def print_registrations(
    template: Template, delta: float, rounds: int
) -> tuple[list[Registration], list[Registration]]:
    result: tuple[list[Registration], list[Registration]] = ([], [])
    print(
        f"{template.name}: {template.n_vertices} vertices and {len(template.quads)} quads per half;"
        f" delta {delta:g}, rounds {rounds}\n"
    )
    print(
        "| body | node off mm | clean mean | 99 % | max | messy mean | 99 % | max | no or far hit "
        "clean | messy | hidden | off curves | asymmetry | s |"
    )
    print("|---|" + "---:|" * 13)
    every: tuple[list[Floats], list[Floats]] = ([], [])
    parts: tuple[list[NDArray[np.int32]], list[NDArray[np.int32]]] = ([], [])
    for name in CARS:
        known = body(name, FINE, whole=True).corners
        clean, messy = (laid_on(name, torn, template, delta, rounds) for torn in (False, True))
        nodes = clean.registration.network.nodes
        off = max(float(np.linalg.norm(nodes[corner] - known[corner])) for corner in nodes)
        cells = [name, f"{1000 * off:.1f}"]
        for which, one in enumerate((clean, messy)):
            chosen = ~one.registration.fixed & np.isfinite(one.distance)
            free = one.distance[chosen]
            parts[which].append(template.of_part[np.flatnonzero(chosen)])
            every[which].append(free)
            result[which].append(one.registration)
            cells += [f"{free.mean():.2f}", f"{np.percentile(free, 99):.1f}", f"{free.max():.1f}"]
        for one in (clean, messy):
            half = slice(None, template.n_vertices)
            found = one.registration
            alone = ~found.fixed & ~found.occluded & ~found.projected
            cells.append(str(int(alone[half].sum())))
        cells.append(str(int(clean.registration.occluded[: template.n_vertices].sum())))
        curve, mirror = (
            max(pair)
            for pair in zip(
                *(checked(template, x.registration) for x in (clean, messy)), strict=True
            )
        )
        cells += [f"{curve:.0e}", f"{mirror:.0e}", f"{messy.seconds:.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)
    print("\n| thousandths of the length | mean | 99 % | max |\n|---|---:|---:|---:|")
    for which, distances, owners in zip(("clean", "messy"), every, parts, strict=True):
        whole, owner = np.concatenate(distances), np.concatenate(owners)
        for number, part in enumerate(template.parts):
            mine = whole[owner == number]
            cells = (mine.mean(), np.percentile(mine, 99), mine.max())
            print(f"| {which} {part.name} | {' | '.join(f'{x:.2f}' for x in cells)} |")
    return result


def print_errors(model: ShapeModel, table: ErrorTable, length: float) -> None:
    print("\n| modes | variance | known: rms | max | left out: rms | max |")
    print("|---:" * 6 + "|")
    scale = 1000.0 / length
    for i, share in enumerate(table.share):
        cells = [f"{100 * share:.2f} %"]
        for value in (table.known[i], table.known_most[i], table.unseen[i], table.unseen_most[i]):
            cells.append(
                ""
                if np.isnan(value)
                else f"{value * scale:.2e}"
                if value * scale < 1e-3
                else f"{value * scale:.2f}"
            )
        print(f"| {i} | {' | '.join(cells)} |")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--r", type=int, default=11, help="vertices along an edge of a box")
    parser.add_argument("--along", type=int, help="the same along the car; default: r")
    parser.add_argument("--delta", type=float, default=2.0)
    parser.add_argument("--rounds", type=int, default=1)
    given = parser.parse_args()
    template = box_template(given.r, given.along)
    laid = print_registrations(template, given.delta, given.rounds)
    length = float(np.mean([np.ptp(one.points[:, 0]) for one in laid[0]]))
    for which, registrations in zip(("clean", "messy"), laid, strict=True):
        begun = time.perf_counter()
        model = ShapeModel.from_registrations(
            registrations, names=tuple(CARS), template=template.name
        )
        seconds = time.perf_counter() - begun
        back = [model.shape(model.project(one.points)) for one in registrations]
        worst = max(
            float(np.abs(a - b.points).max()) for a, b in zip(back, registrations, strict=True)
        )
        print(
            f"\nShape model of {len(registrations)} {which} bodies, {len(model.mean)} vertices, "
            f"built in {seconds:.2f} s; all modes give the bodies back to {worst:.0e} m. "
            f"Errors in thousandths of the mean length, {length:.2f} m:"
        )
        print_errors(model, measure_errors(model), length)
        if which == "clean":
            begun = time.perf_counter()
            lifted = edit(model, pull_feature(model, "roof_rail", (0.0, 0.0, 0.1)))
            missed = 1000.0 * lifted.misses["roof_rail"]
            print(
                f"\nThe roof rail dragged up by 100 mm: missed by {missed:.1f} "
                f"mm at most, {int((lifted.at_bound != 0).sum())} coefficients at their bounds, "
                f"{1000 * (time.perf_counter() - begun):.1f} ms"
            )


if __name__ == "__main__":
    main()
