"""The boot above its ring h: collar, cavity, tongue, and two rows of laces with hooks.

Places are told in tables, name and numbers (mm), and curves by the places they run through. Names:
k on the collar's lower seam, s half way up, r on its rim, f around the cavity's floor, v where the
tongue's sides meet the collar, c along the tongue's middle; l and r, with a number, at the feet of
the flaps beside the tongue, el and er on the flaps' edges, kl and kr over their eyelets and hooks,
the number being the height in the throat.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from sketching import ROUNDS, Sketch

#: The throat's frame: its origin (m), on the tongue beside ring h, and the way up the tongue.
#: Places of the throat are told in it: up the tongue, off it, and to the left (+z).
FOOT = (0.0064, 0.1247, 0.0)
UP = (-0.4202, 0.9074, 0.0)

#: Target length of an edge (m), and a short one while curves are drawn in narrow folds that close
#: no patch yet: a point of a stroke is never taken further than some edges to the surface.
EDGE = 0.0105
NARROW = 0.0006

#: Columns up the ankle where they cross the collar's seam, and further up; the upper end of the
#: heel's tab: x, y, z.
SEAM = """
k_back -113.5 127.5 -3; k_hl -98.5 135 26; k_bl -76 142.5 37.5; k_l -47 146 42.5;
k_fl -29.5 147.5 38; s_fl -31.5 166 37.5; k_hr -100 137 -28; s_hl -105.5 152 27;
s_hr -104 153 -29; tab_l -119.2 153 10; tab -121 155.8 -2; tab_r -120 154.5 -15;
k_br -74 146 -36; k_r -46 149 -36; k_fr -27.5 150 -32.5; s_fr -29.5 168 -30.5;
"""

#: Columns where they cross the collar's rim, seen from above: x, z.
RIM = """
r_back -113 -1; r_hl -95 26; r_bl -75 36; r_ml -63.5 37.5; r_l -50 37.5; r_fl -37 34.5;
r_hr -106.5 -21.2; r_br -75 -26.5; r_mr -62 -28.5; r_r -50 -29.5; r_fr -37 -27.5;
"""

#: The cavity's floor, a corner (i) and crevices, the flaps' upper ends, the tongue's rim: x, y, z.
CAVITY = """
f_back -99.2 138.9 -0.1; f_hl -90.4 144.5 12.6; f_1 -83 146.6 18.8; f_bl -76.4 147.8 22.6;
f_2 -67.5 149.7 25.8; f_l -56.7 153.4 25.4; f_3 -47.9 154.1 23.3; f_4 -43.2 149.4 20.7;
f_5 -39.3 145.8 19.9; f_6 -34.6 147.2 15.5; f_7 -27.2 150.1 10.5; f_8 -21.8 150.2 6.6;
f_front -19.2 149.7 2.8; f_85 -21.2 150.8 0.2; v_f1 -19.1 162.8 4; v_f2 -17.8 156 1.6;
v_f3 -17 151.5 1.2; i_hr -103.5 161.5 -17; i_hr1 -100.3 151 -17.6; f_9 -24 150.7 -5;
f_10 -32.6 151.8 -9; f_11 -38 151.8 -11; f_12 -45.3 153.9 -14.5; f_r -47.7 160.4 -20.6;
f_13 -61.9 163.2 -19.8; f_br -75.3 155.7 -18.2; f_14 -83.9 148.9 -18.5; f_hr -95.5 143 -18;
c_back -79 147.5 2; c_front -50 153.5 2; v_l -51 181.5 31.2; v_l1 -52.5 176.5 30;
v_l2 -54 170 28; v_l3 -56.2 164 27.6; v_r -50.5 184 -23; v_r1 -50.5 177.5 -22.2;
v_r2 -47.5 170 -22.5; v_r3 -47.2 165 -20.5; tip_l -29.5 184.2 30.5; tip_r -27.5 186.5 -22.5;
rim_l -42 194.5 19; rim_l1 -54.5 185.5 27.5; rim_l2 -50 190 23.5; rim_l3 -35 197.7 14.5;
rim -28.5 201.7 1; rim_r -42 196 -13.5; rim_r1 -53.5 186.5 -20.5; rim_r2 -50 191 -17.5;
rim_r3 -33 198.8 -9;
"""

#: Tongue and flaps, in the throat's frame.
FLAPS = """
c27 27 3 2; c48 48 2.6 2; c66 66 3 2; in60 60 -6.6 2.5; in50 50 -5.6 1.5;
l3 3 -1.6 17; l7 6.8 -2.6 16.6; l12 12.5 1.3 14.6; l18 18.3 -0.1 13.4; l22 22 -0.7 13.5;
l27 27 -0.8 14; l31 31 -0.3 12.6; l34 34.6 0.8 10.8; l37 37 0.5 10.8; l40 40 -0.8 13.9;
l44 44 -1.1 13.7; l48 48 -2 16; l51 51 -4.7 20.2; l54 54 -9 25.3; l58 58 -11.5 27;
l66 66 -12.6 28; l69 69 -13.3 27.5; l72 72 -15.8 28.5;
r12 11.7 1.2 -8.3; r6 5.5 -2.6 -7.3; r16 15.9 0.3 -7.7; r18 18 0.6 -7.7; r20 20 0.4 -7.7;
r27 27 0.8 -8; r30 30 0.7 -8.6; r34 34 0.9 -8.3; r36 36 0.9 -7.4; r38 38 0.4 -7;
r41 41 0.7 -8.6; r48 48 0.8 -8.5; r54 54 0.2 -8.7; r60 60 -1.5 -11; r61 61.5 -6.8 -17.3;
r63 63 -7.8 -17.6; r66 66 -8.8 -18.3; r69 69 -10 -18.2; r72 72 -12.5 -20.3; r75 75 -16.3 -21.8;
el4 4 6 18; el9 9.3 4.5 18; el40 40.3 3.8 12; el43 43 4 13.1; el47 47.5 5 14.8;
el54 54 1.9 17.2; el60 60 -1 22.7; el66 66 -4.5 26.6;
er6 6 5.5 -11.8; er10 10.2 4.2 -12.8; er12 12.5 6.6 -11.5; er15 14.8 3.5 -10.7;
er18 18.4 3.6 -10.7; er20 19.8 2.6 -9.6; er21 21.3 3.1 -10.3; er24 24 2.8 -11.5;
er27 27 3.1 -11.8; er30 30 3.4 -10.6; er33 32.7 3.9 -10.3; er35 35 2.6 -8.7; er37 36.5 4 -9.8;
er38 38.2 4.2 -11.2; er39 39.6 4.8 -12.2; er40 40.6 3.6 -9.7; er42 41.6 4.9 -10.7;
er45 45 5.2 -11; er48 48 5.5 -10.5; er54 54 4.4 -9.7; er60 60 3.3 -12.5; er64 63.5 1.5 -15.8;
kl5 5.5 0.5 28; kl14 14 1 24.5; kl22 22.5 3 24.5; kl24 23.1 -0.2 31.4; kl27 26.5 5 26;
kl27n 27 0.9 21.8; kl32 32 2.2 24; kl47 47.5 7.2 26.5; kl45 45.1 1.4 30.8; kl54 54 -2.5 27.5;
kl60 60 -5.5 30.5;
kr6 6 -0.5 -22.5; kr10 10.5 2 -20; kr17 17 -3 -22; kr24 23.8 0.4 -18.8; kr27 26.5 6.2 -17.5;
kr25 25.5 -4 -23.8; kr29 29.5 5 -17.8; kr30 31.3 -0.2 -17.6; kr36 36 -0.8 -18.2;
kr46 46.5 2 -19.5; kr49 48.5 10 -17.5; kr48 47.5 -2 -23.8; kr54 54 1 -22.5; kr60 60 -2 -25;
kr67 67 -8 -29;
"""

#: The row of laces through eyelets, in the throat's frame. The crossing lies on the tongue, p left
#: and x right of it; from there the upper lace bridges to the right hook. n: along that lace.
EYELETS = """
w 4.8 2.5 7.5; turn 1.6 7.7 -5.7; w1 3 6 0.3; a1 13.7 2.2 8; a2 13.5 3.2 1; a3 12.7 3.5 -5;
a4 9 1.5 -16.5; a5 21 1 20.6; a6 19 3.3 16; a7 17.8 2.3 9.5; p 16.9 5 6.8; x 16.5 3.6 -6;
px 17 2.8 1; px0 17 1.9 -4.5; top 16.6 8.2 1; up1 18 6 3; up2 20 5.8 -4.6; dn1 17.5 4.3 -7.2;
a8 12 2.5 -15.5; a9 20 2 -13.5; a10 22 0 -16; n1 9.5 5.2 20.5; n2 12 7.4 13.5; n3 14 8.2 9;
n4 15.5 8.3 5; n5 18 7.8 -2; n6 20 6.6 -8; n7 22 4.8 -13.8;
"""

#: The row of laces between the hooks, in the throat's frame. The crossing stands on the tongue by a
#: foot, d to u, with a tunnel on either side, and the upper lace bridges to the right once more. q
#: and y: where it parts from the lower one, left and right; e: in front, above the foot; z: within.
HOOKS = """
d 34 2.9 -1.2; e 34.2 4.8 -0.9; u 36.9 2.6 1; dl 35.3 2.9 4.2; dr 35.3 2.4 -3.5; b1 33.2 7 5;
b2 32 6.5 10; b3 30.6 3.8 17.5; b4 32.3 1.8 14.3; b5 28.8 3.6 19.7; q 36.9 7 3;
q0 37.8 5.2 1.2; q1 38.4 5 5; q2 39.2 5 9; y 36.4 6 -6.2; z 37 4.5 -4.2; z1 37 5.2 -6.95;
z2 37 4.8 -5.7; y1 36.6 5.4 -8; b01 34.1 6.3 1.3; b02 34.4 5.7 0.2; b6 33.7 4.8 -4; b7 33 5 -7;
b8 36.7 3.9 -2; b81 37.3 6.3 0.3; b9 37.2 10 -1.5; b91 37 8.3 4.1; b92 36.2 8 -4.2;
b10 35.2 6.6 -3; b11 39 7.8 -1.8; b111 38 8.4 1.5; b12 40.5 7 -6; b13 38.2 6.9 -9.5;
b130 37.2 6.9 -7; b14 33 1 -15.5; b15 43 3.2 -15; b16 35.5 6.6 14.5; b17 43 1.7 19.6;
b18 45 1.3 20.9; o1 31.2 7.1 16; o2 32.5 8.9 9; o3 34.5 9.9 4; o4 39 9.4 -6; o5 41 8.5 -11;
o6 44 7.7 -15.5; o7 34 6.7 -7.5; o8 32 5.3 -14; m1 36.6 4.2 9; m2 36.7 3.9 3.5;
"""

#: Numbers of edges of pieces of curves, between two places next to each other.
EDGES = {
    1: """
f_r f_13; r_l v_l; r_r v_r; r66 tip_r; er15 er18; er18 er20; er39 er40; r48 er48; kl22 kl27;
r16 er15; d e; kl27 kl27n; y1 er37; z z2; l34 l37; l37 l40; u b8; b8 z; b10 y; kr27 kr29;
""",
    2: """
tip_l r_fl; r_fl r_l; r_r r_fr; r_fr tip_r; k_hl s_hl; k_hr s_hr; s_hr r_hr; r_l r_ml;
r_ml r_bl; f_bl f_2; r_br r_mr; r_mr r_r; f_13 f_br; f_2 f_l; kr24 kr27; s_fl r_fl; k_fr s_fr;
tip_l l66; c48 r48; el47 l48; r27 er27; er24 er27; er27 er30; er33 er35; er37 er38; er48 kr49;
el9 l12; r12 er10; x r16; kr6 kr10; dn1 er18; c27 d; p top; dr u; b5 kl27n; el40 l40; b13 er39;
b92 b9; b02 b10; kr29 kr30;
""",
    3: """
r_bl r_hl; r_back r_hr; s_hl r_hl; f_back f_hl; f_hl f_1; f_14 f_hr; f_hr f_back;
f_back c_back; f_bl c_back; c_back f_br; f_l c_front; s_fr r_fr; c48 c66; l48 c48; l22 l27;
l72 v_l; r20 r27; kl47 el47; el43 el47; er12 er15; er27 kr27; er42 er45; l7 l12; a2 a3;
kl5 kl14; l18 a7; er15 a8; a9 a10; c27 r27; top x; n2 n3; d dl; l27 l31; b4 l34; l44 l48;
b7 er33; er37 b14; b81 z; b15 kr46; b9 b91;
""",
    4: """
r_hr r_br; r_hl r_back; r_hl f_hl; r_br f_br; r_mr f_13; c_back c_front; c_front f_front;
c_front f_r; v_r1 v_r2; kr46 kr49; u c48; c66 rim; c66 r66; r75 v_r; kl5 el9; a4 kr6; r12 r16;
p px; l27 c27; p c27; kl27n l27; q1 q2; kl27 o1;
""",
    5: """
k_l r_l; k_bl r_bl; k_br r_br; k_r r_r; r_back f_back; i_hr i_hr1; v_l3 f_l; kr25 k_fr;
l66 c66; l58 l66; r60 r61; el54 el60; er64 tip_r; a1 a2; a5 a6; up1 up2; m2 b8; b12 er42;
b16 el40; o7 o8;
""",
    6: """
r_bl f_bl; r_ml f_2; f_9 f_10; kl60 r_fl; s_fl kl45; kl5 n1; b2 b3; el40 b17; kr36 kr46; o1 o2;
""",
    7: """
f_6 f_7; k_fl kl24; kr49 kr54; r41 r48; kr10 kr17; o6 kr49;
""",
    8: """
rim_l3 rim; rim_r3 rim; kr48 s_fr; w l7; n5 n6;
""",
    9: """
kl32 kl47;
""",
    10: """
rim in60;
""",
}


def top(s: Sketch) -> None:
    """Its curves and their counts."""
    for table in (SEAM, CAVITY):
        s.near(**{name: [1e-3 * c for c in at] for name, at in _places(table)})
    s.seen("+y", **{name: [1e-3 * c for c in at] for name, at in _places(RIM)})
    s.near(**{name: _in_throat(*at) for name, at in _places(FLAPS + EYELETS + HOOKS)})
    s.spacing, s.fine = 0.01, 0.003
    _ankle(s)
    s.spacing, s.fine = 0.003, 0.0015
    _cavity(s)
    s.spacing, s.fine, s.rounds = 0.002, 0.001, 0
    _flaps(s)
    s.spacing, s.fine = 0.0015, 0.0008
    _eyelets(s)
    _hooks(s)
    s.rounds = ROUNDS
    for count, pieces in EDGES.items():
        for piece in _split(pieces):
            s.edges(" ".join(map(_name, piece.split())), count)


def _split(text: str) -> Iterator[str]:
    """The parts of a text between semicolons."""
    return filter(None, map(str.strip, text.replace("\n", " ").split(";")))


def _name(name: str) -> str:
    """The full name of a place: those on ring h have it already."""
    return name if name.startswith("h_") else f"t_{name}"


def _places(table: str) -> Iterator[tuple[str, list[float]]]:
    """Names and numbers of a table of places."""
    for row in _split(table):
        name, *at = row.split()
        yield _name(name), [float(c) for c in at]


def _in_throat(along: float, off: float, left: float) -> list[float]:
    """A place told in the throat's frame (mm), in space (m)."""
    x, y, _ = UP
    at = np.array(FOOT) + 1e-3 * np.array([along * x + off * y, along * y - off * x, left])
    return at.tolist()


def _lines(s: Sketch, curves: str) -> None:
    """Draw curves, each told by its places."""
    for curve in _split(curves):
        s.line(*map(_name, curve.split()))


def _ankle(s: Sketch) -> None:
    """The seam, the rim, columns up to them from the ring, and a curve over the tab at the heel."""
    _lines(
        s,
        """
        k_fl k_l k_bl k_hl k_back k_hr k_br k_r k_fr;
        tip_l r_fl r_l r_ml r_bl r_hl r_back r_hr r_br r_mr r_r r_fr tip_r; h_l k_l r_l;
        h_bl k_bl r_bl; h_br k_br r_br; h_r k_r r_r; h_fl k_fl s_fl r_fl; h_hl k_hl s_hl r_hl;
        h_hr k_hr s_hr r_hr; h_fr k_fr s_fr r_fr; h_back k_back tab r_back;
        s_hl tab_l tab tab_r s_hr;
        """,
    )


def _cavity(s: Sketch) -> None:
    """The cavity's floor and walls, the tongue's inner side and its rim."""
    s.once("sizes", edge=NARROW)
    _lines(
        s,
        """
        f_back f_hl f_1 f_bl f_2 f_l f_3 f_4 f_5 f_6 f_7 f_8 f_front;
        f_front f_85 f_9 f_10 f_11 f_12 f_r f_13 f_br f_14 f_hr f_back;
        rim in60 in50 v_f1 v_f2 v_f3 f_front;
        """,
    )
    s.once("sizes", edge=EDGE)
    _lines(
        s,
        """
        r_back f_back; r_hl f_hl; r_bl f_bl; r_br f_br; r_hr i_hr i_hr1 f_hr; r_ml f_2;
        r_mr f_13; f_back c_back c_front f_front; f_bl c_back f_br; f_l c_front f_r;
        v_l rim_l1 rim_l2 rim_l rim_l3 rim; v_r rim_r1 rim_r2 rim_r rim_r3 rim;
        """,
    )


def _flaps(s: Sketch) -> None:
    """Curves up the tongue and the flaps, and across them at the hooks and the flaps' ends."""
    _lines(
        s,
        """
        r_l v_l; v_l v_l1 v_l2 v_l3 f_l; r_r v_r; v_r v_r1 v_r2 v_r3 f_r;
        h_flap_l kl5 kl14 kl22 kl27; kl27 kl32 kl47 kl54 kl60 r_fl;
        h_flap_r kr6 kr10 kr17 kr24 kr27; kr27 kr29 kr30 kr36 kr46;
        kr46 kr49 kr54 kr60 kr67 r_fr; k_fl kl24 kl27; kl27 kl27n l27 c27 r27 er27 kr27;
        kr27 kr25 k_fr; kl47 el47 l48 c48 r48 er48 kr49; s_fl kl45 kl47; kr49 kr48 s_fr;
        tip_l l66 c66 r66 tip_r; u c48 c66 rim; h_foot_l l3 l7 l12;
        l18 l22 l27 l31 l34 l37 l40 l44 l48; l48 l51 l54 l58 l66 l69 l72 v_l; h_foot_r r6 r12;
        r16 r18 r20 r27 r30 r34 r36 r38 r41 r48; r48 r54 r60 r61 r63 r66 r69 r72 r75 v_r;
        h_edge_l el4 el9; el40 el43 el47 el54 el60 el66 tip_l; h_edge_r er6 er10; er10 er12 er15;
        er15 er18; er18 er20 er21; er21 er24 er27 er30 er33; er33 er35 er37; er37 er38 er39;
        er39 er40 er42; er42 er45 er48 er54 er60 er64 tip_r;
        """,
    )


def _eyelets(s: Sketch) -> None:
    """The row of laces through eyelets, and its tunnel."""
    _lines(
        s,
        """
        turn w1 w l7; kl5 el9 l12; l12 a1 a2 a3 r12; r12 er10; er10 a4 kr6; h_under a2; l12 l18;
        r12 r16; kl22 a5 a6 l18; l18 a7 p; x r16; r16 er15; er15 a8 kr10; p px px0 x; p top x;
        p up1 up2 er21; x dn1 er18; er18 a9 a10 kr24; p c27 d; kl5 n1 n2 n3 n4 top;
        top n5 n6 n7 kr27;
        """,
    )


def _hooks(s: Sketch) -> None:
    """The row of laces between the hooks, and its three tunnels."""
    _lines(
        s,
        """
        d dl u; d dr u; d e; e b01 b1 b2 b3; b3 b5 kl27n; b3 b4 l34; q q0 q1 q2 el40; el40 l40;
        b3 b16 el40; el40 b17 b18 kl47; e b6 b7 er33; y y1 er37; er37 b14 kr30; q b81 z; u b8 z;
        z z2 z1 y; l37 m1 m2 b8; y b92 b9 b91 q; e b02 b10 y; q b111 b11 b12 er42;
        y b130 b13 er39; er39 b15 kr46; kl27 o1 o2 o3 b9; b9 o4 o5 o6 kr49; b10 o7 o8 kr29;
        """,
    )
