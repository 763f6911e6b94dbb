"""Edits of a shape model: how well what was not dragged is guessed, by what leaving a shape costs.

    python benchmarks/feature_edits.py [--r 11]

Of thirteen generated bodies each is left out in turn. Of the model of the twelve others one, two or
three features are dragged to where the body left out has them, and the shape that the edit gives is
compared with that body: *whole*, the root mean square of the distances of all vertices; *way*, how
much of its way a dragged feature goes: 1 less the distance that it misses by, as a share of the
distance from the mean, both in the root mean square. Then features of a known body are dragged by
100 mm in a random direction while another one is held: *farthest* is how far the vertex goes that
goes farthest, *miss* how far the dragged feature is off. Lengths in mm.

The constant, patterndb_sketch.features.shapemodel.edit.STIFFNESS, was chosen on four bodies: of
those tried the most with which a single feature goes 97 % as far as with none. Prints Markdown.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.registration import Registration, box_template
from patterndb_sketch.features.shapemodel import ShapeModel, edit, pull_feature
from patterndb_sketch.features.shapemodel.edit import STIFFNESS

sys.path.insert(0, str(Path(__file__).parent))
from feature_creases import CHOSEN_BODIES
from feature_shapes import CARS, laid_on

#: What leaving a shape costs, from nothing to hardly moving.
TRIED = (0.0, 3e-4, 1e-3, 3e-3, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.3)

#: Sets of several features that are dragged, of each body; and drags while another one is held.
SETS, DRAGS = 30, 40

#: How far features are dragged while another one is held.
PULL = 0.1


def away(points: Points, others: Points) -> float:
    """The root mean square of distances."""
    return float(np.sqrt(((points - others) ** 2).sum(axis=1).mean()))


def guessed(shapes: Floats, laid: Registration, body: int, seed: int) -> Floats:
    """(3, tried, 3): by the number of features dragged, the means of *whole*, and of the squares
    that dragged features miss by and were away by."""
    rng = np.random.default_rng(seed)
    model = ShapeModel.build(np.delete(shapes, body, axis=0), laid.quads, laid.features)
    names = [one.name for one in model.features]
    result: list[list[list[float]]] = []
    for count in (1, 2, 3):
        sets = (
            [(name,) for name in names]
            if count == 1
            else [tuple(rng.choice(names, count, replace=False).tolist()) for _ in range(SETS)]
        )
        rows = np.zeros((len(TRIED), 3))
        for dragged in sets:
            places = {name: model.feature(name).vertices for name in dragged}
            every = np.concatenate(list(places.values()))
            targets = {name: shapes[body][ids] for name, ids in places.items()}
            before = away(model.mean[every], shapes[body][every]) ** 2
            for k, stiffness in enumerate(TRIED):
                found = edit(model, targets, stiffness=stiffness).points
                missed = away(found[every], shapes[body][every]) ** 2
                rows[k] += np.array([away(found, shapes[body]), missed, before]) / len(sets)
        result.append(rows.tolist())
    return np.array(result)


def held(shapes: Floats, laid: Registration, body: int, seed: int) -> Floats:
    """(tried, 2): the means of *farthest* and *miss*, from a body that the model knows."""
    rng = np.random.default_rng(seed)
    model = ShapeModel.build(shapes, laid.quads, laid.features)
    names = [one.name for one in model.features]
    start = model.coefficients[body]
    rows = np.zeros((len(TRIED), 2))
    for _ in range(DRAGS):
        dragged, kept = rng.choice(names, 2, replace=False).tolist()
        by = rng.normal(size=3)
        # Sideways features hardly differ: what nobody can ask for is left out.
        by[1] = 0.0
        targets = pull_feature(model, dragged, PULL * by / np.linalg.norm(by), start=start)
        for k, stiffness in enumerate(TRIED):
            found = edit(model, targets, held={kept: 1.0}, start=start, stiffness=stiffness)
            moved = np.linalg.norm(found.points - shapes[body], axis=1)
            rows[k] += np.array([moved.max(), found.misses[dragged]]) / DRAGS
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--r", type=int, default=11, help="vertices along an edge of a box")
    given = parser.parse_args()
    template = box_template(given.r)
    names = tuple(CARS)
    laid = [laid_on(name, False, template, 2.0, 1).registration for name in names]
    shapes = np.stack([one.points for one in laid])
    print(f"{template.name}; the default is {STIFFNESS:g}")
    for title, half in (
        ("chosen", CHOSEN_BODIES),
        ("tested", tuple(name for name in names if name not in CHOSEN_BODIES)),
    ):
        numbers = [names.index(name) for name in half]
        guesses = np.mean([guessed(shapes, laid[0], i, i) for i in numbers], axis=0)
        pulls = np.mean([held(shapes, laid[0], i, i) for i in numbers], axis=0)
        mean = np.mean(
            [away(np.delete(shapes, i, axis=0).mean(axis=0), shapes[i]) for i in numbers]
        )
        print(f"\n{len(half)} bodies, {title}; the mean itself is off by {1e3 * mean:.0f}:\n")
        print(
            "| stiffness | one feature: whole | way | two: whole | way | three: whole | way | "
            "another held: farthest | miss |\n|" + "---:|" * 9
        )
        for k, stiffness in enumerate(TRIED):
            cells = [f"{stiffness:g}"]
            for whole, missed, before in guesses[:, k]:
                cells += [f"{1e3 * whole:.0f}", f"{100 * (1.0 - np.sqrt(missed / before)):.1f}%"]
            cells += [f"{1e3 * value:.0f}" for value in pulls[k]]
            print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
