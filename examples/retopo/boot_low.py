"""The boot below its ring m: toe, sole, sides, heel, and the lower throat with two rows of laces.

Four rings go around: b on the edge of the sole's bottom, w on the edge of the welt, y above it on
the upper, and v along the middle of the upper, from heel to heel around the toe. Columns cross
them: o at the back, h at the heel, k behind the arch, a to p along it, r, and q where the flaps
end, t and n at the toe; g is the middle of the bottom. Names end with l or r for left and right.

Between the flaps two rows of laces lie. Five times they bridge what is below: both laces of the
second row (a from the right eyelet, b from the left one) from their eyelet to the flap's edge, and
from there to where they meet; and the straight lace of the first row (c) from edge to edge. Such a
bridge is a tube between two rings, with curves along it in front (f, towards the toe) and at the
back (k).
"""

from __future__ import annotations

import numpy as np
from sketching import ROUNDS, Points, Sketch

#: Target length of an edge (m).
EDGE = 0.0105

#: The throat's own axes: where they begin (m), and the ways down it and off it; the third is z.
THROAT = np.array([0.0199, 0.1170, 0.0])
DOWN = np.array([0.829, -0.559, 0.0])
OFF = np.array([0.559, 0.829, 0.0])

#: Rings around what of a lace bridges, in mm down the throat, to the left and off it: a middle
#: and the way that the lace runs.
LACES = {
    "a0": ((18.7, -20.0, 1.7), (0.54, -0.70, -0.47)),
    "a1": ((16.7, -17.3, 3.2), (0.53, -0.78, -0.06)),
    "a2": ((10.5, -6.5, 4.5), (0.44, -0.87, 0.20)),
    "a3": ((8.1, -2.2, 3.3), (0.48, -0.84, 0.24)),
    "b0": ((20.2, 24.8, 0.2), (0.45, 0.68, -0.65)),
    "b1": ((18.1, 21.3, 2.7), (0.38, 0.84, -0.15)),
    "b2": ((14.8, 13.0, 3.3), (0.43, 0.90, 0.02)),
    "b3": ((10.2, 2.8, 0.0), (0.38, 0.88, 0.30)),
    "c1": ((46.0, 14.0, 4.9), (0.0, 1.0, 0.0)),
    "c2": ((45.8, -8.5, 4.9), (0.0, 1.0, 0.0)),
}
#: Places on such a ring: in front, on top, at the back, and below.
AROUND = {"f": (1, 0, 0), "t": (0, 0, 1), "k": (-1, 0, 0), "u": (0, 0, -1)}
#: Other places of the throat, so measured; a name here has a number after it, from 0.
# fmt: off
INNER = {
    # The flaps' edges, from the second row down and around the front.
    "el": [
        (23.0, 18.0, 3.3), (31.0, 18.0, 3.4), (38.0, 17.8, 3.4), (49.5, 17.0, 3.0),
        (57.5, 22.0, 0.3), (62.0, 31.0, -6.0),
    ],
    "er": [
        (23.0, -13.0, 4.3), (31.0, -13.0, 4.5), (38.0, -13.0, 4.6), (49.5, -12.5, 3.0),
        (56.0, -13.5, 1.0), (61.5, -24.0, -3.5),
    ],
    # The feet of the flaps' walls, beside the crease; the last ones in front of the flaps.
    "fl": [
        (1.5, 14.8, -4.0), (8.4, 15.3, -5.9), (16.2, 15.4, -5.8), (26.0, 14.8, -4.6),
        (31.0, 17.0, -7.2), (39.5, 17.0, -4.6), (46.5, 19.3, -6.9), (54.2, 21.0, -5.0),
        (60.0, 25.0, -5.2), (62.5, 31.0, -9.5),
    ],
    "fr": [
        (-1.0, -9.3, -2.5), (3.3, -10.5, -5.0), (13.0, -12.0, -7.5), (26.5, -13.5, -5.6),
        (30.3, -16.9, -8.0), (40.0, -12.6, -2.6), (46.5, -12.0, -5.8), (56.0, -11.0, -2.2),
        (59.5, -17.5, -3.8), (62.0, -24.0, -7.0),
    ],
    # The middle of the floor: behind, upon and before the place where the second row's laces meet,
    # on the floor, where the first row's laces cross, and below the straight lace.
    "m": [
        (4.0, 3.0, -0.5), (5.3, 3.2, 3.2), (10.5, 0.3, 0.6), (11.0, 0.3, -5.6),
        (20.0, 0.0, -3.3), (32.5, 0.5, 0.9), (45.8, 0.0, -4.0),
    ],
    # Where the second row's laces lie on the flaps' edges, in front and at the back.
    "ob": [(18.8, 17.5, 2.8), (14.3, 17.5, 2.8)],
    "oa": [(15.0, -12.5, 4.0), (11.5, -12.5, 4.0)],
    # Below the bridges upon the flaps: in front on the floor and where it ends at the edge, the
    # same at the back, and the lace's foot at the eyelet, at the back and in front.
    "ub": [
        (20.3, 22.9, -3.2), (19.2, 19.4, 1.6), (16.8, 23.0, -3.4), (16.0, 19.6, 1.6),
        (18.3, 25.2, -3.0), (21.8, 24.2, -2.8),
    ],
    "ua": [
        (18.8, -17.5, -0.3), (17.6, -15.2, 1.2), (15.9, -18.4, -1.5), (14.6, -16.0, 0.8),
        (17.9, -21.0, -2.2), (20.7, -19.4, -1.2),
    ],
    # From the place where the laces meet down to the floor, left and right.
    "pl": [(8.9, 1.0, 0.3), (8.6, 5.0, -2.6)],
    "pr": [(4.9, -0.5, 2.0), (5.9, -0.9, -0.8), (5.6, -3.0, -1.6)],
    # Below lace b, from its end where the laces meet to the left foot.
    "z": [(10.3, 1.0, -2.6), (10.4, 3.0, -4.6), (11.8, 9.0, -3.6), (12.3, 15.3, -6.0)],
    # Along laces that are fused to what is below: lace a left of the meeting place, the lace of the
    # first row that lies upon the other, and the straight one upon the flaps.
    "d": [(3.5, 7.5, 0.9)],
    "x": [(28.5, 7.5, -0.3), (37.6, -6.5, -0.4)],
    "cl": [(46.0, 22.0, 5.0), (46.5, 29.0, 0.8)],
    "cr": [(46.0, -18.0, 5.0), (46.5, -24.0, 0.8)],
}
# fmt: on

#: Where the columns cross the welt, (x, y) from the side, and the bottom's edge, (x, z) from below
#: (m): on treads, where there are any.
LEFT = {
    "h": ((-0.120, 0.0465), (-0.1175, 0.0340)),
    "k": ((-0.085, 0.0480), (-0.085, 0.0430)),
    "a": ((-0.042, 0.0465), None),
    "f": ((-0.008, 0.0375), None),
    "p": ((0.018, 0.0315), None),
    "r": ((0.043, 0.0285), (0.043, 0.0520)),
    "q": ((0.070, 0.0282), (0.070, 0.0535)),
    "t": ((0.103, 0.0297), (0.103, 0.0480)),
    "n": ((0.138, 0.0415), (0.144, 0.0275)),
}
RIGHT = {
    "h": ((-0.120, 0.0465), (-0.1175, -0.0345)),
    "k": ((-0.085, 0.0480), (-0.0775, -0.0415)),
    "a": ((-0.042, 0.0470), None),
    "f": ((-0.008, 0.0385), None),
    "p": ((0.018, 0.0330), None),
    "r": ((0.043, 0.0295), (0.052, -0.0490)),
    "q": ((0.070, 0.0290), (0.078, -0.0505)),
    "t": ((0.103, 0.0340), (0.103, -0.0490)),
    "n": ((0.138, 0.0460), (0.140, -0.0415)),
}
#: How far above the welt's edge ring y is seen (m): beyond the ledge, which is 4 mm wide.
ABOVE = 0.0065
#: The bottom's edge along the arch, (x, y) from the side: left and right.
ARCH = {
    "a": ((-0.0445, 0.0215), (-0.0400, 0.0205)),
    "f": ((-0.010, 0.0160), (-0.008, 0.0165)),
    "p": ((0.0165, 0.0080), (0.026, 0.0120)),
}
#: The middle of the upper, (x, y) from the side: left and right. s, u and e are where curves from
#: the flaps end between r and q, c is halfway up column p.
MIDDLE = {
    "a": ((-0.041, 0.0660), (-0.041, 0.0700)),
    "f": ((-0.008, 0.0690), (-0.008, 0.0710)),
    "p": ((0.018, 0.0705), (0.018, 0.0720)),
    "r": ((0.043, 0.0690), (0.043, 0.0710)),
    "s": ((0.0510, 0.0688), (0.0510, 0.0707)),
    "u": ((0.0585, 0.0680), (0.0585, 0.0700)),
    "e": ((0.0630, 0.0674), (0.0630, 0.0695)),
    "q": ((0.0655, 0.0670), (0.0655, 0.0690)),
    "c": ((0.0170, 0.0950), (0.0150, 0.0980)),
    "t": ((0.103, 0.0540), (0.103, 0.0560)),
    "n": ((0.138, 0.0560), (0.138, 0.0590)),
}
#: Where the bottom's edge turns, (x, z) from below, left and right: at the steps of the arch (heel,
#: ball), behind (bb) and before (bd) the heel, around the toe (bm).
TURNS = {
    "heel": ((-0.0495, 0.0415), (-0.0450, -0.0375)),
    "ball": ((0.0215, 0.0500), (0.0345, -0.0400)),
    "bb": ((-0.1265, 0.0240), (-0.1265, -0.0235)),
    "bd": ((-0.0580, 0.0435), (-0.0550, -0.0405)),
    "bm": ((0.1575, 0.0175), (0.1575, -0.0325)),
}


def low(s: Sketch) -> None:
    """All its curves."""
    s.once("sizes", edge=EDGE)
    before = s.spacing, s.fine
    s.spacing, s.fine = 0.006, 0.003
    _places(s)
    _rings(s)
    _columns(s)
    _bottom(s)
    s.spacing, s.fine, s.rounds = 0.002, 0.001, 0
    _bridges(s)
    _flaps(s)
    _floor(s)
    _counts(s)
    s.spacing, s.fine, s.rounds = *before, ROUNDS


def _places(s: Sketch) -> None:
    """Name all places."""
    for side, view, table in (("l", "+z", LEFT), ("r", "-z", RIGHT)):
        k = "lr".index(side)
        for name, (welt, edge) in table.items():
            foot = welt[0], welt[1] + ABOVE
            s.seen(view, **{f"l_w{name}{side}": welt, f"l_y{name}{side}": foot})
            if edge is not None:
                s.seen("-y", **{f"l_b{name}{side}": edge})
        for name, at in ARCH.items():
            s.seen(view, **{f"l_b{name}{side}": at[k]})
        for name, at in MIDDLE.items():
            s.seen(view, **{f"l_v{name}{side}": at[k]})
        for name, at in TURNS.items():
            s.seen("-y", **{f"l_{name}{side}": at[k]})
    for name, ats in INNER.items():
        s.near(**{f"l_{name}{k}": _in_throat(at) for k, at in enumerate(ats)})
    s.seen("-x", l_wo=(0.0465, -0.002), l_yo=(0.0530, -0.002))
    s.seen("+x", l_bn=(0.0290, -0.006), l_wn=(0.0500, -0.006))
    s.seen("+x", l_yn=(0.0565, -0.006), l_vn=(0.0640, -0.006))
    s.seen("+y", l_ct=(0.103, -0.001), l_c0=(0.066, 0.0))
    s.seen("-y", l_bo=(-0.1345, -0.006), l_gk=(-0.085, 0.0), l_gheel=(-0.0445, 0.001))
    s.seen("-y", l_ga=(-0.0395, 0.001), l_gf=(-0.01, 0.001), l_gp=(0.01, 0.001))
    s.seen("-y", l_gball=(0.0195, 0.001), l_gr=(0.043, -0.009), l_gq=(0.070, -0.011))
    s.seen("-y", l_gt=(0.1125, -0.009), l_gn=(0.140, -0.004))


def _rings(s: Sketch) -> None:
    """Around the boot: welt, foot of the upper, edge of the bottom, middle of the upper."""
    for ring in "wy":
        left, right = ([f"l_{ring}{c}{side}" for c in LEFT] for side in "lr")
        s.line(f"l_{ring}o", *left, f"l_{ring}n", *reversed(right), closed=True)
    for side in "lr":
        s.line("l_bo", f"l_bb{side}", f"l_bh{side}", f"l_bk{side}", f"l_bd{side}", f"l_heel{side}")
        s.line(f"l_heel{side}", f"l_ba{side}")
        s.line(*(f"l_b{c}{side}" for c in "afp"))
        s.line(f"l_bp{side}", f"l_ball{side}")
        s.line(f"l_ball{side}", *(f"l_b{c}{side}" for c in "rqtnm"), "l_bn")
    back = [f"l_v{c}r" for c in "ntqeusrpfa"]
    s.line("m_bl", *(f"l_v{c}l" for c in "afprsueqtn"), "l_vn", *back, "m_br")


def _columns(s: Sketch) -> None:
    """From ring m down to the bottom's edge, and over the toe into the throat."""
    s.line("m_back", "l_yo", "l_wo", "l_bo")
    for side in "lr":
        s.line(f"m_h{side}", f"l_yh{side}", f"l_wh{side}", f"l_bh{side}")
        s.line(f"m_b{side}", f"l_yk{side}", f"l_wk{side}", f"l_bk{side}")
        s.line(f"m_{side}", *(f"l_{ring}a{side}" for ring in "vywb"))
        s.line(f"m_f{side}", *(f"l_{ring}f{side}" for ring in "vywb"))
        s.line(f"m_flap_{side}", f"l_vc{side}", *(f"l_{ring}p{side}" for ring in "vywb"))
        for c in "rqn":
            s.line(*(f"l_{ring}{c}{side}" for ring in "vywb"))
    s.line("l_bn", "l_wn", "l_yn", "l_vn", "l_ct", "l_c0", "l_m6", "l_m5", "l_m4", "l_m3", "l_m2")
    s.line("l_btl", "l_wtl", "l_ytl", "l_vtl", "l_ct", "l_vtr", "l_ytr", "l_wtr", "l_btr")


def _bottom(s: Sketch) -> None:
    """Across the bottom, and along its middle."""
    s.line("l_bo", "l_gk", "l_gheel")
    s.line("l_gheel", "l_ga")
    s.line("l_ga", "l_gf", "l_gp")
    s.line("l_gp", "l_gball")
    s.line("l_gball", "l_gr", "l_gq", "l_gt", "l_gn", "l_bn")
    for c in "kafprqtn":
        s.line(f"l_b{c}l", f"l_g{c}", f"l_b{c}r")
    for c in ("heel", "ball"):
        s.line(f"l_{c}l", f"l_g{c}", f"l_{c}r")


def _bridges(s: Sketch) -> None:
    """Where laces bridge: rings around them, and lines along them."""
    for name, (middle, along) in LACES.items():
        around = {f"l_{name}{way}": _turned(at).tolist() for way, at in AROUND.items()}
        s.ring(_in_throat(middle), _turned(along), around, inside=True)
    for one, two in ("a0", "a1"), ("a2", "a3"), ("b0", "b1"), ("b2", "b3"), ("c1", "c2"):
        s.line(f"l_{one}f", f"l_{two}f")
        s.line(f"l_{one}k", f"l_{two}k")
    for lace in "ab":
        s.line(f"l_{lace}1f", f"l_o{lace}0", f"l_{lace}2f")
        s.line(f"l_{lace}1k", f"l_o{lace}1", f"l_{lace}2k")


def _flaps(s: Sketch) -> None:
    """Edges and feet of the flaps, below the bridges upon them, and from there to the middle."""
    for side, lace, c in (("l", "b", "c1"), ("r", "a", "c2")):
        edge, foot = f"l_e{side}", f"l_f{side}"
        s.line(f"m_edge_{side}", f"l_o{lace}1")
        s.line(f"l_o{lace}0", f"{edge}0", f"{edge}1", f"{edge}2", f"l_{c}k")
        s.line(f"l_{c}f", f"{edge}3", f"{edge}4", f"{edge}5", f"l_ve{side}")
        s.line(f"m_foot_{side}", *(f"{foot}{k}" for k in range(10)), f"l_vq{side}")
        s.line(f"{foot}2", f"l_{lace}2f")
        s.line(f"{foot}6", f"l_{c}f")
        s.line(f"{foot}7", "l_c0")
        s.line(f"l_{lace}0f", f"l_u{lace}5", f"l_u{lace}0", f"l_u{lace}1", f"l_{lace}1f")
        s.line(f"l_{lace}0k", f"l_u{lace}4", f"l_u{lace}2", f"l_u{lace}3", f"l_{lace}1k")
        s.line(f"l_u{lace}5", f"l_vr{side}")
        s.line(f"l_u{lace}4", f"l_vp{side}")
        s.line(f"l_u{lace}2", f"l_vc{side}")
        s.line(f"l_{c}t", f"l_c{side}0", f"l_c{side}1", f"l_vu{side}")
        s.line(f"{edge}1", f"l_vs{side}")


def _floor(s: Sketch) -> None:
    """Between the flaps, around the place where the second row's laces meet."""
    s.line("l_b3f", "l_m2", "l_a3f")
    s.line("l_b3k", "l_pl0", "l_m1", "l_pr0", "l_a3k")
    s.line("l_m1", "l_m0", "m_tongue")
    s.line("l_m1", "l_d0", "l_fl0")
    s.line("l_fl2", "l_m3", "l_fr2")
    s.line("l_fl3", "l_x0", "l_m5", "l_x1", "l_fr5")
    s.line("l_pl0", "l_pl1", "l_fl1")
    s.line("l_b3u", "l_z0", "l_z1", "l_z2", "l_z3")
    s.line("l_pr0", "l_pr1", "l_pr2", "l_fr1")


def _counts(s: Sketch) -> None:
    """Edges around laces and along them, where as many as lengths ask for would be too few."""
    for name in LACES:
        # The straight lace's rings have a node on top, one of the others' has one below.
        halves = {"ft": 1, "tk": 1} if name[0] == "c" else {"ft": 2}
        halves |= {"uf": 1, "ku": 1} if name == "b3" else {"ku": 2}
        for (one, two), count in halves.items():
            s.edges(f"l_{name}{one} l_{name}{two}", count)
    for piece in ("l_b3f l_m2", "l_m2 l_a3f", "l_m0 l_m1", "l_d0 l_m1"):
        s.edges(piece, 2)
    for piece in ("l_b3k l_pl0", "l_pl0 l_m1", "l_m1 l_pr0", "l_pr0 l_a3k"):
        s.edges(piece, 1)
    s.edges("l_bmr l_bn", 5)
    s.edges("l_bhl l_bkl", 5)
    s.edges("l_fr3 l_fr4", 5)
    for lace, side in (("b", "l"), ("a", "r")):
        s.edges(f"l_u{lace}0 l_u{lace}1", 2)
        s.edges(f"l_u{lace}2 l_u{lace}3", 2)
        s.edges(f"l_{lace}2f l_{lace}3f", 2)
        s.edges(f"l_{lace}2k l_{lace}3k", 2)
        s.edges(f"l_e{side}0 l_e{side}1", 3)
        s.edges(f"l_e{side}1 l_e{side}2", 3)
        s.edges(f"l_e{side}4 l_e{side}5", 5)


def _in_throat(at: tuple[float, float, float]) -> list[float]:
    """A place in space (m) from one of the throat (mm)."""
    return (THROAT + 1e-3 * _turned(at)).tolist()


def _turned(way: tuple[float, float, float]) -> Points:
    """A way in space from one of the throat: down, left, off."""
    down, left, off = way
    return down * DOWN + off * OFF + np.array([0.0, 0.0, left])
