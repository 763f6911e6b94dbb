"""Sessions of retopology as files: what is written is read again, and nothing else is."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.editor import Editor, State
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import Filling
from patterndb_sketch.retopo.network import Network, set_choice
from patterndb_sketch.retopo.sessionfile import (
    MAX_BYTES,
    RetopoSession,
    disk_within,
    parse_session,
    read_session,
    session_bytes,
    surface_bytes,
    write_session,
)
from patterndb_sketch.retopo.symmetry import Plane
from query.engine import PatternSource
from tests.support.retopo.editors import (
    do,
    drawn_grid,
    drawn_octants,
    line,
    patch_around,
    same_arrays,
)
from tests.support.retopo.networks import SIZES, plane


@pytest.fixture(scope="module")
def session(source: PatternSource) -> RetopoSession:
    """A drawing with all that there can be: T-junctions, open ends, loops, pins, fills that the
    user took, flow lines, moved vertices, a border; and ids that are gone."""
    editor = drawn_grid(source)
    do(editor, "stroke", points=line((0, 0.5), (1, 0.5)))
    do(editor, "stroke", points=line((-3, -3), (-2, -3.2), (-1, -3)))
    circle = np.linspace(0, 2 * np.pi, 30)[:-1]
    do(editor, "stroke", points=np.c_[np.cos(circle) - 3, np.sin(circle), 0 * circle].tolist())
    do(editor, "erase", at=[3, 1.5, 0])
    do(editor, "subdivide", at=[0.5, 3, 0], count=6)
    editor.fill()
    do(editor, "flow", points=line((1.1, 1.5), (1.9, 1.5)))
    editor.fill()
    do(editor, "choose", at=[1.5, 0.5, 0], by=1)
    editor.fill()
    moved = patch_around(editor.network, 0.5, 2.5)
    filling = editor.network.patches[moved].choice
    assert isinstance(filling, Filling)
    assert filling.choice is not None
    inner = filling.choice.perimeter
    filling = filling.with_moved([inner, inner + 1], [[0.4, 2.4, 0], [0.1 + 0.2, 2.5, -0.0]])
    network = set_choice(editor.network, moved, filling)
    # A patch whose fill was taken back, and one that never had any.
    network = set_choice(network, patch_around(network, 1.5, 2.5), Filling())
    network = set_choice(network, patch_around(network, 0.5, 0.25), None)
    return RetopoSession(editor.surface, State(network, editor.sizes), "a b.obj")


def assert_same(one: RetopoSession, two: RetopoSession) -> None:
    """All that there is, bit for bit, and in the same order."""
    assert one.name == two.name
    assert one.state.same(two.state)
    a, b = one.state.network, two.state.network
    for things in ("nodes", "chains", "patches"):
        assert list(getattr(a, things)) == list(getattr(b, things))
    for name in ("vertices", "triangles", "normals"):
        assert same_arrays(getattr(one.surface, name), getattr(two.surface, name))
    assert one.surface.diagonal == two.surface.diagonal


def test_what_is_written_is_read(session: RetopoSession, tmp_path: Path) -> None:
    path = tmp_path / "a.retopo"
    write_session(path, session)
    again = read_session(path)
    assert_same(session, again)
    assert session_bytes(again) == path.read_bytes()
    assert session_bytes(session, surface_bytes(session.surface)) == path.read_bytes()
    kinds = {type(patch.choice) for patch in again.state.network.patches.values()}
    assert kinds == {Filling, type(None)}
    chain = next(iter(again.state.network.chains.values()))
    assert not chain.points.flags.writeable


def test_an_empty_network_and_an_endless_loop_limit_are_read() -> None:
    session = RetopoSession(plane(), State(Network(), SIZES))
    assert_same(session, parse_session(session_bytes(session)))


def test_curved_surfaces_are_read_bit_for_bit(source: PatternSource) -> None:
    editor = drawn_octants(source)
    editor.fill()
    session = RetopoSession(editor.surface, editor.state)
    assert_same(session, parse_session(session_bytes(session)))


def test_a_session_goes_on_as_if_never_closed(
    session: RetopoSession, source: PatternSource
) -> None:
    """The same calls and fills on what was read and on what was written."""
    editors: list[Editor] = []
    for one in (session, parse_session(session_bytes(session))):
        editor = Editor(one.surface, source)
        editor.restore(one.state)
        do(editor, "stroke", points=line((0.5, -1), (0.5, 1)))
        do(editor, "erase", at=[1, 1.5, 0])
        editor.fill()
        editors.append(editor)
    assert editors[0].state.same(editors[1].state)


def test_numbers_of_any_size_are_read_bit_for_bit(session: RetopoSession) -> None:
    sizes = type(session.state.sizes)(5e-324, 0.1 + 0.2, 1e300, 1 / 3, 2.0**-40, np.pi)
    again = parse_session(
        session_bytes(RetopoSession(plane(), State(Network(longest=1e-300), sizes)))
    )
    assert again.state.sizes == sizes
    assert again.state.network.longest == 1e-300


def test_the_plane_of_symmetry_is_read_bit_for_bit(session: RetopoSession) -> None:
    for plane_of in (Plane(), Plane.of([0.1 + 0.2, 0, 0], [1, 2, 1 / 3]), Plane((-0.0, 0, 0))):
        state = State(session.state.network, session.state.sizes, plane_of)
        again = parse_session(session_bytes(RetopoSession(session.surface, state)))
        assert again.state.same(state)
        assert repr(again.state.plane) == repr(Plane(*map(floats, astuple(plane_of))))


def floats(row: tuple[float, float, float]) -> tuple[float, float, float]:
    return (float(row[0]), float(row[1]), float(row[2]))


def test_a_choice_of_another_kind_is_an_error(session: RetopoSession) -> None:
    network = session.state.network
    patch = next(iter(network.patches))
    state = State(set_choice(network, patch, "blue"), session.state.sizes)
    with pytest.raises(InvalidRetopoError, match=f"patch {patch} has a choice that is no Filling"):
        session_bytes(RetopoSession(session.surface, state))


def repacked(data: bytes, name: str, change: Callable[[bytes], bytes | None]) -> bytes:
    """A session's zip with an entry changed, or left out."""
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(file, "w") as new:
        for entry in old.infolist():
            content: bytes | None = old.read(entry)
            assert content is not None
            if entry.filename == name:
                content = change(content)
            if content is not None:
                new.writestr(entry.filename, content)
    return file.getvalue()


def with_document(data: bytes, change: Callable[[Any], object]) -> bytes:
    """A session's zip with its JSON changed in place."""

    def changed(content: bytes) -> bytes:
        document = json.loads(content)
        change(document)
        return json.dumps(document).encode()

    return repacked(data, "session.json", changed)


def with_array(data: bytes, entry: str, name: str, array: np.ndarray) -> bytes:
    """A session's zip with an array replaced."""

    def changed(content: bytes) -> bytes:
        plain = io.BytesIO()
        np.save(plain, array)
        return repacked(content, f"{name}.npy", lambda _: plain.getvalue())

    return repacked(data, entry, changed)


def array_of(data: bytes, entry: str, name: str) -> np.ndarray:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return np.load(io.BytesIO(archive.read(entry)))[name]


def node(document: Any, valence: int) -> Any:
    return next(one for one in document["network"]["nodes"] if len(one["ends"]) == valence)


def filled(document: Any) -> Any:
    return next(one for one in document["network"]["patches"] if one["fill"])


CHANGES: list[tuple[str, Callable[[Any], object], str]] = [
    ("format", lambda d: d.update(format="zip"), "the format is 'zip' 1; this reads"),
    ("version", lambda d: d.update(version=2), "session' 2; this reads"),
    ("no version", lambda d: d.pop("version"), "session' None; this reads"),
    ("no sizes", lambda d: d.pop("sizes"), '"sizes" is missing'),
    ("more", lambda d: d.update(colour=1), "colour: there is no such entry"),
    ("size", lambda d: d["sizes"].update(snap=0), "sizes: the size snap is 0.0; give a length"),
    ("size missing", lambda d: d["sizes"].pop("edge"), 'sizes: "edge" is missing'),
    ("no plane", lambda d: d.pop("plane"), '"plane" is missing'),
    ("plane", lambda d: d.update(plane={"point": [0, 0, 0]}), 'plane: "normal" is missing'),
    ("point", lambda d: d.update(plane={"point": [0], "normal": [1, 0, 0]}), "is not a point"),
    ("long", lambda d: d.update(plane={"point": [0] * 3, "normal": [2, 0, 0]}), "is not of length"),
    ("far", lambda d: d.update(plane={"point": [99, 0, 0], "normal": [1, 0, 0]}), "plane: "),
    ("name", lambda d: d.update(name=3), "name: 3 is not the name of a mesh file"),
    ("id twice", lambda d: d["network"]["nodes"][0].update(id=d["network"]["nodes"][1]["id"]), ""),
    ("next id", lambda d: d["network"].update(next_id=1), "network: "),
    ("longest", lambda d: d["network"].update(longest="1"), 'network.longest: "1" is not a number'),
    ("ends", lambda d: node(d, 4)["ends"].pop(), "not once among the ends"),
    ("ends order", lambda d: node(d, 4)["ends"].reverse(), "network: patch"),
    ("no ends", lambda d: node(d, 1)["ends"].clear(), "network: "),
    ("far end", lambda d: node(d, 4)["ends"].__setitem__(0, 10**6), "there is no half-chain 10000"),
    ("huge end", lambda d: node(d, 4)["ends"].__setitem__(0, 10**30), "is not a whole number from"),
    ("flags", lambda d: node(d, 4)["flagged"].pop(), "not a flag for each wedge"),
    ("flag", lambda d: node(d, 4)["flagged"].__setitem__(0, 1), "1 is not true or false"),
    ("start", lambda d: d["network"]["chains"][0].update(start=999), "there is no node 999"),
    ("one end", lambda d: d["network"]["chains"][-1].update(start=-1), "network: chain"),
    ("count", lambda d: d["network"]["chains"][0].update(count=-1), "-1 is not a whole number"),
    ("pinned", lambda d: d["network"]["chains"][0].update(pinned=True, count=0), "pinned without"),
    ("marks", lambda d: d["network"]["chains"][0].update(marks=["x", ""]), "unknown marks"),
    ("mark", lambda d: d["network"]["chains"][0].update(marks=[""]), "a chain has two marks"),
    ("samples", lambda d: d["network"]["chains"][0].update(samples=10**7), "too few chains"),
    ("fewer", lambda d: d["network"]["chains"].pop(), "network"),
    ("no patch", lambda d: d["network"]["patches"].pop(), "and names"),
    ("loop", lambda d: filled(d)["loop"].reverse(), "its loop is not a face"),
    ("empty", lambda d: filled(d)["loop"].clear(), "a patch has half-chains of chains"),
    ("corners", lambda d: filled(d)["corners"].reverse(), "corners are ascending places"),
    ("corner", lambda d: filled(d)["corners"].append(99), "corners are ascending places"),
    ("lengths", lambda d: filled(d)["fill"]["lengths"].append(2), "the patch has 4 sides"),
    ("long", lambda d: filled(d)["fill"]["lengths"].__setitem__(0, 9), "the quads do not fill"),
    ("vertices", lambda d: filled(d)["fill"].update(vertices=10**6), "the quads do not fill"),
    ("quads", lambda d: filled(d)["fill"].update(quads=0), "0 is not a whole number from 1"),
    ("code", lambda d: filled(d)["fill"].update(code=3), "network"),
    ("by", lambda d: filled(d)["fill"].update(by="me"), '"me" is not "program" or "user"'),
    ("no fill", lambda d: filled(d).update(filling=False), "it is false, and the patch has a fill"),
    ("flow", lambda d: filled(d).update(flows=[1]), "1 is not a whole number from 2"),
]


@pytest.mark.parametrize(
    ("change", "message"), [row[1:] for row in CHANGES], ids=[row[0] for row in CHANGES]
)
def test_changed_documents_are_refused(
    session: RetopoSession, change: Callable[[Any], object], message: str
) -> None:
    with pytest.raises(InvalidRetopoError) as caught:
        parse_session(with_document(session_bytes(session), change))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("entry", "name", "change", "message"),
    [
        ("surface.npz", "vertices", lambda a: a * np.nan, "the surface: vertex 0"),
        ("surface.npz", "vertices", lambda a: a.astype("<f4"), "must be <f8 in rows of 3, got <f4"),
        ("surface.npz", "vertices", lambda a: a[:, :2], "must be <f8 in rows of 3"),
        ("surface.npz", "vertices", lambda a: a[:3], "names a vertex outside 0..2"),
        ("surface.npz", "vertices", lambda a: a[[0, 1, 2, 3, 0]], "vertices in one place"),
        ("surface.npz", "triangles", lambda a: a[:0], "no triangle with an area"),
        ("surface.npz", "triangles", lambda a: np.r_[a, [[0, 0, 1]]].astype("<i4"), "no session"),
        ("network.npz", "chains", lambda a: a * 1.001, "a normal has not length 1"),
        (
            "network.npz",
            "chains",
            lambda a: np.full_like(a, np.inf),
            "there are chains that are not finite",
        ),
        ("network.npz", "chains", lambda a: np.r_[a, a[:1]], "and names"),
        ("network.npz", "nodes", lambda a: a + np.eye(6)[0], "does not end exactly at node"),
        ("network.npz", "quads", lambda a: a[:, ::-1], "the quads do not fill the patch"),
        ("network.npz", "quads", lambda a: a - 1, "the quads do not fill the patch"),
        ("network.npz", "codes", lambda a: a[::-1].copy(), "code"),
        ("network.npz", "moved", lambda a: a + 1000, "moved vertices are 0.."),
        ("network.npz", "places", lambda a: a[:1], "too few places"),
        ("network.npz", "lines", lambda a: a * np.nan, "there are lines that are not finite"),
        ("network.npz", "moved", lambda a: a.astype(object), "must be <i4 in rows of 1"),
    ],
)
def test_changed_arrays_are_refused(
    session: RetopoSession,
    entry: str,
    name: str,
    change: Callable[[np.ndarray], np.ndarray],
    message: str,
) -> None:
    data = session_bytes(session)
    with pytest.raises(InvalidRetopoError) as caught:
        parse_session(with_array(data, entry, name, change(array_of(data, entry, name))))
    text = str(caught.value)
    assert message in text or (name == "moved" and "are damaged" in text)


def test_files_of_another_kind_are_refused(session: RetopoSession, tmp_path: Path) -> None:
    data = session_bytes(session)
    foreign = io.BytesIO()
    with zipfile.ZipFile(foreign, "w") as archive:
        archive.writestr("readme.txt", "hello")
    for content, message in (
        (b"", "this is not a session of retopology, which is a zip file"),
        (b"v 0 0 0\n", "this is not a session of retopology, which is a zip file"),
        (foreign.getvalue(), "its zip has readme.txt; it must have session.json, surface.npz"),
        (repacked(data, "network.npz", lambda _: None), "its zip has session.json, surface.npz;"),
        (repacked(data, "network.npz", lambda _: b"hello"), "this is not an entry of a session"),
        (repacked(data, "network.npz", lambda _: foreign.getvalue()), "arrays are nodes, chains"),
        (repacked(data, "session.json", lambda _: b"[1"), "this is no JSON"),
        (repacked(data, "session.json", lambda _: b"[1]"), "a list is not an object"),
        (data[:-100], "this is no"),
    ):
        path = tmp_path / "a.retopo"
        path.write_bytes(content)
        with pytest.raises(InvalidRetopoError) as caught:
            read_session(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message in str(caught.value)


def test_a_zip_that_unpacks_to_too_much_is_refused(session: RetopoSession) -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("session.json", b"{}")
    data = bytearray(file.getvalue())
    at = data.rindex(b"PK\x01\x02") + 24
    data[at : at + 4] = (MAX_BYTES + 1).to_bytes(4, "little")
    with pytest.raises(InvalidRetopoError, match=r"has more than 1,000,000,000 bytes in its zip"):
        parse_session(bytes(data))


@settings(max_examples=150)
@given(st.data())
def test_damaged_files_are_refused_or_read_as_something_sound(
    session: RetopoSession, data: st.DataObject
) -> None:
    """Bytes changed anywhere, in the zip or within its entries."""
    content = session_bytes(session)
    entry = data.draw(st.sampled_from([None, "session.json", "surface.npz", "network.npz"]))

    def damaged(old: bytes) -> bytes:
        new = bytearray(old)
        for _ in range(data.draw(st.integers(1, 4))):
            new[data.draw(st.integers(0, len(new) - 1))] = data.draw(st.integers(0, 255))
        return bytes(new)

    content = damaged(content) if entry is None else repacked(content, entry, damaged)
    try:
        again = parse_session(content)
    except InvalidRetopoError:
        return
    assert parse_session(session_bytes(again)).state.same(again.state)


GRID = np.array([[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]])


@pytest.mark.parametrize(
    ("quads", "n_vertices", "perimeter", "sound"),
    [
        (GRID, 9, 8, True),
        ([[0, 1, 2, 3]], 4, 4, True),
        (GRID[:, ::-1], 9, 8, False),
        (GRID, 10, 8, False),
        (GRID[:3], 9, 8, False),
        (np.r_[GRID, GRID[:1]], 9, 8, False),
        (GRID, 9, 6, False),
        ((GRID + 1) % 8 + (GRID == 8), 9, 8, False),
        # A disk, and a sphere of its own beside it.
        ([[0, 1, 2, 3], [4, 5, 6, 7], [7, 6, 5, 4]], 8, 4, False),
        ([[0, 1, 2, 0]], 4, 4, False),
    ],
)
def test_only_disks_within_their_boundary_are_fills(
    quads: np.ndarray, n_vertices: int, perimeter: int, sound: bool
) -> None:
    assert disk_within(np.asarray(quads), n_vertices, perimeter) == sound
