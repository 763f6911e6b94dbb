"""The boot between its two rings: the third row of its laces, over both flaps and the tongue.

One lace climbs from its eyelet on the left flap over the flap's edge to the crossing, the other one
from there over the right flap's edge into its eyelet. Below them are three tunnels: from the eyelet
to the left edge, from there to the crossing, and from the crossing to the right edge.

Names end with t on the laces' side of the toes, and with b on the other one; around a lace, with o
out on it and u under it.
"""

from __future__ import annotations

import numpy as np
from sketching import ROUNDS, Sketch

#: Rings around the left lace over the tunnels: a point inside, the way along the lace, the ways to
#: its flank on the side of the toes and out.
RINGS = {
    "c_1": ((0.0190, 0.1205, 0.0231), (-0.28, 0.39, -0.876), (0.644, -0.60, -0.475)),
    "c_2": ((0.0161, 0.1246, 0.0102), (-0.28, 0.39, -0.876), (0.644, -0.60, -0.475)),
}
OUT = (0.711, 0.698, 0.083)

#: Around the left eyelet: the feet of the lace's end on the lower ring and what lies beside it on
#: the upper one, the flap's valley on the lower ring, the flanks of the lace's end, the floor of
#: the tunnel, and where the lace lies on the flap.
EYELET = {
    "c_end_t": (0.0184, 0.1124, 0.0263),
    "c_end_b": (0.0149, 0.1109, 0.0277),
    "c_beside": (0.0005, 0.1185, 0.0325),
    "c_valley": (0.0192, 0.1133, 0.0226),
    "c_post_t": (0.0187, 0.1152, 0.0247),
    "c_post_b": (0.0161, 0.1165, 0.0264),
    "c_floor_t": (0.0186, 0.1161, 0.0212),
    "c_floor_b": (0.0136, 0.1180, 0.0236),
    "c_lies_t": (0.0191, 0.1205, 0.0197),
    "c_lies_b": (0.0173, 0.1214, 0.0206),
}

#: Where the flaps' edges pass below the laces: before, below and beyond.
EDGES = {
    "c_left_t": (0.0189, 0.1216, 0.0160),
    "c_left": (0.0163, 0.1222, 0.0150),
    "c_left_b": (0.0168, 0.1255, 0.0157),
    "c_right_t": (0.0154, 0.1250, -0.0084),
    "c_right": (0.0129, 0.1251, -0.0075),
    "c_right_b": (0.0125, 0.1274, -0.0088),
}

#: The crossing: the end of the left lace and its foot on the tongue, where the laces touch, how far
#: that goes in the third tunnel, what the crossing stands on in the second tunnel (back) and in the
#: third (base), and the corner of this with the right edge's foot.
CROSSING = {
    "c_tip": (0.0125, 0.1248, 0.0005),
    "c_foot": (0.0115, 0.1226, 0.0),
    "c_cross_t": (0.0116, 0.1259, -0.0010),
    "c_cross": (0.0114, 0.1273, 0.0022),
    "c_cross_b": (0.0103, 0.1270, 0.0041),
    "c_touch": (0.0106, 0.1261, -0.0030),
    "c_mouth": (0.0088, 0.1273, -0.0028),
    "c_side": (0.0105, 0.1187, 0.0168),
    "c_back_t": (0.0137, 0.1216, 0.0042),
    "c_back_1": (0.0119, 0.1216, 0.0069),
    "c_back_2": (0.0077, 0.1211, 0.0031),
    "c_back_b": (0.0057, 0.1215, 0.0059),
    "c_base_1": (0.0090, 0.1220, -0.0035),
    "c_base_2": (0.0062, 0.1213, -0.0057),
    "c_base_3": (0.0047, 0.1232, -0.0077),
    "c_corner": (0.0041, 0.1246, -0.0110),
}

#: Around the right lace over the third tunnel, from where the upper ring turns at it: over it, its
#: lower flank, under it.
AROUND = {
    "c_turn": (0.0127, 0.1294, -0.0057),
    "c_over": (0.0149, 0.1294, -0.0059),
    "c_3t": (0.0147, 0.1266, -0.0055),
    "c_under_t": (0.0130, 0.1261, -0.0060),
    "c_under_b": (0.0116, 0.1272, -0.0067),
}

#: The right lace's flanks on the flap, and where they leave the band.
RIGHT_END = {
    "c_lies_1t": (0.0185, 0.1231, -0.0140),
    "c_lies_2t": (0.0183, 0.1208, -0.0166),
    "c_lies_1b": (0.0151, 0.1268, -0.0136),
    "c_lies_2b": (0.0161, 0.1226, -0.0187),
    "c_out_t": (0.0194, 0.1197, -0.0188),
    "c_out_b": (0.0157, 0.1185, -0.0212),
}

#: Edges of pieces of lines, by their numbers: around the laces, along them, and along what they
#: bridge.
COUNTS = {
    1: "c_1t c_lies_t, c_1b c_lies_b, c_tip c_cross_t, c_foot c_tip, c_right_b h_edge_r",
    2: (
        "c_end_t c_post_t, c_post_t c_1t, c_end_b c_post_b, c_post_b c_1b, c_3t c_right_t, "
        "c_turn c_right_b, c_post_t c_floor_t, c_post_b c_floor_b, c_floor_t c_lies_t, "
        "c_floor_b c_lies_b, c_valley c_floor_t, c_corner h_foot_r, c_foot c_back_t"
    ),
    3: (
        "m_edge_l c_left_t, m_tongue c_foot, c_1t c_1o, c_1b c_1u, c_2t c_2o, c_2b c_2u, "
        "c_cross_t c_cross, c_turn c_over, c_turn c_under_b, c_left_t c_left, "
        "c_right_t c_right, c_lies_t c_left_t, c_lies_b c_left_b, c_left_t c_2t, c_left_b c_2b, "
        "c_2t c_tip, c_cross_t c_3t, c_floor_t c_floor_b, c_floor_b h_flap_l, c_end_b c_beside, "
        "m_fl h_fl, c_left_b h_edge_l, c_cross_t c_touch, m_flap_r h_flap_r"
    ),
    4: ("m_edge_r c_right_t, c_2b c_cross_b, c_side h_foot_l, c_side c_back_1, c_back_2 c_back_b"),
    5: "m_foot_l c_side, c_lies_1t c_lies_2t, c_lies_1b c_lies_2b",
    6: "c_base_1 c_base_2, m_foot_r c_corner",
}

#: Edges of pieces of the lower and the upper ring, by places on them.
RING_COUNTS = {
    (0.0043, 0.1055, 0.0361): 4,
    (0.0167, 0.1115, 0.0279): 3,
    (0.0244, 0.1156, 0.02): 4,
    (0.0196, 0.1143, 0.0164): 3,
    (0.017, 0.1144, 0.0091): 4,
    (0.0186, 0.1172, -0.0052): 3,
    (0.0188, 0.1181, -0.0111): 3,
    (0.0195, 0.119, -0.0149): 5,
    (0.0186, 0.1196, -0.021): 3,
    (-0.0049, 0.1157, 0.0362): 4,
    (0.0019, 0.1193, 0.0312): 4,
    (0.01, 0.1238, 0.0236): 5,
    (0.0091, 0.1244, 0.017): 3,
    (0.0033, 0.1229, 0.011): 4,
    (0.0087, 0.1258, 0.0065): 3,
    (0.0127, 0.1285, -0.0001): 3,
    (0.0066, 0.1276, -0.0111): 3,
    (0.0053, 0.1281, -0.018): 5,
}

#: Places within patches, and nodes around them that are no corners there.
INSIDE = {
    "c_in_post": (0.0178, 0.1170, 0.0243),
    "c_in_lies": (0.0172, 0.1190, 0.0214),
    "c_in_top": (0.0200, 0.1236, 0.0181),
    "c_in_left": (0.0155, 0.1190, 0.0160),
    "c_in_left_b": (0.0145, 0.1242, 0.0157),
    "c_in_right_b": (0.0117, 0.1268, -0.0085),
    "c_in_right": (0.0135, 0.1222, -0.0100),
    "c_in_out": (0.0177, 0.1268, -0.0139),
    "c_in_flank": (0.0085, 0.1245, -0.0050),
    "c_in_back": (0.0095, 0.1240, 0.0070),
    "c_in_floor": (0.0145, 0.1195, 0.0050),
}
STRAIGHT = {
    "c_in_post": "c_post_t c_post_b",
    "c_in_lies": "c_lies_t c_lies_b",
    "c_in_top": "c_left_t c_left_b",
    "c_in_left": "c_left_t",
    "c_in_left_b": "c_left_b",
    "c_in_right": "c_right_t c_corner",
    "c_in_right_b": "c_right_b",
    "c_in_out": "c_right_t",
    "c_in_flank": "c_tip c_mouth",
    "c_in_back": "c_cross_b",
    "c_in_floor": "c_foot",
}


def mid(s: Sketch) -> None:
    """Its curves."""
    s.spacing, s.fine = 0.008, 0.004
    _sides(s)
    s.spacing, s.fine = 0.002, 0.001
    s.near(**EYELET, **EDGES, **CROSSING, **AROUND, **RIGHT_END)
    for name, (at, along, way) in RINGS.items():
        ways = {"t": way, "o": OUT, "b": _opposite(way), "u": _opposite(OUT)}
        s.ring(at, along, {f"{name}{side}": one for side, one in ways.items()}, inside=True)
    s.rounds = 0
    _laces(s)
    _flaps(s)
    _tongue(s)
    s.rounds = ROUNDS
    s.caps(INSIDE, STRAIGHT)
    for count, pieces in COUNTS.items():
        for between in pieces.split(", "):
            s.edges(between, count)
    for at, count in RING_COUNTS.items():
        s.once("subdivide", at=np.array(at), count=count)


def _sides(s: Sketch) -> None:
    """What stands between the rings, around heel and ankle."""
    for name in ("back", "hl", "bl", "l", "fl", "flap_r", "fr", "r", "br", "hr"):
        s.line(f"m_{name}", f"h_{name}")


def _laces(s: Sketch) -> None:
    """Both flanks of both laces."""
    s.line("c_end_t", "c_post_t", "c_1t", "c_lies_t", "c_left_t")
    s.line("c_left_t", "c_2t", "c_tip", "c_cross_t", "c_3t", "c_right_t")
    s.line("c_right_t", "c_lies_1t", "c_lies_2t", "c_out_t")
    s.line("c_end_b", "c_post_b", "c_1b", "c_lies_b", "c_left_b")
    s.line("c_left_b", "c_2b", "c_cross_b")
    s.line("c_turn", "c_right_b", "c_lies_1b", "c_lies_2b", "c_out_b")
    s.line("c_turn", "c_over", "c_3t")
    s.line("c_turn", "c_under_b", "c_under_t", "c_3t")
    s.line("c_cross_t", "c_cross", "c_cross_b")


def _flaps(s: Sketch) -> None:
    """The floor of the first tunnel with its mouths, and both edges with their feet."""
    s.line("c_valley", "c_floor_t", "c_floor_b", "h_flap_l")
    s.line("c_end_b", "c_beside")
    s.line("c_post_t", "c_floor_t", "c_lies_t")
    s.line("c_post_b", "c_floor_b", "c_lies_b")
    for side, end in (("left", "l"), ("right", "r")):
        s.line(f"m_edge_{end}", f"c_{side}_t")
        s.line(f"c_{side}_t", f"c_{side}", f"c_{side}_b")
        s.line(f"c_{side}_b", f"h_edge_{end}")
    s.line("m_foot_l", "c_side", "h_foot_l")
    s.line("m_foot_r", "c_corner")
    s.line("c_corner", "h_foot_r")


def _tongue(s: Sketch) -> None:
    """The tongue up to the crossing, and what the crossing stands on."""
    s.line("m_tongue", "c_foot", "c_tip")
    s.line("c_foot", "c_back_t", "c_back_1", "c_back_2", "c_back_b", "h_tongue")
    s.line("c_side", "c_back_1")
    s.line("c_foot", "c_base_1", "c_base_2", "c_base_3", "c_corner")
    s.line("c_cross_t", "c_touch", "c_mouth")


def _opposite(way: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(-x for x in way)
