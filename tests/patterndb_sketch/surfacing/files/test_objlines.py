"""Curves as line elements of OBJ files: the network is that of the same curves in JSON."""

from __future__ import annotations

import gzip
import json

import numpy as np
import pytest

from patterndb_sketch.curvenetwork.network import CurveNetwork, InvalidNetworkError
from patterndb_sketch.surfacing.networkfile import parse_drawing

N = 9
TURN = np.linspace(0.0, np.pi, N)
ALONG = np.linspace(0.0, 4.0, N)
#: Three arches and two rails between their feet.
ARCHES = [np.stack([np.cos(TURN), 0 * TURN + y, np.sin(TURN)], axis=1) for y in (0.0, 2.0, 4.0)]
RAILS = [np.stack([0 * ALONG + x, ALONG, 0 * ALONG], axis=1) for x in (-1.0, 1.0)]
CURVES = [*ARCHES, *RAILS]


def as_obj(curves: list[np.ndarray], *, pairs: bool, first: str = "# curves") -> bytes:
    """Every curve with vertices of its own, as one element or as one for each of its edges."""
    lines, at = [first], 1
    for k, curve in enumerate(curves):
        lines.append(f"o curve.{k}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in curve.tolist()]
        steps = [(i, i + 1) for i in range(at, at + len(curve) - 1)]
        names = steps if pairs else [range(at, at + len(curve))]
        lines += ["l " + " ".join(map(str, name)) for name in names]
        at += len(curve)
    return ("\n".join(lines) + "\n").encode()


def lengths(network: CurveNetwork) -> list[float]:
    return sorted(round(curve.length, 9) for curve in network.curves)


@pytest.mark.parametrize("pairs", [False, True])
@pytest.mark.parametrize("first", ["# curves", "o first", "v 9 9 9", "\ufeff# curves", "g a"])
def test_the_network_is_that_of_the_same_curves_as_json(pairs: bool, first: str) -> None:
    document = {"curves": [{"points": curve.tolist()} for curve in CURVES]}
    expected = parse_drawing(json.dumps(document).encode())
    text = as_obj(CURVES, pairs=pairs, first=first)
    if first.startswith("v"):  # a vertex that no element names counts all the same
        words = [line.split() for line in text.decode().splitlines()]
        text = "\n".join(
            " ".join([w[0], *(str(int(v) + 1) for v in w[1:])]) if w[0] == "l" else " ".join(w)
            for w in words
        ).encode()
    drawing = parse_drawing(text)
    assert lengths(drawing.network) == lengths(expected.network)
    assert len(drawing.network.nodes) == len(expected.network.nodes)
    assert drawing.notes == expected.notes


def test_elements_that_share_a_vertex_meet_there() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 1 1 0\nv 1 2 0\nl 1 2 3\nl 2 4 5\n"
    network = parse_drawing(text.encode()).network
    assert lengths(network) == [1.0, 1.0, 2.0]
    (shared,) = [k for k in range(4) if sum(k in c.nodes for c in network.curves) == 3]
    assert network.nodes[shared].tolist() == [1.0, 0.0, 0.0]


def test_chains_are_curves_that_end_at_corners_and_where_others_meet() -> None:
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    for elements in ("l 1 2\nl 2 3\nl 3 4\nl 4 1\n", "l 2 1\nl 2 3\nl 4 3\nl 1 4\nl 1 2\n"):
        network = parse_drawing((square + elements).encode()).network
        assert lengths(network) == [1.0] * 4 and len(network.nodes) == 4
    # A circle of elements of two vertices is one closed curve, in whatever order they stand.
    points = [f"v {np.cos(t):.17g} {np.sin(t):.17g} 0" for t in 2 * np.pi * np.arange(40) / 40]
    order = np.random.default_rng(1).permutation(40)
    elements = [f"l {k + 1} {(k + 1) % 40 + 1}" for k in order.tolist()]
    network = parse_drawing("\n".join([*points, *elements, ""]).encode()).network
    assert len(network.curves) == 1 and network.curves[0].nodes[0] == network.curves[0].nodes[1]
    assert len(network.curves[0].points) == 41


def test_indices_may_be_relative_have_texture_coordinates_and_be_continued() -> None:
    text = "v 0 0 0\nv 1 0 0\nv 2 0 0\n"
    plain = parse_drawing((text + "l 1 2 3\n").encode()).network
    for element in ("l -3 -2 -1", "l 1/1 2/2 3/3", "l 1 \\\n2 3", "l 1 2 3 # a comment"):
        for end in ("\n", "\r\n", "\r"):
            again = parse_drawing(f"{text}{element}\n".replace("\n", end).encode()).network
            assert [c.points.tolist() for c in again.curves] == [
                c.points.tolist() for c in plain.curves
            ]
    # Names may have any bytes, and a backslash at their end; faces are left out.
    odd = b"# \xe9\ng a\\\nusemtl C:\\\n" + text.encode() + b"vt 0 0\nf 1 2 3\nl 1 2 3\n"
    assert lengths(parse_drawing(odd).network) == lengths(plain)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"o a\nv 0 0 0\nv 1 0 0\nl 1 3\n", "line 4: the element names vertex 3; the file has 2"),
        (b"o a\nv 0 0 0\nv 1 0 0\nl 1\n", "line 4: a line element has two vertices"),
        (b"o a\nv 0 0 0\nv 1 0 0\nl 0 1\n", "line 4: '0' is not the number of a vertex"),
        (b"o a\nv 0 0 0\nl -2 -1\n", "line 3: -2 reaches back"),
        (b"o a\nv 0 0\nl 1 2\n", "line 2: a vertex has three numbers, this one has 2"),
        (b"o a\nv 0 0 x\nl 1 2\n", "line 2: '0 0 x' is not three numbers"),
        (b"o a\nv 0 0 nan\nv 1 0 0\nl 1 2\n", "finite"),
        (b"o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "1 faces and no curves"),
        (b"# nothing\n", "no curves, elements that begin with l"),
        (gzip.compress(b"o a\n", mtime=0), r"compressed \(gzip\)"),
    ],
)
def test_refusals(text: bytes, words: str) -> None:
    with pytest.raises(InvalidNetworkError, match=words):
        parse_drawing(text)


def test_polylines_as_drawn_are_still_read() -> None:
    network = parse_drawing(b"v 2 0 0 0 1 0 0\nv 2\n1 0 0\n1 1 0\n").network
    assert lengths(network) == [1.0, 1.0]
