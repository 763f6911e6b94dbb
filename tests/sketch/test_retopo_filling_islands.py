"""Parts of the network within patches: nothing lies over anything else."""

from __future__ import annotations

import numpy as np
import pytest
from editor_cases import SIZES, do, line
from retopo_cases import plane

from patterndb_sketch.retopo.editor import Editor
from patterndb_sketch.retopo.filling import weld_fills
from query.engine import PatternSource


def square(editor: Editor, low: float, high: float) -> None:
    corners = [(low, low), (high, low), (high, high), (low, high)]
    for k in range(4):
        do(editor, "stroke", points=line(corners[k - 1], corners[k]))


def covered(editor: Editor) -> float:
    """The area of all quads; all lie on the plane."""
    mesh = weld_fills(editor.fill())
    corner = mesh.vertices[mesh.quads]
    assert (corner[..., 2] == 0.0).all()
    one, two = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    area = 0.5 * np.cross(one, two)[:, 2]
    assert (area > 0.0).all()
    return float(area.sum())


def test_a_patch_has_no_quads_while_others_float_within_it(source: PatternSource) -> None:
    editor = Editor(plane(), source, SIZES)
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
    editor = Editor(plane(), source, SIZES)
    for half in (0.5, 1.5, 2.5):
        square(editor, -half, half)
    assert covered(editor) == pytest.approx(1.0)
    # What is erased is no island any more.
    for at in ((0.5, 0), (0, 0.5), (-0.5, 0), (0, -0.5)):
        do(editor, "erase", at=[*at, 0])
    assert covered(editor) == pytest.approx(9.0)


def test_a_curve_that_closes_nothing_is_no_island(source: PatternSource) -> None:
    editor = Editor(plane(), source, SIZES)
    square(editor, -2.0, 2.0)
    do(editor, "stroke", points=line((-1, 0), (1, 0)))
    assert covered(editor) == pytest.approx(16.0)
    # Neither is a patch beside another.
    square(editor, 2.3, 2.9)
    assert covered(editor) == pytest.approx(16.36)
