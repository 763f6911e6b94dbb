"""Writes hand.jsonl: a hand, every finger with rings at its joints.

    python examples/retopo/make_hand.py ../shared/data/surfaces/hand_closed.obj

y is up along the fingers, the palm looks along +z, the thumb is at -x. Names of places: i m r p t
for index, middle, ring finger, pinky and thumb; 0 1 2 for the rings at base, joint and tip; l f r b
for left, front (palm), right and back; k around the knuckles, w in the webs, v around the wrist
and u around its rim.
"""

from __future__ import annotations

from itertools import pairwise

from making import made
from sketching import Sketch

#: Middles of the rings of every finger, and the way it points.
FINGERS = {
    "i": ([(-0.12, 0.62, 0.06), (-0.127, 0.75, 0.06), (-0.1255, 0.885, 0.065)], (-0.04, 1, 0)),
    "m": ([(0.0, 0.625, 0.05), (0.02, 0.77, 0.045), (0.0445, 0.925, 0.05)], (0.18, 1, 0)),
    "r": ([(0.078, 0.6, 0.07), (0.12, 0.715, 0.065), (0.169, 0.838, 0.065)], (0.35, 1, 0)),
    "p": ([(0.187, 0.535, 0.095), (0.235, 0.595, 0.11), (0.298, 0.664, 0.108)], (0.8, 1, 0)),
    "t": ([(-0.28, 0.405, 0.14), (-0.335, 0.475, 0.14), (-0.385, 0.541, 0.145)], (-0.7, 0.8, 0)),
}

#: Height of the ring below the fingers, and where lines from fingers and webs cross it.
KNUCKLES = 0.447
COLUMNS = {"i": -0.115, "im": -0.06, "m": -0.015, "mr": 0.03, "r": 0.075, "rp": 0.125, "p": 0.165}


def draw(s: Sketch) -> None:
    """All curves: rings, then lines."""
    s.once("sizes", edge=0.027, snap=0.012)
    for name, (middles, way) in FINGERS.items():
        across = (way[1], -way[0], 0)
        back = (-across[0], -across[1], 0)
        for k, at in enumerate(middles):
            ways = {"l": back, "f": (0, 0, 1), "r": across, "b": (0, 0, -1)}
            s.ring(at, way, {f"{name}{k}{side}": way for side, way in ways.items()}, inside=True)
    s.ring((0, KNUCKLES, 0.12), (0, 1, 0), {"kl": (-1, 0, 0), "kr": (1, 0, 0)})
    sides = {"l": (-1, 0, 0.1), "f": (0, 0, 1), "r": (1, 0, 0.1), "b": (0, 0, -1)}
    s.ring((0, 0.14, 0.13), (0, 1, 0), {f"v{side}": way for side, way in sides.items()})
    corners = {"1": (-1, 0, 1), "2": (1, 0, 1), "3": (1, 0, -1), "4": (-1, 0, -1)}
    ways = {f"u{side}": way for side, way in (sides | corners).items()}
    s.ring((0, 0.005, 0.12), (0, 1, 0.122), ways)
    s.seen("-y", u0=(-0.03, 0.02))
    s.seen("+z", **{f"k{name}f": (x, KNUCKLES) for name, x in COLUMNS.items()})
    s.seen("-z", **{f"k{name}b": (x, KNUCKLES) for name, x in COLUMNS.items()})
    s.near(wim=(-0.06, 0.575, 0.06), wmr=(0.045, 0.555, 0.065), wrp=(0.135, 0.487, 0.085))
    s.seen("+z", hf=(0.01, 0.29))
    s.seen("-z", hb=(0.01, 0.29))
    s.seen("+x", hr=(0.29, 0.06))
    _lines(s)
    _counts(s)


def _lines(s: Sketch) -> None:
    s.line(*_down("i", "l"), "kl", *_up("t", "r"))
    s.line(*_down("i", "r"), "wim", *_up("m", "l"))
    s.line(*_down("m", "r"), "wmr", *_up("r", "l"))
    s.line(*_down("r", "r"), "wrp", *_up("p", "l"))
    s.line(*_down("p", "r"), "kr", "hr", "vr", "ur")
    s.line(*_down("t", "l"), "vl", "ul")
    s.line(*_down("t", "f"), "hf", "hr", "hb", *_up("t", "b"))
    s.line("uf", "vf", "hf", "kmrf", "wmr", "kmrb", "hb", "vb", "ub")
    s.halfway(ef="hf vf", eb="hb vb", el="t0l vl", er="hr vr")
    s.line("el", "ef", "er", "eb", closed=True)
    for web in ("im", "rp"):
        s.line(f"k{web}f", f"w{web}", f"k{web}b")
    s.line("u1", "u0", "u3")
    s.line("u2", "u0", "u4")
    for finger in "imrp":
        s.line(*_down(finger, "f"), f"k{finger}f")
        s.line(*_down(finger, "b"), f"k{finger}b")


def _counts(s: Sketch) -> None:
    tips = {name: middles[2] for name, (middles, _) in FINGERS.items()}
    ways = {name: way for name, (_, way) in FINGERS.items()}
    far = {
        name: tuple(a + 0.04 * b for a, b in zip(tips[name], ways[name], strict=True))
        for name in tips
    }
    s.caps(far, {name: f"{name}2l {name}2f {name}2r {name}2b" for name in FINGERS})
    s.caps(
        {"a": (-0.1, 0, 0.02), "b": (-0.03, 0, 0.09), "c": (0.05, 0, 0.02), "d": (-0.03, 0, -0.05)},
        {"a": "ul", "b": "uf", "c": "ur", "d": "ub"},
    )
    for name in FINGERS:
        for one, two in ("lf", "fr", "rb", "bl"):
            s.edges(f"{name}2{one} {name}2{two}", 3 if name == "t" else 2)
    around = "l1f2r3b4l"
    for one, two in pairwise(around):
        s.edges(f"u{one} u{two}", 3)
    s.once("recount")


def _down(finger: str, side: str) -> list[str]:
    return [f"{finger}{k}{side}" for k in (2, 1, 0)]


def _up(finger: str, side: str) -> list[str]:
    return [f"{finger}{k}{side}" for k in (0, 1, 2)]


if __name__ == "__main__":
    made("hand_closed.jsonl", draw)
