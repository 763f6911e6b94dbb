"""Sessions of retopology as files: what is written is read again, and nothing else is."""

from __future__ import annotations

import json
from base64 import b64decode, b64encode
from collections.abc import Callable
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb_sketch.retopo.editor import Retopology, State
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.filling import Filling
from patterndb_sketch.retopo.network import Network, set_choice
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession, is_disk_within
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
    RETOPO_SESSION.write(path, session)
    again = RETOPO_SESSION.read(path)
    assert_same(session, again)
    assert RETOPO_SESSION.encode(again) == path.read_bytes()
    kinds = {type(patch.choice) for patch in again.state.network.patches.values()}
    assert kinds == {Filling, type(None)}
    chain = next(iter(again.state.network.chains.values()))
    assert not chain.points.flags.writeable


def test_an_empty_network_and_an_endless_loop_limit_are_read() -> None:
    session = RetopoSession(plane(), State(Network(), SIZES))
    assert_same(session, RETOPO_SESSION.decode(RETOPO_SESSION.encode(session)))


def test_curved_surfaces_are_read_bit_for_bit(source: PatternSource) -> None:
    editor = drawn_octants(source)
    editor.fill()
    session = RetopoSession(editor.surface, editor.state)
    assert_same(session, RETOPO_SESSION.decode(RETOPO_SESSION.encode(session)))


def test_a_session_goes_on_as_if_never_closed(
    session: RetopoSession, source: PatternSource
) -> None:
    """The same calls and fills on what was read and on what was written."""
    editors: list[Retopology] = []
    for one in (session, RETOPO_SESSION.decode(RETOPO_SESSION.encode(session))):
        editor = Retopology(one.surface, source)
        editor.restore(one.state)
        do(editor, "stroke", points=line((0.5, -1), (0.5, 1)))
        do(editor, "erase", at=[1, 1.5, 0])
        editor.fill()
        editors.append(editor)
    assert editors[0].state.same(editors[1].state)


def test_numbers_of_any_size_are_read_bit_for_bit(session: RetopoSession) -> None:
    sizes = type(session.state.sizes)(5e-324, 0.1 + 0.2, 1e300, 1 / 3, 2.0**-40, np.pi)
    again = RETOPO_SESSION.decode(
        RETOPO_SESSION.encode(RetopoSession(plane(), State(Network(longest=1e-300), sizes)))
    )
    assert again.state.sizes == sizes
    assert again.state.network.longest == 1e-300


def test_the_plane_of_symmetry_is_read_bit_for_bit(session: RetopoSession) -> None:
    for plane_of in (Plane(), Plane.of([0.1 + 0.2, 0, 0], [1, 2, 1 / 3]), Plane((-0.0, 0, 0))):
        state = State(session.state.network, session.state.sizes, plane_of)
        again = RETOPO_SESSION.decode(RETOPO_SESSION.encode(RetopoSession(session.surface, state)))
        assert again.state.same(state)
        assert repr(again.state.plane) == repr(Plane(*map(floats, astuple(plane_of))))


def floats(row: tuple[float, float, float]) -> tuple[float, float, float]:
    return (float(row[0]), float(row[1]), float(row[2]))


def test_a_choice_of_another_kind_is_an_error(session: RetopoSession) -> None:
    network = session.state.network
    patch = next(iter(network.patches))
    state = State(set_choice(network, patch, "blue"), session.state.sizes)
    with pytest.raises(
        InvalidRetopoError, match=f"patch {patch} has a choice that is not a Filling"
    ):
        RETOPO_SESSION.encode(RetopoSession(session.surface, state))


def with_document(data: bytes, change: Callable[[Any], object]) -> bytes:
    """A session with its JSON changed in place."""
    document = json.loads(data)
    change(document)
    return json.dumps(document).encode()


def with_array(of: Any, name: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """Replace an array of an entry by what is made of it."""
    old = of[name]
    if isinstance(old, dict):
        array = np.frombuffer(b64decode(old["base64"]), old["dtype"]).reshape(old["shape"])
    else:
        array = np.array(old, "<i4" if name == "triangles" else "<f8")
    new = change(array)
    packed = b64encode(new.tobytes()).decode()
    of[name] = {"dtype": new.dtype.str, "shape": list(new.shape), "base64": packed}


def with_bytes(of: Any, name: str | int, change: Callable[[bytes], bytes]) -> None:
    """Replace the bytes of an entry by what is made of them."""
    of[name] = b64encode(change(b64decode(of[name]))).decode()


def network(document: Any) -> Any:
    return document["content"]["network"]


def node(document: Any, valence: int) -> Any:
    return next(one for one in network(document)["nodes"] if len(one["ends"]) == valence)


def fillings(document: Any) -> list[Any]:
    return [one["filling"] for one in network(document)["patches"] if one["filling"]]


def filled(document: Any) -> Any:
    return next(
        one for one in network(document)["patches"] if one["filling"] and one["filling"]["choice"]
    )


def choice(document: Any) -> Any:
    return filled(document)["filling"]["choice"]


def moved(document: Any) -> Any:
    return next(one["moved"] for one in fillings(document) if one["moved"][0])


def flow(document: Any) -> Any:
    return next(one["flows"][0] for one in fillings(document) if one["flows"])


def with_plane(**entries: object) -> Callable[[Any], object]:
    return lambda d: d["content"].update(plane=entries)


CHANGES: list[tuple[str, Callable[[Any], object], str]] = [
    ("kind", lambda d: d.update(kind="zip"), "this is 'zip' version 1; 'retopology' version 1"),
    ("version", lambda d: d.update(version=2), "this is 'retopology' version 2"),
    ("no version", lambda d: d.pop("version"), '"version" is missing'),
    ("no sizes", lambda d: d["content"].pop("sizes"), 'content: "sizes" is missing'),
    ("more", lambda d: d["content"].update(x=1, name=3), "content.x: there is no such entry"),
    ("size", lambda d: d["content"]["sizes"].update(snap=0), "sizes: the size snap is 0.0; give"),
    ("size missing", lambda d: d["content"]["sizes"].pop("edge"), 'sizes: "edge" is missing'),
    ("no plane", lambda d: d["content"].pop("plane"), '"plane" is missing'),
    ("point", with_plane(point=[0], normal=[1, 0, 0]), "content.plane.point: "),
    ("long", with_plane(point=[0] * 3, normal=[2, 0, 0]), "is not of length"),
    ("far", with_plane(point=[99, 0, 0], normal=[1, 0, 0]), "content.plane: "),
    ("name", lambda d: d["content"].update(name=3), "name: 3 is not the name of a mesh file"),
    ("id twice", lambda d: network(d)["nodes"][0].update(id=network(d)["nodes"][1]["id"]), "twice"),
    ("next id", lambda d: network(d).update(next_id=1), "content.network: "),
    ("huge id", lambda d: network(d).update(next_id=2**40), "network.next_id: it must be 0 to"),
    ("longest", lambda d: network(d).update(longest="1"), 'network.longest: "1" is not a number'),
    ("ends", lambda d: node(d, 4)["ends"].pop(), "not once among the ends"),
    ("ends order", lambda d: node(d, 4)["ends"].reverse(), "network: patch"),
    ("no ends", lambda d: node(d, 1)["ends"].clear(), "network: "),
    ("far end", lambda d: node(d, 4)["ends"].__setitem__(0, 10**6), "content.network: "),
    ("flags", lambda d: node(d, 4)["corner_flags"].pop(), "not a flag for each wedge"),
    ("flag", lambda d: node(d, 4)["corner_flags"].__setitem__(0, 1), "1 is not true or false"),
    ("start", lambda d: network(d)["chains"][0].update(start=999), "content.network: chain"),
    ("one end", lambda d: network(d)["chains"][-1].update(start=-1), "network: chain"),
    ("count", lambda d: network(d)["chains"][0].update(count=-1), "its count is below 0"),
    ("huge", lambda d: network(d)["chains"][0].update(count=2**40), "chains[0].count: it must be"),
    ("pinned", lambda d: network(d)["chains"][0].update(pinned=True, count=0), "pinned without"),
    ("marks", lambda d: network(d)["chains"][0].update(marks=["x", ""]), "unknown marks"),
    ("mark", lambda d: network(d)["chains"][0].update(marks=[""]), "chains[0].marks: "),
    ("fewer", lambda d: network(d)["chains"].pop(), "network"),
    ("loop", lambda d: filled(d)["loop"].reverse(), "its loop is not a face"),
    ("empty", lambda d: filled(d)["loop"].clear(), "a patch needs half-chains, of chains"),
    ("corners", lambda d: filled(d)["corners"].reverse(), "corners are ascending places"),
    ("corner", lambda d: filled(d)["corners"].append(99), "corners are ascending places"),
    ("lengths", lambda d: choice(d)["lengths"].append(2), "the patch has 4 sides"),
    ("long", lambda d: choice(d)["lengths"].__setitem__(0, 9), "the quads do not fill"),
    ("vertices", lambda d: choice(d).update(n_vertices=10**6), "the quads do not fill"),
    ("widths", lambda d: choice(d).update(widths=[-1]), "the numbers of a fill are 0 to"),
    ("code", lambda d: with_bytes(choice(d), "code", lambda b: b"\xff" * len(b)), "choice.code: "),
    ("half code", lambda d: with_bytes(choice(d), "code", lambda b: b[:-1]), "end within a number"),
    ("quads", lambda d: choice(d).update(quads="AAA"), "content.network.patches"),
    ("turned", lambda d: with_bytes(choice(d), "quads", lambda b: b[::-1]), "the quads do not fil"),
    ("by", lambda d: choice(d).update(by="me"), '"me" is not "program" or "user"'),
    ("moved", lambda d: with_bytes(moved(d), 0, lambda b: b"\xff" * len(b)), "moved vertices are"),
    ("place", lambda d: with_bytes(moved(d), 1, lambda b: b[24:]), "vertex needs a place"),
    ("nowhere", lambda d: with_bytes(moved(d), 1, lambda b: b"\xff" * len(b)), "must be finite"),
    ("flow", lambda d: with_bytes(flow(d), "line", lambda b: b[:24]), "needs two points or more"),
    ("half flow", lambda d: with_bytes(flow(d), "line", lambda b: b[:25]), "end within a number"),
]


@pytest.mark.parametrize(
    ("change", "message"), [row[1:] for row in CHANGES], ids=[row[0] for row in CHANGES]
)
def test_changed_documents_are_refused(
    session: RetopoSession, change: Callable[[Any], object], message: str
) -> None:
    with pytest.raises(InvalidRetopoError) as caught:
        RETOPO_SESSION.decode(with_document(RETOPO_SESSION.encode(session), change))
    assert message in str(caught.value)


def surface(document: Any) -> Any:
    return document["content"]


def chain(document: Any) -> Any:
    return network(document)["chains"][0]


@pytest.mark.parametrize(
    ("of", "name", "change", "message"),
    [
        (surface, "vertices", lambda a: a * np.nan, "not all of its numbers are finite"),
        (surface, "vertices", lambda a: a.astype("<f4"), "is of type <f4; it must be <f8"),
        (surface, "vertices", lambda a: a[:, :2].copy(), "content.vertices: "),
        (surface, "vertices", lambda a: a[:3], "names a vertex outside 0..2"),
        (surface, "vertices", lambda a: a[[0, 1, 2, 3, 0]], "vertices in one place"),
        (surface, "triangles", lambda a: a[:0], "no triangle with an area"),
        (surface, "triangles", lambda a: np.r_[a, [[0, 0, 1]]].astype("<i4"), "without an area"),
        (chain, "normals", lambda a: a * 1.001, "a normal has not length 1"),
        (chain, "points", lambda a: np.full_like(a, np.inf), "points: not all of its numbers"),
        (chain, "points", lambda a: a[1:], "content.network: chain"),
        (lambda d: node(d, 4), "point", lambda a: a + 1.0, "does not end exactly at node"),
        (lambda d: node(d, 4), "point", lambda a: a[None], "must have 3 numbers"),
    ],
)
def test_changed_arrays_are_refused(
    session: RetopoSession,
    of: Callable[[Any], Any],
    name: str,
    change: Callable[[np.ndarray], np.ndarray],
    message: str,
) -> None:
    data = RETOPO_SESSION.encode(session)
    with pytest.raises(InvalidRetopoError) as caught:
        RETOPO_SESSION.decode(with_document(data, lambda d: with_array(of(d), name, change)))
    assert message in str(caught.value)


def test_files_of_another_kind_are_refused(session: RetopoSession, tmp_path: Path) -> None:
    data = RETOPO_SESSION.encode(session)
    for content, message in (
        (b"", "this is empty; it should hold a session of retopology"),
        (b"v 0 0 0\n", "this is not JSON"),
        (b"[1]", "this is not a session of retopology"),
        (b'{"nodes": []}', "this is not a session of retopology"),
        (data[:-100], "this is not JSON"),
    ):
        path = tmp_path / "a.retopo"
        path.write_bytes(content)
        with pytest.raises(InvalidRetopoError) as caught:
            RETOPO_SESSION.read(path)
        assert str(caught.value).startswith(f"{path}: ")
        assert message in str(caught.value)


@settings(max_examples=150)
@given(st.data())
def test_damaged_files_are_refused_or_read_as_something_sound(
    session: RetopoSession, data: st.DataObject
) -> None:
    """Bytes changed anywhere."""
    content = bytearray(RETOPO_SESSION.encode(session))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(32, 126))
    try:
        again = RETOPO_SESSION.decode(bytes(content))
    except InvalidRetopoError:
        return
    assert RETOPO_SESSION.decode(RETOPO_SESSION.encode(again)).state.same(again.state)


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
    assert is_disk_within(np.asarray(quads), n_vertices, perimeter) == sound
