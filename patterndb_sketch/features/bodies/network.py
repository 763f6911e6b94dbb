"""The network of named curves, the same for every body, and the boxes that it makes.

Every component is a box, open where it joins others: the roof below, the wheelhouses to the side
and to the ground; a half is open in the middle plane too, as the roof and the body are.
A box's edge is an interval of one curve, or of several that follow each other, between two
corners; a corner is where curves meet, and so known once the curves are.
"""

from __future__ import annotations

from dataclasses import dataclass

from patterndb_sketch.features.bodies.curves import Component


@dataclass(frozen=True, slots=True)
class Corner:
    """A point of the network: curves that meet there, the first of which ends there."""

    name: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BoxEdge:
    """From the corner start to the corner end, along the curves in this order and direction."""

    start: str
    end: str
    curves: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BoxFace:
    """Four corners, counter-clockwise seen from outside of the body (from within the well, for
    a wheelhouse). An edge joins every two that follow each other."""

    name: str
    corners: tuple[str, str, str, str]


@dataclass(frozen=True, slots=True)
class Box:
    """The template of a component: at most six faces, at most twelve edges, eight corners.

    open: the names of the faces that it lacks. The middle plane's is open on roof and body.
    """

    component: Component
    edges: tuple[BoxEdge, ...]
    faces: tuple[BoxFace, ...]
    open: tuple[str, ...]


def _roof() -> tuple[list[Corner], Box]:
    corners = [
        Corner("windscreen_base_centre", ("windscreen_base", "windscreen_profile")),
        Corner("roof_front_centre", ("roof_front", "windscreen_profile", "roof_profile")),
        Corner("roof_rear_centre", ("roof_rear", "rear_window_profile", "roof_profile")),
        Corner("rear_window_base_centre", ("rear_window_base", "rear_window_profile")),
        Corner("a_pillar_base", ("a_pillar", "windscreen_base", "belt_line")),
        Corner("a_pillar_top", ("a_pillar", "roof_front", "roof_rail")),
        Corner("c_pillar_top", ("c_pillar", "roof_rear", "roof_rail")),
        Corner("c_pillar_base", ("c_pillar", "rear_window_base", "belt_line")),
    ]
    edges = (
        BoxEdge("windscreen_base_centre", "a_pillar_base", ("windscreen_base",)),
        BoxEdge("roof_front_centre", "a_pillar_top", ("roof_front",)),
        BoxEdge("roof_rear_centre", "c_pillar_top", ("roof_rear",)),
        BoxEdge("rear_window_base_centre", "c_pillar_base", ("rear_window_base",)),
        BoxEdge("a_pillar_base", "a_pillar_top", ("a_pillar",)),
        BoxEdge("a_pillar_top", "c_pillar_top", ("roof_rail",)),
        BoxEdge("c_pillar_base", "c_pillar_top", ("c_pillar",)),
        BoxEdge("a_pillar_base", "c_pillar_base", ("belt_line",)),
        BoxEdge("windscreen_base_centre", "roof_front_centre", ("windscreen_profile",)),
        BoxEdge("roof_front_centre", "roof_rear_centre", ("roof_profile",)),
        BoxEdge("rear_window_base_centre", "roof_rear_centre", ("rear_window_profile",)),
    )
    faces = (
        BoxFace("front", (
            "windscreen_base_centre", "a_pillar_base", "a_pillar_top", "roof_front_centre")),
        BoxFace("top", ("roof_front_centre", "a_pillar_top", "c_pillar_top", "roof_rear_centre")),
        BoxFace("rear", (
            "c_pillar_base", "rear_window_base_centre", "roof_rear_centre", "c_pillar_top")),
        BoxFace("side", ("a_pillar_base", "c_pillar_base", "c_pillar_top", "a_pillar_top")),
    )  # fmt: skip
    return corners, Box("roof", edges, faces, ("bottom", "middle"))


def _body() -> tuple[list[Corner], Box]:
    corners = [
        Corner("nose_bottom_centre", ("front_bottom", "front_profile", "bottom_profile")),
        Corner("nose_top_centre", ("hood_edge", "front_profile", "hood_profile")),
        Corner("tail_top_centre", ("deck_edge", "rear_profile", "deck_profile")),
        Corner("tail_bottom_centre", ("rear_bottom", "rear_profile", "bottom_profile")),
        Corner("nose_bottom_side", ("front_corner", "front_bottom", "sill_front")),
        Corner("nose_top_side", ("front_corner", "hood_edge", "shoulder")),
        Corner("tail_top_side", ("rear_corner", "deck_edge", "shoulder")),
        Corner("tail_bottom_side", ("rear_corner", "rear_bottom", "sill_rear")),
    ]
    sill = ("sill_front", "front_opening", "sill_middle", "rear_opening", "sill_rear")
    edges = (
        BoxEdge("nose_bottom_centre", "nose_bottom_side", ("front_bottom",)),
        BoxEdge("nose_top_centre", "nose_top_side", ("hood_edge",)),
        BoxEdge("tail_top_centre", "tail_top_side", ("deck_edge",)),
        BoxEdge("tail_bottom_centre", "tail_bottom_side", ("rear_bottom",)),
        BoxEdge("nose_bottom_side", "nose_top_side", ("front_corner",)),
        BoxEdge("nose_top_side", "tail_top_side", ("shoulder",)),
        BoxEdge("tail_bottom_side", "tail_top_side", ("rear_corner",)),
        BoxEdge("nose_bottom_side", "tail_bottom_side", sill),
        BoxEdge("nose_bottom_centre", "nose_top_centre", ("front_profile",)),
        BoxEdge(
            "nose_top_centre", "tail_top_centre", ("hood_profile", "cabin_profile", "deck_profile")
        ),
        BoxEdge("tail_bottom_centre", "tail_top_centre", ("rear_profile",)),
        BoxEdge("nose_bottom_centre", "tail_bottom_centre", ("bottom_profile",)),
    )
    faces = (
        BoxFace("front", (
            "nose_bottom_centre", "nose_bottom_side", "nose_top_side", "nose_top_centre")),
        BoxFace("top", ("nose_top_centre", "nose_top_side", "tail_top_side", "tail_top_centre")),
        BoxFace("rear", (
            "tail_bottom_side", "tail_bottom_centre", "tail_top_centre", "tail_top_side")),
        BoxFace("side", ("nose_bottom_side", "tail_bottom_side", "tail_top_side", "nose_top_side")),
        BoxFace("bottom", (
            "nose_bottom_side", "nose_bottom_centre", "tail_bottom_centre", "tail_bottom_side")),
    )  # fmt: skip
    return corners, Box("body", edges, faces, ("middle",))


def _wheelhouse(name: str, component: Component) -> tuple[list[Corner], Box]:
    def the(curve: str) -> str:
        return f"{name}_{curve}"

    arch, inner = the("arch"), the("inner_arch")
    front, rear = the("tub_front"), the("tub_rear")
    bends = the("bend_front"), the("bend_rear")
    sills = ("sill_front", "sill_middle") if name == "front" else ("sill_middle", "sill_rear")
    corners = [
        Corner(the("arch_front_foot"), (front, arch, sills[0])),
        Corner(the("arch_front_bend"), (bends[0], arch)),
        Corner(the("arch_rear_bend"), (bends[1], arch)),
        Corner(the("arch_rear_foot"), (rear, arch, sills[1])),
        Corner(the("inner_front_foot"), (front, inner, the("inner_sill"))),
        Corner(the("inner_front_bend"), (bends[0], inner)),
        Corner(the("inner_rear_bend"), (bends[1], inner)),
        Corner(the("inner_rear_foot"), (rear, inner, the("inner_sill"))),
    ]
    outer, deep = [c.name for c in corners[:4]], [c.name for c in corners[4:]]
    across = (front, *bends, rear)
    edges = [BoxEdge(outer[i], outer[i + 1], (arch,)) for i in range(3)]
    edges += [BoxEdge(deep[i], deep[i + 1], (inner,)) for i in range(3)]
    edges += [BoxEdge(outer[i], deep[i], (across[i],)) for i in range(4)]
    edges += [BoxEdge(deep[0], deep[3], (the("inner_sill"),))]
    faces = [
        BoxFace(where, (outer[i], deep[i], deep[i + 1], outer[i + 1]))
        for i, where in enumerate(("front", "top", "rear"))
    ]
    faces.append(BoxFace("inner", (deep[0], deep[3], deep[2], deep[1])))
    return corners, Box(component, tuple(edges), tuple(faces), ("bottom", "outer"))


_PARTS = (
    _roof(),
    _body(),
    _wheelhouse("front", "front_wheelhouse"),
    _wheelhouse("rear", "rear_wheelhouse"),
)

#: All corners, by component.
CORNERS: tuple[Corner, ...] = tuple(corner for corners, _ in _PARTS for corner in corners)

#: The four boxes.
BOXES: tuple[Box, ...] = tuple(box for _, box in _PARTS)
