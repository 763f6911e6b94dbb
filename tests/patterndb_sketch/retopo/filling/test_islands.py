"""Parts of the network within patches: nothing lies over anything else."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.filling import weld_patches
from patterndb_sketch.retopo.quadimport import import_quads, refuse_losses
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, do, line
from tests.support.retopo.networks import plane

Sheet = tuple[range, range]


def square(editor: Retopology, low: float, high: float) -> None:
    corners = [(low, low), (high, low), (high, high), (low, high)]
    for k in range(4):
        do(editor, "stroke", points=line(corners[k - 1], corners[k]))


def covered(editor: Retopology) -> float:
    """The area of all quads; all lie on the plane."""
    mesh = weld_patches(editor.fill())
    corner = mesh.vertices[mesh.quads]
    assert (corner[..., 2] == 0.0).all()
    one, two = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    area = 0.5 * np.cross(one, two)[:, 2]
    assert (area > 0.0).all()
    return float(area.sum())


def test_a_patch_has_no_quads_while_others_float_within_it(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    square(editor, -2.0, 2.0)
    assert covered(editor) == pytest.approx(16.0)
    square(editor, -1.0, 1.0)
    found = editor.fill()
    assert len(editor.network.patches) == 2 and len(found.placed) == 1
    assert len(found.notes) == 1 and "lies within it" in found.notes[0]
    assert covered(editor) == pytest.approx(4.0)
    # One curve joins them: the loop around both sides of it is a patch.
    do(editor, "stroke", points=line((-2, -2), (-1, -1)))
    assert not any("has no quads" in note for note in editor.fill().notes)
    assert covered(editor) == pytest.approx(16.0)
    do(editor, "stroke", points=line((1, 1), (2, 2)))
    assert len(editor.network.patches) == 3
    assert covered(editor) == pytest.approx(16.0)


def test_patches_within_patches_within_patches(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    for half in (0.5, 1.5, 2.5):
        square(editor, -half, half)
    assert covered(editor) == pytest.approx(1.0)
    # What is erased is no island any more.
    for at in ((0.5, 0), (0, 0.5), (-0.5, 0), (0, -0.5)):
        do(editor, "erase", at=[*at, 0])
    assert covered(editor) == pytest.approx(9.0)


def test_a_curve_that_closes_nothing_is_no_island(source: PatternSource) -> None:
    editor = Retopology(plane(), source, SIZES)
    square(editor, -2.0, 2.0)
    do(editor, "stroke", points=line((-1, 0), (1, 0)))
    assert covered(editor) == pytest.approx(16.0)
    # Neither is a patch beside another.
    square(editor, 2.3, 2.9)
    assert covered(editor) == pytest.approx(16.36)


def join_sheets(
    sheets: list[Sheet], without: list[Sheet] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Unit quads over ranges of columns and rows, each sheet with vertices of its own; without: of
    each sheet the cells that it lacks."""
    points: list[list[float]] = []
    quads: list[list[int]] = []
    for k, (columns, rows) in enumerate(sheets):
        number: dict[tuple[int, int], int] = {}
        for i in columns:
            for j in rows:
                if without is not None and i in without[k][0] and j in without[k][1]:
                    continue
                quad: list[int] = []
                for at in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                    if at not in number:
                        number[at] = len(points)
                        points.append([*map(float, at), 0.0])
                    quad.append(number[at])
                quads.append(quad)
    return np.array(points), np.array(quads, np.int32)


NONE: Sheet = (range(0), range(0))


@pytest.mark.parametrize(
    ("sheets", "without"),
    [
        ([(range(8), range(3)), (range(4, 8), range(3, 9))], [NONE, NONE]),
        ([(range(8), range(3)), (range(8), range(3, 6))], [NONE, NONE]),
        ([(range(3), range(3)), (range(3, 6), range(3, 6))], [NONE, NONE]),
        ([(range(6), range(6)), (range(2, 4), range(2, 4))], [(range(2, 4), range(2, 4)), NONE]),
        ([(range(6), range(6)), (range(2, 4), range(2, 4))], [NONE, NONE]),
        ([(range(6), range(4)), (range(6), range(4))], [NONE, NONE]),
    ],
    ids=["part of a side", "a side", "a corner", "a plug in a hole", "on top", "twice"],
)
def test_a_mesh_whose_parts_touch_along_borders_loses_no_quad(
    source: PatternSource, sheets: list[Sheet], without: list[Sheet]
) -> None:
    """Borders in one place, whose vertices are not merged: neither part lies within the other."""
    points, quads = join_sheets(sheets, without)
    editor = Retopology.of_quads(import_quads(points, quads), source)
    # As a command fills it, from the network alone.
    editor.restore(editor.state)
    found = editor.fill()
    refuse_losses(found)
    mesh = weld_patches(found)
    assert len(mesh.quads) == len(quads) and len(mesh.vertices) == len(points)
    assert sorted(map(tuple, np.sort(mesh.vertices[mesh.quads].mean(axis=1), axis=0).tolist())) == (
        sorted(map(tuple, np.sort(points[quads].mean(axis=1), axis=0).tolist()))
    )
    assert not any("lies within it" in note for note in found.notes)


def test_parts_that_touch_stay_apart_where_one_is_filled_otherwise(source: PatternSource) -> None:
    points, quads = join_sheets([(range(8), range(3)), (range(4, 8), range(3, 9))])
    editor = Retopology.of_quads(import_quads(points, quads), source)
    do(editor, "insertloop", at=[2.5, 0.0, 0.0])
    found = editor.fill()
    assert not any("lies within it" in note for note in found.notes)
    assert len(weld_patches(found).quads) > len(quads)


def test_quads_that_were_given_are_not_lost_in_silence(source: PatternSource) -> None:
    """Curves drawn within a patch that was given take its quads: what would be written lacks
    them."""
    points, quads = join_sheets([(range(10), range(10))])
    editor = Retopology.of_quads(import_quads(points, quads), source)
    refuse_losses(editor.fill())
    for a, b in (((3, 3), (7, 3)), ((7, 3), (7, 7)), ((7, 7), (3, 7)), ((3, 7), (3, 3))):
        do(editor, "stroke", points=line(a, b))
    found = editor.fill()
    assert any("lies within it" in note for note in found.notes)
    with pytest.raises(RefusedError, match="100 quads of the mesh that was given would be lost"):
        refuse_losses(found)
