"""Cycles with known intended surfaces: how near do the methods come, ours and those of others?

    python benchmarks/surfacing/synthetic_cycles.py

Prints Markdown for RESULTS.md: per cycle the mean and the greatest distance to the intended
surface (both ways, in thousandths of the cycle's diagonal), the area as a ratio to the intended,
pairs of triangles that cross, and milliseconds (the best of three). Peers need the extra
``benchmark``; without it they are left out, and the program says so.
"""

from __future__ import annotations

import argparse
import importlib.util
import statistics
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from filling import Filling
from ours import OURS

from patterndb.geometry.polyline import arc_length
from patterndb_sketch.surfacing.sampling import Loop
from patterndb_sketch.surfacing.tessellation import find_self_intersections
from query.placing import Surface
from tests.support.surfacing.intended import Intended, list_intended
from tests.support.surfacing.surfacedistance import Distance, distance

#: Mean distances below this share of the diagonal are not told apart: a pixel of a screen that
#: the cycle fills.
FLOOR = 1e-3

#: Methods whose distance is within this factor of the least are nearest too.
AS_NEAR = 1.01

#: How often a method is asked; the fastest counts.
REPEATS = 3

Fill = Callable[[Loop, float], Filling]


@dataclass(frozen=True, slots=True)
class Answer:
    """A method's answer to a cycle. ratio: of its area to the intended; why: the error if any."""

    distance: Distance
    ratio: float
    crossings: int
    seconds: float
    why: str = ""


def methods() -> dict[str, Fill]:
    """Ours, and the peers that are installed."""
    every: dict[str, Fill] = dict(OURS)
    missing = [name for name in ("meshlib", "CGAL") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"left out: {', '.join(missing)}; pip install '.[benchmark]'", file=sys.stderr)
        return every
    from peers import PEERS

    return every | {name: (lambda loop, _, f=f: f(loop.points)) for name, f in PEERS.items()}


def spacing_of(loop: Loop) -> float:
    """The mean edge around the loop."""
    return float(arc_length(np.r_[loop.points, loop.points[:1]])[-1]) / len(loop.points)


def answer(cycle: Intended, fill: Fill) -> Answer:
    """What a method makes of a cycle, measured; an error it raises is kept with it."""
    lost = float("nan")
    try:
        tries = [fill(cycle.loop, spacing_of(cycle.loop)) for _ in range(REPEATS)]
        found = Surface.from_arrays(tries[0].vertices, tries[0].triangles)
    except Exception as error:  # a peer may raise anything
        return Answer(Distance(lost, lost), lost, 0, lost, f"{type(error).__name__}: {error}")
    intended = Surface.from_arrays(cycle.vertices, cycle.triangles)
    apart = distance(found, intended)
    return Answer(
        Distance(apart.mean / cycle.diagonal, apart.most / cycle.diagonal),
        float(found.areas.sum() / intended.areas.sum()),
        len(find_self_intersections(tries[0].vertices, tries[0].triangles)),
        min(one.seconds for one in tries),
    )


def table(
    title: str, answers: dict[str, dict[str, Answer]], cell: Callable[[Answer], str]
) -> list[str]:
    names = list(next(iter(answers.values())))
    lines = [title, "", f"| cycle | {' | '.join(names)} |", "| --- |" + " ---: |" * len(names)]
    for cycle, row in answers.items():
        cells = [cell(one) if not one.why else "failed" for one in row.values()]
        lines.append(f"| {cycle} | {' | '.join(cells)} |")
    return [*lines, ""]


def summary(answers: dict[str, dict[str, Answer]]) -> list[str]:
    """Per method: on how many cycles nearest, and distances as ratios to the nearest's."""
    names = list(next(iter(answers.values())))
    lines = [
        f"Over the {len(answers)} cycles: on how many a method is nearest (or within 1%); its mean "
        "distance, averaged over the cycles; the geometric mean and the greatest of its mean "
        f"distance as a ratio to the nearest method's (below {1000 * FLOOR:g}/1000 counts as "
        "that); cycles with crossing triangles; the median time.",
        "",
        "| method | nearest | mean, 1/1000 | geometric mean of ratios | greatest ratio | "
        "cycles with crossings | failures | ms |",
        "| --- |" + " ---: |" * 7,
    ]
    for name in names:
        ratios: list[float] = []
        for row in answers.values():
            distances = {n: max(FLOOR, a.distance.mean) for n, a in row.items() if not a.why}
            if name in distances:
                ratios.append(distances[name] / min(distances.values()))
        every = [row[name] for row in answers.values()]
        sound = [one for one in every if not one.why]
        mean = 1000 * statistics.mean(one.distance.mean for one in sound)
        lines.append(
            f"| {name} | {sum(r <= AS_NEAR for r in ratios)} | {mean:.1f} | "
            f"{np.exp(np.mean(np.log(ratios))):.2f} | {max(ratios):.1f} | "
            f"{sum(one.crossings > 0 for one in sound)} | {len(every) - len(sound)} | "
            f"{1000 * statistics.median(one.seconds for one in sound):.1f} |"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="cycles whose name contains this")
    arguments = parser.parse_args()
    chosen = [cycle for cycle in list_intended() if (arguments.only or "") in cycle.name]
    every = methods()
    for fill in every.values():
        answer(chosen[0], fill)  # compiles
    answers = {
        cycle.name: {name: answer(cycle, fill) for name, fill in every.items()} for cycle in chosen
    }
    for cycle in chosen:
        print(f"* {cycle.name} ({len(cycle.loop.points)} vertices): {cycle.means}")
    print()
    for lines in (
        table("Mean distance, 1/1000:", answers, lambda a: f"{1000 * a.distance.mean:.1f}"),
        table("Greatest distance, 1/1000:", answers, lambda a: f"{1000 * a.distance.most:.0f}"),
        table("Area, ratio to the intended:", answers, lambda a: f"{a.ratio:.3f}"),
        table("Pairs of triangles that cross:", answers, lambda a: f"{a.crossings}"),
        table("Milliseconds:", answers, lambda a: f"{1000 * a.seconds:.1f}"),
        summary(answers),
    ):
        print("\n".join(lines))
    for cycle, row in answers.items():
        for name, one in row.items():
            if one.why:
                print(f"\n{name} on {cycle}: {one.why}")


if __name__ == "__main__":
    main()
