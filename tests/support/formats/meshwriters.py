"""Random polygon meshes, and writers for every way a file may spell them."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from patterndb.core.polygonmesh import PolygonMesh

# No test asserts a time, nor does hypothesis for it.
patient = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

finite = st.floats(allow_nan=False, allow_infinity=False)


@dataclass(frozen=True)
class Soup:
    """Points and faces as plain lists."""

    points: list[tuple[float, float, float]]
    faces: list[list[int]]


@st.composite
def soups(draw: st.DrawFn, coordinates: st.SearchStrategy[float] = finite) -> Soup:
    """Faces of 3 to 9 corners over up to 30 points; unused points and repeated corners occur."""
    points = draw(
        st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=30)
    )
    index = st.integers(0, len(points) - 1)
    face = st.lists(index, min_size=3, max_size=9)
    return Soup(points, draw(st.lists(face, min_size=1, max_size=20)))


def assert_is(mesh: PolygonMesh, soup: Soup, points: object = None) -> None:
    """The mesh is the soup to the last bit, or has the given points in its stead."""
    expected = np.array(soup.points if points is None else points, np.float64)
    assert mesh.points.dtype == np.float64
    assert mesh.points.tobytes() == expected.tobytes()
    assert mesh.corners.dtype == np.int32
    assert mesh.offsets.dtype == np.int64
    faces = [part.tolist() for part in np.split(mesh.corners, mesh.offsets[1:-1])]
    assert faces == soup.faces


def same(a: PolygonMesh, b: PolygonMesh) -> bool:
    return all(
        getattr(a, name).tobytes() == getattr(b, name).tobytes()
        for name in ("points", "corners", "offsets")
    )


@dataclass(frozen=True)
class ObjStyle:
    """One way to write an OBJ file."""

    corner: str = "{0}"
    relative: bool = False
    newline: str = "\n"
    bom: bool = False
    last_newline: bool = True
    blank: str = " "
    extra_numbers: int = 0
    continued: bool = False
    tail: str = ""
    between: str = ""
    faces_first: bool = False


obj_styles = st.builds(
    ObjStyle,
    corner=st.sampled_from(["{0}", "{0}/{0}", "{0}//{0}", "{0}/{0}/{0}", "{0}/", "{0}/7/-1"]),
    relative=st.booleans(),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    bom=st.booleans(),
    last_newline=st.booleans(),
    blank=st.sampled_from([" ", "\t", "   ", " \t "]),
    extra_numbers=st.sampled_from([0, 1, 3, 4]),
    continued=st.booleans(),
    tail=st.sampled_from(["", " ", "\t", " # said by hand \\", "#"]),
    between=st.sampled_from(
        [
            "",
            "\n",
            "# 1 2 \\\n",
            "g a b\ns off\n",
            "usemtl C:\\x\\\n",
            "vt 0 1\nvn 0 0 1\n",
            "p 1\n",
        ]
    ),
    faces_first=st.booleans(),
)


def obj_bytes(soup: Soup, style: ObjStyle = ObjStyle()) -> bytes:
    """The soup as an OBJ file."""
    blank, n = style.blank, len(soup.points)
    relative = style.relative and not style.faces_first
    vertices: list[str] = []
    for point in soup.points:
        words = ["v", *map(repr, point), *["0.5"] * style.extra_numbers]
        vertices.append(blank.join(words) + style.tail + "\n" + style.between)
    faces: list[str] = []
    for face in soup.faces:
        corners = [style.corner.format(i - n if relative else i + 1) for i in face]
        joint = f"{blank}\\\n{blank}" if style.continued else blank
        faces.append("f" + blank + joint.join(corners) + style.tail + "\n" + style.between)
    lines = [*faces, *vertices] if style.faces_first else [*vertices, *faces]
    text = "".join(lines)
    if not style.last_newline:
        text = text.rstrip("\n")
    text = text.replace("\n", style.newline)
    return (b"\xef\xbb\xbf" if style.bom else b"") + text.encode()


@dataclass(frozen=True)
class PlyStyle:
    """One way to write a PLY file."""

    order: str = ""
    newline: str = "\n"
    number: str = "double"
    count: str = "uchar"
    index: str = "int"
    name: str = "vertex_indices"
    axes: str = "xyz"
    vertex_extra: str | None = None
    face_before: str | None = None
    face_after: str | None = None
    other: bool = False
    faces_first: bool = False
    blank_lines: bool = False


_COUNTS = ["char", "uchar", "int8", "uint8", "short", "ushort", "int16", "uint16", "int", "uint32"]
_EXTRAS = [None, "uchar", "float", "list uchar float", "list int short"]

ply_styles = st.builds(
    PlyStyle,
    order=st.sampled_from(["", "<", ">"]),
    newline=st.sampled_from(["\n", "\r\n", "\r"]),
    number=st.sampled_from(["double", "float64"]),
    count=st.sampled_from(_COUNTS),
    index=st.sampled_from(_COUNTS),
    name=st.sampled_from(["vertex_indices", "vertex_index"]),
    axes=st.sampled_from(["xyz", "zyx", "yxz"]),
    vertex_extra=st.sampled_from(_EXTRAS),
    face_before=st.sampled_from(_EXTRAS),
    face_after=st.sampled_from(_EXTRAS),
    other=st.booleans(),
    faces_first=st.booleans(),
    blank_lines=st.booleans(),
)

_CODES = {
    **dict.fromkeys(["char", "int8"], "b"),
    **dict.fromkeys(["uchar", "uint8"], "B"),
    **dict.fromkeys(["short", "int16"], "h"),
    **dict.fromkeys(["ushort", "uint16"], "H"),
    **dict.fromkeys(["int", "int32"], "i"),
    **dict.fromkeys(["uint", "uint32"], "I"),
    **dict.fromkeys(["float", "float32"], "f"),
    **dict.fromkeys(["double", "float64"], "d"),
}
_ORDER_NAMES = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}


def ply_bytes(soup: Soup, style: PlyStyle = PlyStyle()) -> bytes:
    """The soup as a PLY file; extra lists have 0 to 2 values, in turn."""
    vertex = [(style.number, axis) for axis in style.axes]
    vertex += [(style.vertex_extra, "extra")] if style.vertex_extra else []
    vertex_rows = []
    for i, point in enumerate(soup.points):
        row = [point["xyz".index(axis)] for axis in style.axes]
        vertex_rows.append([*row, *_extra(style.vertex_extra, i)])
    face = [(style.face_before, "before")] if style.face_before else []
    face += [(f"list {style.count} {style.index}", style.name)]
    face += [(style.face_after, "after")] if style.face_after else []
    face_rows = [
        [*_extra(style.face_before, i), corners, *_extra(style.face_after, i + 1)]
        for i, corners in enumerate(soup.faces)
    ]
    elements = [("vertex", vertex, vertex_rows), ("face", face, face_rows)]
    if style.faces_first:
        elements.reverse()
    if style.other:
        elements.insert(
            1, ("edge", [("int", "a"), ("list ushort double", "b")], [[1, [0.5]], [2, []]])
        )
        elements.append(("empty", [], []))
    lines = [
        "ply",
        f"format {_ORDER_NAMES[style.order]} 1.0",
        "comment \u00e9t\u00e9",
        "obj_info x y",
    ]
    body: list[bytes] = []
    for name, properties, rows in elements:
        lines.append(f"element {name} {len(rows)}")
        lines += [f"property {type_} {property_}" for type_, property_ in properties]
        types = [type_.split() for type_, _ in properties]
        for row in rows:
            body.append(_ply_row(row, types, style))
    header = style.newline.join([*lines, "end_header", ""]).encode()
    return header + b"".join(body)


def _extra(type_: str | None, i: int) -> list[object]:
    if type_ is None:
        return []
    return [[i % 7] * (i % 3)] if type_.startswith("list") else [i % 7]


def _ply_row(row: list[object], types: list[list[str]], style: PlyStyle) -> bytes:
    if not style.order:
        words: list[object] = []
        for value in row:
            words += [len(value), *value] if isinstance(value, list) else [value]
        text = " ".join(map(repr, words)) + style.newline
        return ((style.newline if style.blank_lines else "") + text).encode()
    packed = b""
    for value, type_ in zip(row, types, strict=True):
        if isinstance(value, list):
            count, item = _CODES[type_[1]], _CODES[type_[2]]
            packed += struct.pack(f"{style.order}{count}", len(value))
            packed += struct.pack(f"{style.order}{len(value)}{item}", *value)
        else:
            packed += struct.pack(style.order + _CODES[type_[0]], value)
    return packed


@st.composite
def mutations(draw: st.DrawFn, data: bytes, tokens: list[bytes]) -> bytes:
    """The bytes with up to three slices replaced by tokens, other slices, or nothing."""
    for _ in range(draw(st.integers(1, 3))):
        begin = draw(st.integers(0, len(data)))
        end = begin + draw(st.sampled_from([0, 1, 1, 2, 5, 20]))
        other = draw(st.integers(0, len(data)))
        junk = draw(
            st.one_of(
                st.sampled_from(tokens),
                st.sampled_from(tokens).map(lambda token: b" " + token + b" "),
                st.just(data[other : other + 9]),
                st.binary(max_size=2),
            )
        )
        data = data[:begin] + junk + data[end:]
    return data
