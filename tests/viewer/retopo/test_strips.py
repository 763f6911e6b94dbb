"""What the tools for quads would make, shown in the window of retopology before they do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from patterndb.core.polychord import polychords
from patterndb.geometry.strips import pair_edges, trace_strip, trace_strips_at
from patterndb_sketch.retopo.filling import RetopoMesh
from patterndb_sketch.retopo.previews import find_nearest_edge
from tests.support.viewer.sheets import (
    SQUARE,
    at,
    click,
    drag,
    hover,
    keys,
    press,
    quads_of,
    square,
)
from viewer.retopo import RetopoState

PENTAGON = ((0.0, 2.0), (-1.9, 0.6), (-1.2, -1.6), (1.2, -1.6), (1.9, 0.6))


def grid(n: int, m: int, *, closed: bool = False) -> RetopoMesh:
    """n x m quads of length 1 in the plane; closed: after the last column comes the first."""
    columns = n if closed else n + 1
    x, y = np.meshgrid(np.arange(columns), np.arange(m + 1))
    at = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1).astype(np.float64)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(n), np.arange(m)))
    right = (i + 1) % columns
    quads = np.stack(
        [j * columns + i, j * columns + right, (j + 1) * columns + right, (j + 1) * columns + i],
        axis=1,
    ).astype(np.int32)
    none = np.full(len(at), -1, np.int32)
    patch = np.zeros(len(quads), np.int32)
    return RetopoMesh(at, np.tile((0.0, 0.0, 1.0), (len(at), 1)), quads, patch, none, none)


def _off(point: np.ndarray, ends: np.ndarray) -> float:
    """How far a point (3,) is off a segment (2, 3)."""
    along = ends[1] - ends[0]
    share = np.clip((point - ends[0]) @ along / (along @ along), 0.0, 1.0)
    return float(np.linalg.norm(ends[0] + share * along - point))


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 99))
def test_twins_are_the_same_edge_the_other_way(n: int, m: int, seed: int) -> None:
    quads = grid(n, m).quads[np.random.default_rng(seed).permutation(n * m)]
    twin = pair_edges(quads)
    tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    has = np.flatnonzero(twin >= 0)
    assert np.array_equal(twin[twin[has]], has)
    assert np.array_equal(tail[has], head[twin[has]]) and np.array_equal(head[has], tail[twin[has]])
    assert (twin < 0).sum() == 2 * (n + m), "the rim"


@given(st.integers(1, 6), st.integers(1, 6), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_strip_crosses_a_grid_from_rim_to_rim(n: int, m: int, x: float, y: float) -> None:
    mesh = grid(n, m)
    point = np.array([n * x, m * y, 0.0])
    half = find_nearest_edge(mesh, np.arange(n * m, dtype=np.int32), point)
    ends = mesh.vertices[[mesh.quads.ravel()[half], np.roll(mesh.quads, -1, axis=1).ravel()[half]]]
    # No edge is nearer: those of the unit grid are at whole numbers, within its rim.
    assert _off(point, ends) <= min(
        _off(point, mesh.vertices[quad[[k, k - 3]]]) for quad in mesh.quads for k in range(4)
    )
    line = trace_strip(mesh.vertices, mesh.quads, half)
    across = 0 if ends[0, 1] != ends[1, 1] else 1
    # An edge that stands upright is crossed by a row, and one that lies by a column.
    assert len(line) == (n, m)[across] + 1
    assert np.ptp(line[:, 1 - across]) == 0.0
    assert np.array_equal(np.sort(line[:, across]), np.arange(len(line)))
    assert (np.abs(np.diff(line[:, across])) == 1.0).all(), "in order"
    assert any(np.allclose(ends.mean(axis=0), one) for one in line)


@pytest.mark.parametrize("row", range(3))
def test_a_strip_that_comes_back_is_closed(row: int) -> None:
    mesh = grid(5, 3, closed=True)
    # Half-edge 1 of a quad leads upwards at its right.
    line = trace_strip(mesh.vertices, mesh.quads, 4 * (5 * row + 2) + 1)
    assert len(line) == 6 and np.array_equal(line[0], line[-1])
    assert (line[:, 1] == row + 0.5).all()


@given(st.integers(1, 6), st.integers(1, 6), st.booleans(), st.integers(0, 999))
def test_two_strips_cross_in_every_quad(n: int, m: int, closed: bool, seed: int) -> None:
    """On a grid these are its row and its column; whatever edge is the quad's first."""
    rng = np.random.default_rng(seed)
    closed = closed and n > 2
    mesh = grid(n, m, closed=closed)
    quads = np.stack([np.roll(quad, k) for quad, k in zip(
        mesh.quads, rng.integers(0, 4, n * m), strict=True)])  # fmt: skip
    quad = int(rng.integers(n * m))
    row, column = divmod(quad, n)
    lines = trace_strips_at(mesh.vertices, quads, quad)
    assert len(lines) == 2
    (along,) = [line for line in lines if np.ptp(line[:, 1]) == 0.0]
    (up,) = [line for line in lines if line is not along]
    assert len(along) == n + 1 and (along[:, 1] == row + 0.5).all()
    assert np.array_equal(along[0], along[-1]) == closed
    assert len(up) == m + 1 and np.ptp(up[:, 0]) == 0.0
    wanted = column + 0.5 if not closed or column < n - 1 else (n - 1) / 2
    assert up[0, 0] == wanted


@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_strips_are_the_polychords_through_a_quad(seed: int, turn: int) -> None:
    """Tori whose lines wind, so that one may pass a quad twice: by the core's polychords."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(3, 6)), int(rng.integers(3, 6))
    i, j = np.divmod(np.arange(n * m), m)

    def at(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Going round in j leads on by ``turn`` in i."""
        return (i + turn * (j // m)) % n * m + j % m

    quads = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)
    quads = quads.astype(np.int32)[rng.permutation(n * m)]
    twin = pair_edges(quads)
    known = polychords(twin)
    quad = int(rng.integers(n * m))
    points = rng.normal(size=(n * m, 3))
    lines = trace_strips_at(points, quads, quad)
    chords = known.of_strand[quad]
    assert len(lines) == len(set(chords.tolist()))
    middles = 0.5 * (points[quads] + points[np.roll(quads, -1, axis=1)]).reshape(-1, 3)
    for line, chord in zip(lines, dict.fromkeys(chords.tolist()), strict=True):
        crossed = {tuple(point) for point in middles[known.of_edge == chord].round(9).tolist()}
        assert {tuple(point) for point in line.round(9).tolist()} == crossed
        assert np.allclose(line[0], line[-1]), "a torus has no rim"


def test_strands_are_shown_through_the_quad_under_the_pointer(state: RetopoState) -> None:
    """In every mode that does not draw just now; not beside quads, nor when switched off."""
    square(state)
    hover(state, (0.2, 0.2))
    lines = state.tool.strips_under()
    assert len(lines) == 2
    for line in lines:
        assert np.abs(line[:, :2]).max() == pytest.approx(1.5, abs=0.02), "from rim to rim"
        gaps = np.linalg.norm(line[:, None, :2] - np.array([0.2, 0.2]), axis=2)
        assert gaps.min() < state.shown.body.edge
    assert state.tool.strips_under() is state.tool.strips_under(), "found once for a quad"
    press(state, (0.2, 0.2), (0.4, 0.2))
    assert state.tool.strips_under() == []
    state.leave()
    keys(state, "T")
    hover(state, (0.2, 0.2))
    assert state.tool.strips_under() == []
    keys(state, "T")
    assert len(state.tool.strips_under()) == 2
    hover(state, (3.0, 3.0))
    assert state.tool.strips_under() == []


def test_a_loop_is_shown_where_it_is_inserted(state: RetopoState) -> None:
    square(state)
    keys(state, "4")
    hover(state, (4.0, 4.0))
    assert state.tool.preview is not None and state.tool.preview.curves == ()
    hover(state, (0.0, -1.45))
    assert state.tool.preview is not None
    (line,) = state.tool.preview.curves
    assert np.abs(line[:, :2]).max() == pytest.approx(1.5, abs=0.02)
    assert np.ptp(line[:, 0]) < 0.1, "from below to above"
    before = quads_of(state)
    click(state, (0.0, -1.45))
    assert not state.message and quads_of(state) == before + len(line) - 1


@pytest.mark.parametrize("tool", ["5", "6"])
def test_quads_are_shown_as_they_will_be(state: RetopoState, tool: str) -> None:
    square(state, PENTAGON)
    keys(state, f"{tool} ] ] ] ]" if tool == "6" else "y")
    if tool == "5":
        # A fill with a pair, if the list has one.
        hover(state, (0.0, 0.0))
        keys(state, "n 5")
    old = state.shown.body.mesh
    press(state, (0.1, 0.0), (0.5, 0.1), (0.9, 0.2))
    state.settle()
    preview = state.tool.preview
    assert preview is not None
    state.release(*at(state, (0.9, 0.2)))
    state.settle()
    if preview.refused:
        assert state.message == preview.refused and state.shown.body.mesh is old
        return
    assert preview.quads is not None and len(preview.quads) > 0
    mesh = state.shown.body.mesh
    made = mesh.vertices[mesh.quads]
    # What was shown is there, and all else is as it was.
    off = np.abs(preview.quads[:, None] - made[None]).max(axis=(2, 3)).min(axis=1)
    assert off.max() < 1e-6
    rest = np.abs(made[:, None] - preview.quads[None]).max(axis=(2, 3)).min(axis=1) > 1e-6
    away = np.linalg.norm(made[rest][:, :, None] - old.vertices[None, None], axis=3).min(axis=2)
    assert away.max(initial=0.0) < 1e-4 * state.surface.diagonal


def test_nothing_is_shown_where_there_are_no_quads(state: RetopoState) -> None:
    drag(state, SQUARE[0], SQUARE[1])
    keys(state, "6")
    press(state, (0.0, 0.0), (1.0, 0.0))
    state.settle()
    assert state.tool.preview is not None and "no quads" in state.tool.preview.refused
    state.leave()
    state.release(*at(state, (1.0, 0.0)))
    state.settle()
    assert state.editing.calls is not None and len(state.editing.calls) == 1
