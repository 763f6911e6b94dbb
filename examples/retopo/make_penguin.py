"""Writes penguin.jsonl: a penguin that turns its head, flippers and feet drawn out of its body.

    python examples/retopo/make_penguin.py ../shared/data/surfaces/penguin.obj

y is up, its front looks along +z, its head to -x. Names of places: n around the neck, w around the
waist, c on the chest and at the back of it, x below the
armpits, a h g p along the
flippers, k at the ankles, r and
s around the feet, t at the tail, b at the beak; r or l after them for the side, +x or -x, where there are two.
"""

from __future__ import annotations

from making import made
from sketching import Sketch

FRONT, BACK, UP, DOWN = (0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0)

#: Of the flippers: middles of the rings at the shoulder, twice halfway and at the tip, and the way they hang.
FLIPPERS = {
    "r": [
        ((0.665, 0.27, 0), (0.3, -1, 0)),
        ((0.84, -0.25, 0), (0.1, -1, 0)),
        ((0.84, -0.52, 0), DOWN),
        ((0.825, -0.7, 0), DOWN),
    ],
    "l": [
        ((-0.57, 0.26, 0), (-0.3, -1, 0)),
        ((-0.775, -0.25, 0), (-0.1, -1, 0)),
        ((-0.8, -0.54, 0), DOWN),
        ((-0.79, -0.735, 0), DOWN),
    ],
}

#: Of the feet: the middle of the ankle, and of the sole outwards, the toes, inwards and the heel.
FEET = {
    "r": ((0.245, -1.335, 0.0), ((1, 0, 0.2), (0.3, 0, 1), (-1, 0, -0.2), (0, 0, -1))),
    "l": ((-0.11, -1.335, 0.0), ((-1, 0, 0.2), (-0.3, 0, 1), (1, 0, -0.2), (0, 0, -1))),
}

#: Stiffness of the lines through the armpits.
FOLD = 20.0

#: Edges where as many as lengths ask for would be too few.
EDGES = {"hr ht": 5, "hl ht": 5, "hb ht": 4, "hb hr": 5, "hb hl": 5, "nb hb": 3, "kro rro": 6, "klo rlo": 6, "ari xr": 4, "ali xl": 4}


def draw(s: Sketch) -> None:
    """All curves: rings, then lines, then counts."""
    s.once("sizes", edge=0.08, snap=0.03)
    _rings(s)
    _trunk(s)
    _head(s)
    for side, other in ("rl", "lr"):
        _limbs(s, side)
    _counts(s)


def _rings(s: Sketch) -> None:
    around = {"f": FRONT, "r": (1, 0, 0), "b": BACK, "l": (-1, 0, 0)}
    s.ring((0.07, 0.665, 0), UP, {f"n{k}": way for k, way in around.items()}, inside=True)
    around |= {"fr": (1, 0, 1), "br": (1, 0, -1), "bl": (-1, 0, -1), "fl": (-1, 0, 1)}
    s.ring((0.03, -0.6, 0), UP, {f"w{k}": way for k, way in around.items()}, inside=True)
    ways = {"tu": UP, "tr": (1, 0, 0), "td": DOWN, "tl": (-1, 0, 0)}
    s.ring((0.06, -1.1, -0.47), (0, -0.4, -1), ways, inside=True)
    ways = {"vu": UP, "vr": (1, 0, 0), "vd": DOWN, "vl": (-1, 0, 0)}
    s.ring((0.06, -1.245, -0.785), (0, -0.4, -1), ways, inside=True)
    ways = {"bu": UP, "br": (0.8, 0, 0.5), "bd": DOWN, "bl": (-0.8, 0, -0.5)}
    s.ring((-0.14, 0.875, 0.38), (-0.5, -0.25, 0.83), ways, inside=True)
    ways = {"eu": UP, "er": (0.8, 0, 0.5), "ed": DOWN, "el": (-0.8, 0, -0.5)}
    s.ring((-0.255, 0.82, 0.55), (-0.5, -0.25, 0.83), ways, inside=True)
    for side, rings in FLIPPERS.items():
        out = (1 if side == "r" else -1, 0, 0)
        ways = {"o": out, "f": FRONT, "i": (-out[0], 0, 0), "b": BACK}
        for name, (middle, way) in zip("ahgp", rings, strict=True):
            s.ring(middle, way, {f"{name}{side}{k}": w for k, w in ways.items()}, inside=True)
    for side, (ankle, sole) in FEET.items():
        out = (1 if side == "r" else -1, 0, 0)
        ways = {"o": out, "f": FRONT, "i": (-out[0], 0, 0), "b": BACK}
        s.ring(ankle, UP, {f"k{side}{k}": w for k, w in ways.items()}, inside=True)
        ways = dict(zip("ofib", sole, strict=True))
        for name, height in {"r": -1.47, "s": -1.54}.items():
            middle = (ankle[0] + 0.15 * out[0], height, 0.2)
            s.ring(middle, UP, {f"{name}{side}{k}": w for k, w in ways.items()}, inside=True)


def _trunk(s: Sketch) -> None:
    s.seen("+z", cf=(0.03, 0.2))
    s.seen("-z", cb=(0.03, 0.2))
    s.seen("-y", cd=(0.065, 0.0))
    s.line("ed", "bd", "nf", "cf", "wf", "cd", "td", "vd")
    s.line("nb", "cb", "wb", "tu", "vu")
    s.near(xr=(0.56, 0.2, 0), xrf=(0.47, 0.27, 0.22), xrb=(0.47, 0.27, -0.22))
    s.near(xl=(-0.44, 0.2, 0), xlf=(-0.33, 0.26, 0.25), xlb=(-0.33, 0.26, -0.25))
    s.line("arf", "xrf", "cf", "xlf", "alf")
    s.line("arb", "xrb", "cb", "xlb", "alb")
    s.line("kri", "cd", "kli")
    for side in "rl":
        s.line(f"wf{side}", f"k{side}f", f"r{side}f", f"s{side}f")
        s.line(f"wb{side}", f"t{side}", f"v{side}")
        s.line(f"k{side}b", f"t{side}")


def _head(s: Sketch) -> None:
    s.seen("+y", ht=(0.07, 0.0))
    s.seen("-z", hb=(0.1, 0.95))
    s.seen("+x", hr=(0.98, 0.06))
    s.seen("-x", hl=(0.98, -0.05))
    s.line("eu", "bu", "ht", "hb", "nb")
    s.line("nr", "hr", "ht", "hl", "nl")
    s.line("er", "br", "hr", "hb", "hl", "bl", "el")


def _limbs(s: Sketch, side: str) -> None:
    flipper = {k: [f"a{side}{k}", f"h{side}{k}", f"g{side}{k}", f"p{side}{k}"] for k in "ofib"}
    s.line(f"n{side}", *flipper["o"])
    s.line(*reversed(flipper["i"]), f"x{side}", f"w{side}", stiffness=FOLD)
    s.line(f"x{side}f", f"x{side}", f"x{side}b")
    s.line(f"w{side}", f"k{side}o", f"r{side}o", f"s{side}o")
    s.line(*flipper["f"])
    s.line(*flipper["b"])
    s.line(f"s{side}i", f"r{side}i", f"k{side}i")
    s.line(f"s{side}b", f"r{side}b", f"k{side}b")
    # A ribbon bent around the toes is no patch as a whole: its loop encloses next to nothing.
    s.halfway(**{f"r{side}": f"r{side}f r{side}i", f"s{side}": f"s{side}f s{side}i"})
    s.line(f"r{side}", f"s{side}")


def _counts(s: Sketch) -> None:
    s.caps(
        {
            "pr": (0.83, -0.75, 0.0),
            "pl": (-0.79, -0.78, 0.0),
            "dr": (0.42, -1.6, 0.2),
            "dl": (-0.28, -1.6, 0.2),
            "v": (0.06, -1.25, -0.82),
            "e": (-0.26, 0.82, 0.56),
        },
        {
            "pr": "pro prf pri prb",
            "pl": "plo plf pli plb",
            "dr": "sro srf sri srb",
            "dl": "slo slf sli slb",
            "v": "vu vr vd vl",
            "e": "eu er ed el",
        },
    )
    for side in "rl":
        for one, two in ("of", "fi", "ib", "bo"):
            s.edges(f"k{side}{one} k{side}{two}", 4)
            s.edges(f"a{side}{one} a{side}{two}", 4)
    for between, count in EDGES.items():
        s.edges(between, count)
    s.once("recount")


if __name__ == "__main__":
    made("penguin.jsonl", draw)
