"""Writes spot.jsonl: the cow spot, one half drawn and the other its mirror image.

    python examples/retopo/make_spot.py ../shared/data/surfaces/spot.obj

y is up, the nose looks along -z, x = 0 is the plane of symmetry. Names of places: c on the back,
b under the belly, a on the flank, f and r at the front and rear legs (fo front outer, bi back
inner, ...), g and q at their feet, n on the neck, m around the muzzle, e at the ear, h at the
horn, t at the tail.
"""

from __future__ import annotations

from making import made
from sketching import Sketch

#: Places within caps, and the corners of these.
INSIDE = {
    "g": (0.245, -0.73, 0.06),
    "q": (0.205, -0.73, 0.78),
    "i": (0.47, 0.75, -0.25),
    "j": (0.19, 1.02, -0.3),
    "m": (0.15, 0.33, -0.66),
    "w": (0.15, 0.46, -0.62),
    "t": (0.03, -0.05, 1.05),
}
CAPS = {
    "g": "gfo gfi gbi gbo",
    "q": "qfo qfi qbi qbo",
    "i": "ib iu if id",
    "j": "jb jo jf ji",
    "m": "m2",
    "w": "m0",
    "t": "ts",
}

#: Edges where as many as lengths ask for would be too few: round ends, and what is curved.
EDGES = {
    **dict.fromkeys(("gfo gfi", "gfi gbi", "gbi gbo", "gbo gfo"), 4),
    **dict.fromkeys(("qfo qfi", "qfi qbi", "qbi qbo", "qbo qfo"), 4),
    **dict.fromkeys(("eb eu", "eu ef", "ef ed", "ed eb"), 3),
    "m1 mc": 6,
    "m1 m2": 5,
    "m2 mb": 3,
    "eu ho": 4,
    "hi c0": 4,
}


def draw(sketch: Sketch) -> None:
    """All curves, from the long ones to the short ones."""
    _body(sketch)
    _head(sketch)
    _join(sketch)


def _body(s: Sketch) -> None:
    s.once("sizes", edge=0.062, snap=0.02)
    s.once("loop", at=[0.0, 0.22, 0.6], normal=[1.0, 0.0, 0.0])
    s.seen("+y", c1=(0, 0.13), c2=(0, 0.3), c3=(0, 0.6), c4=(0, 0.84))
    s.seen("-y", b1=(0, 0.13), b2=(0, 0.66), b0=(0, -0.01), b3=(0, 0.84))
    s.seen("+x", a1=(0.0, 0.03), a2=(-0.02, 0.22), a3=(-0.04, 0.6), a4=(-0.06, 0.89))
    s.near(ffo=(0.35, -0.3, -0.04), ffi=(0.14, -0.42, -0.03))
    s.near(fbi=(0.15, -0.45, 0.17), fbo=(0.34, -0.4, 0.18))
    s.near(rfo=(0.33, -0.4, 0.64), rfi=(0.12, -0.45, 0.66))
    s.near(rbi=(0.11, -0.38, 0.87), rbo=(0.32, -0.3, 0.9))
    s.line("ffo", "ffi", "fbi", "fbo", closed=True)
    s.line("rfo", "rfi", "rbi", "rbo", closed=True)
    ways = (1, 0, -1), (-1, 0, -1), (-1, 0, 1), (1, 0, 1)
    ends = "fo", "fi", "bi", "bo"
    s.ring(
        (0.245, -0.64, -0.06),
        (0, 1, 0),
        {f"g{end}": way for end, way in zip(ends, ways, strict=True)},
    )
    s.ring(
        (0.205, -0.64, 0.92),
        (0, 1, 0),
        {f"q{end}": way for end, way in zip(ends, ways, strict=True)},
    )
    s.ring((0, -0.02, 1.01), (0, -0.3, 1), {"tt": (0, 1, 0), "tb": (0, -1, 0), "ts": (1, 0, 0)})
    s.line("gfo", "ffo", "a1", "c1", "a1'", "ffo'", "gfo'")
    s.line("gbo", "fbo", "a2", "c2", "a2'", "fbo'", "gbo'")
    s.line("qfo", "rfo", "a3", "c3", "a3'", "rfo'", "qfo'")
    s.line("qbo", "rbo", "a4", "c4", "a4'", "rbo'", "qbo'")
    s.line("gfi", "ffi", "b0", "ffi'", "gfi'")
    s.line("gbi", "fbi", "b1", "fbi'", "gbi'")
    s.line("qfi", "rfi", "b2", "rfi'", "qfi'")
    s.line("qbi", "rbi", "b3", "rbi'", "qbi'")
    s.line("fbo", "rfo")
    s.line("fbi", "rfi")


def _head(s: Sketch) -> None:
    ways = {"nt": (0, 1, 0), "n0": (0.6, 1, 0), "n1": (1, 0.4, 0), "n2": (0.8, -1, 0)}
    s.ring((0, 0.42, 0.0), (0, 0.63, -0.77), {**ways, "nb": (0, -1, 0)})
    ways = {"mt": (0, 1, 0), "m0": (0.5, 1, 0), "m1": (1, 0.4, 0), "m2": (1, -0.8, 0)}
    s.ring((0, 0.56, -0.57), (0, 0.15, 0.395), {**ways, "mb": (0, -1, 0)})
    ways = (0, 0.3, 1), (0, 1, 0), (0, -0.3, -1), (0, -1, 0)
    s.ring((0.31, 0.82, -0.27), (1, 0, 0), dict(zip(("eb", "eu", "ef", "ed"), ways, strict=True)))
    s.ring((0.445, 0.8, -0.23), (1, 0, 0), dict(zip(("ib", "iu", "if", "id"), ways, strict=True)))
    ways = (0, 0, 1), (1, 0, 0), (0, 0, -1), (-1, 0, 0)
    s.ring((0.23, 0.9, -0.3), (0.3, 1, 0), dict(zip(("hb", "ho", "hf", "hi"), ways, strict=True)))
    s.ring((0.22, 0.97, -0.3), (0.3, 1, 0), dict(zip(("jb", "jo", "jf", "ji"), ways, strict=True)))


def _join(s: Sketch) -> None:
    s.seen("+x", k=(0.23, -0.33))
    s.seen("-y", kb=(0, -0.31))
    s.seen("+y", c0=(0, -0.31))
    s.seen("-z", mc=(0, 0.4))
    s.line("ffi", "n2", "k", "m2")
    s.line("rbi", "ts")
    s.line("ts", "a4", "a3", "a2", "a1", "n1", "eb", "ib")
    s.line("id", "ed", "k", "kb", "k'", "ed'", "id'")
    s.line("if", "ef", "m1", "mc", "m1'", "ef'", "if'")
    s.line("iu", "eu", "ho", "jo")
    s.line("ji", "hi", "c0", "hi'", "ji'")
    s.line("n0", "hb", "jb")
    s.line("m0", "hf", "jf")
    s.line("ef", "hf")
    s.line("eb", "hb")
    s.caps(INSIDE, CAPS)
    for between, count in EDGES.items():
        s.edges(between, count)
    s.once("recount")


if __name__ == "__main__":
    made("spot.jsonl", draw, mirror=0)
