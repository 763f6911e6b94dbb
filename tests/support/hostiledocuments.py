"""Damage documents, and see whether their readers read or refuse them.

Each document is a small valid one with a damage or more: values of other types, huge and tiny
numbers, deep nesting, entries that are missing, unknown or there twice, other lengths, bytes that
are flipped, cut off or repeated; in archives also members that are missing or damaged one by one.
It must be read, or refused with an error of ours.
"""

from __future__ import annotations

import copy
import io
import json
import random
import tempfile
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from patterndb.errors import PatternDBError
from tests.support.shared import EXAMPLES

#: Seconds of the processor.
SLOW_SECONDS = 1.0

#: What has grown longer than this by damage is damaged no more.
MOST_DAMAGED = 2_000_000

#: What may stand anywhere in JSON, and hardly ever should.
HOSTILE: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 7, 2**31, 2**53, 2**63, 2**64, -(2**63), 10**30, 10**400,
    0.5, -0.0, 1e-308, 5e-324, 1e308, -1e308, 1e20, "", "x", "0", "\u0000", "\ud800", "../../x",
    "é" * 1000, "x" * 100_000, [], [[]], [0], [None], [[0, 0, 0]] * 2, [[1e308] * 3] * 3,
    list(range(3000)), {}, {"": 0}, {"x": {"y": []}},
)  # fmt: skip

#: A piece of text put where JSON expects something else.
TOKENS = (
    b"NaN", b"Infinity", b"-Infinity", b"1e999", b"[" * 300, b"[" * 100_000, b"{", b"}", b'"', b",",
    b":", b"\\u0000", b"\xff\xfe", b"\x00", b"00", b"+1", b"//", b"\xef\xbb\xbf",
)  # fmt: skip


def seed_boundaries() -> list[bytes]:
    sides = [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 1, 0]], [[1, 1, 0], [0, 1, 0]],
             [[0, 1, 0], [0, 0, 0]]]  # fmt: skip
    full = {
        "sides": sides,
        "corners": ["convex", "c", "reflex", "r"],
        "lengths": [3, 5, 4, 6],
        "strokes": [
            [[0.5, 0, 0], [0.5, 1, 0]],
            {"points": [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8]], "loop": True},
        ],
    }
    return [
        dump(full),
        dump({"sides": sides, "edge_length": 0.2}),
        dump({"sides": sides, "vertices": True}),
    ]


def seed_batch_lines() -> list[bytes]:
    counted = {"sides": [3, 5, 4, 6], "corners": ["c", "c", "r", "c"]}
    return [b"3,5,4,6", dump({**counted, "strokes": [[[0, 1], [2, 2]]], "loops": 2})]


def seed_networks() -> list[bytes]:
    curves = [[[0, 0, 0], [1, 0, 0.1], [2, 0, 0]], [[2, 0, 0], [2, 2, 0]], [[2, 2, 0], [0, 0, 0]]]
    example = (EXAMPLES / "networks" / "teacup.json").read_bytes()
    drawn = [{"points": points} for points in curves]
    return [dump({"curves": drawn}), dump({"curves": drawn, "tolerance": 0.01}), example]


def seed_feature_strokes() -> list[bytes]:
    stroke = {"name": "roof", "points": [[1.3, -0.6, 1.1], [2.4, -0.6, 1.0]]}
    example = (EXAMPLES / "features" / "audi_chrono.strokes.json").read_bytes()
    return [dump({"strokes": [stroke]}), example]


def seed_feature_networks() -> list[bytes]:
    return [(EXAMPLES / "features" / "q_car_cop.network.json").read_bytes()]


def seed_feature_sessions() -> list[bytes]:
    from patterndb_sketch.features.session import FEATURE_SESSION
    from tests.support.features.sessions import make_session

    return [FEATURE_SESSION.encode(make_session())]


def seed_shapes() -> list[bytes]:
    from patterndb_sketch.features.files.shapearrays import shape_bytes
    from tests.support.features.sessions import make_shape_model

    return [shape_bytes(make_shape_model())]


def seed_retopo_sessions() -> list[bytes]:
    import patterndb
    from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession
    from tests.support.retopo.editors import drawn_grid
    from tests.support.retopo.networks import plane

    with patterndb.open() as source:
        editor = drawn_grid(source)
        editor.fill()
        return [RETOPO_SESSION.encode(RetopoSession(plane(), editor.state, "sheet.obj"))]


def seed_scripts() -> list[bytes]:
    calls = [
        {"tool": "open", "surface": "spot.obj", "quads": True},
        {"tool": "loop", "at": [0, 0.1, 0.3], "normal": [0, 0, 1], "limit": 1.5},
        {"tool": "stroke", "points": [[0, 0.1, 0.3], [0.1, 0.2, 0.3]]},
        {"tool": "undo"},
        {"tool": "export", "mesh": "quads.obj"},
    ]
    return [b"\n".join(map(dump, calls)) + b"\n# that was all\n"]


def dump(document: object) -> bytes:
    return json.dumps(document).encode()


# Readers, of bytes.


def read_boundary(data: bytes) -> object:
    from query.boundaryfile import parse_boundary

    return parse_boundary(data)


def read_batch_line(data: bytes) -> object:
    from query.batchline import parse_line

    return [parse_line(line) for line in data.decode("utf-8", "replace").split("\n")]


def read_network(data: bytes) -> object:
    from patterndb_sketch.surfacing.networkfile import parse_drawing

    return parse_drawing(data)


def read_feature_session(data: bytes) -> object:
    from patterndb_sketch.features.session import FEATURE_SESSION

    return FEATURE_SESSION.decode(data)


def read_shapes(data: bytes) -> object:
    from patterndb_sketch.features.files.shapearrays import shape_of

    return shape_of(data)


def read_retopo_session(data: bytes) -> object:
    from patterndb_sketch.retopo.session import RETOPO_SESSION

    return RETOPO_SESSION.decode(data)


def by_file(read: Callable[[Path], object]) -> Callable[[bytes], object]:
    """A reader of files as one of bytes."""
    folder = tempfile.TemporaryDirectory(prefix="hostile")
    path = Path(folder.name) / "document"

    def read_bytes(data: bytes) -> object:
        assert folder  # which is removed when nobody holds it
        path.write_bytes(data)
        return read(path)

    return read_bytes


def make_strokes_reader() -> Callable[[bytes], object]:
    from patterndb_sketch.features.files.strokesjson import read_strokes

    return by_file(read_strokes)


def make_feature_network_reader() -> Callable[[bytes], object]:
    from patterndb_sketch.features.files.networkjson import read_network

    return by_file(read_network)


def make_script_reader() -> Callable[[bytes], object]:
    from patterndb_sketch.retopo.script import read_script

    return by_file(read_script)


Maker = Callable[[], Callable[[bytes], object]]

#: Seeds and a maker of the reader, by the kind of document.
KINDS: dict[str, tuple[Callable[[], list[bytes]], Maker]] = {
    "boundary": (seed_boundaries, lambda: read_boundary),
    "batch line": (seed_batch_lines, lambda: read_batch_line),
    "network": (seed_networks, lambda: read_network),
    "feature strokes": (seed_feature_strokes, make_strokes_reader),
    "feature network": (seed_feature_networks, make_feature_network_reader),
    "feature session": (seed_feature_sessions, lambda: read_feature_session),
    "shape model": (seed_shapes, lambda: read_shapes),
    "script": (seed_scripts, make_script_reader),
    "retopology session": (seed_retopo_sessions, lambda: read_retopo_session),
}


# Damage.


def damage(data: bytes, chance: random.Random) -> bytes:
    """A document with a damage or some."""
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        if len(data) > MOST_DAMAGED:
            return data
        if zipfile.is_zipfile(io.BytesIO(data)) and chance.random() < 0.85:
            data = damage_member(data, chance)
        elif chance.random() < 0.65:
            data = damage_values(data, chance)
        else:
            data = damage_bytes(data, chance)
    return data


def damage_member(data: bytes, chance: random.Random) -> bytes:
    """An archive with one of its members damaged, missing, or there twice."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [(one.filename, archive.read(one)) for one in archive.infolist()]
    except Exception:  # it is damaged beyond that already
        members = []
    if not members:
        return damage_bytes(data, chance)
    at = chance.randrange(len(members))
    name, content = members[at]
    act = chance.randrange(8)
    if act == 0:
        del members[at]
    elif act == 1:
        members.append((f"{len(members)}{name}", content))
    elif act == 2:
        members[at] = (name, members[chance.randrange(len(members))][1])
    elif name.endswith(".npy") and act < 6:
        members[at] = (name, damage_array(content, chance))
    elif name.endswith(".npy"):
        members[at] = (name, damage_bytes(content, chance))
    else:
        members[at] = (name, damage(content, chance))
    told = io.BytesIO()
    with zipfile.ZipFile(told, "w") as archive:
        for name, content in members:
            archive.writestr(name, content)
    return told.getvalue()


def damage_array(data: bytes, chance: random.Random) -> bytes:
    """An array whose header or numbers are others."""
    if chance.random() < 0.5 or len(data) < 138:
        text = data[:128]
        changes = (
            (b"<f8", b"|O8"), (b"<f8", b"<i8"), (b"<i4", b"<f4"), (b"<i8", b"<u8"), (b"(", b"(9"),
            (b"False", b"True "), (b",)", b", 1152921504606846976)"), (b"(", b"(-"), (b"<", b">"),
        )  # fmt: skip
        old, new = chance.choice(changes)
        return text.replace(old, new, 1) + data[128:]
    at = chance.randrange(128, len(data) - 8)
    hostile = (b"\xff" * 8, b"\x00" * 8, b"\x00" * 6 + b"\xf0\x7f", b"\xff" * 7 + b"\x7f")
    return data[:at] + chance.choice(hostile) + data[at + 8 :]


def damage_values(data: bytes, chance: random.Random) -> bytes:
    """JSON, or a line of it, with a value that is another, is missing, or is there twice."""
    lines = data.split(b"\n")
    at = chance.randrange(len(lines))
    try:
        document = json.loads(data)
    except (ValueError, RecursionError):
        try:
            document = json.loads(lines[at])
        except (ValueError, RecursionError):
            return damage_bytes(data, chance)
        lines[at] = damage_document(document, chance)
        return b"\n".join(lines)
    return damage_document(document, chance)


def damage_document(document: Any, chance: random.Random) -> bytes:
    """The document as text, one of its values damaged."""
    try:
        return damage_place(document, chance)
    except RecursionError:  # it is deep already
        return b"[" * 900


def damage_place(document: Any, chance: random.Random) -> bytes:
    document = copy.deepcopy(document)
    places: list[tuple[Any, Any]] = []

    def walk(value: Any) -> None:
        inner = value.items() if isinstance(value, dict) else enumerate(value)
        for key, one in inner:
            places.append((value, key))
            if isinstance(one, (dict, list)):
                walk(one)

    if isinstance(document, (dict, list)):
        walk(document)
    if not places or chance.random() < 0.05:
        return dump(chance.choice(HOSTILE))
    # What lies high up is rare among the places, and matters as much.
    reach = len(places) if chance.random() < 0.6 else min(8, len(places))
    value, key = places[chance.randrange(reach)]
    act = chance.randrange(6)
    if act == 0:
        del value[key]
    elif act == 1 and isinstance(value, list):
        value.extend(copy.deepcopy(value[: chance.choice((1, 3, 1000))]))
    elif act == 1:
        value["x" if chance.random() < 0.5 else str(key) + "s"] = value[key]
    elif act == 2:
        deep: Any = 0
        for _ in range(chance.choice((3, 60, 900))):
            deep = [deep]
        value[key] = deep
    else:
        value[key] = copy.deepcopy(chance.choice(HOSTILE))
    text = dump(document)
    if act == 1 and isinstance(value, dict):
        # An entry that is there twice, which no dict can hold.
        text = text.replace(b"{", b"{" + dump(str(key)) + b": 0, ", 1)
    return text


def damage_bytes(data: bytes, chance: random.Random) -> bytes:
    if not data:
        return chance.choice(TOKENS)
    at, end = sorted((chance.randrange(len(data)), chance.randrange(len(data))))
    match chance.randrange(6):
        case 0:
            return data[:at] + bytes([chance.randrange(256)]) + data[at + 1 :]
        case 1:
            return data[:at]
        case 2:
            return data[:at] + data[end:]
        case 3:
            return data[:end] + data[at:end] * chance.choice((1, 2, 50)) + data[end:]
        case 4:
            return data[:at] + chance.choice(TOKENS) + data[at:]
        case _:
            return bytes([data[at]]) * 300 + data


def make_case(kind: str, seeds: list[bytes], seed: int, number: int) -> bytes:
    chance = random.Random(f"{seed} {kind} {number}")
    return damage(chance.choice(seeds), chance)


def judge(read: Callable[[bytes], object], data: bytes) -> tuple[str, str, float]:
    """What becomes of a document, more of it, and the processor's seconds."""
    # Of the processor: a machine that has other work makes everything slow.
    began = time.process_time()
    try:
        read(data)
        result, more = "read", ""
    except PatternDBError as error:
        result, more = "refused", str(error)
    except Exception as error:
        result, more = "unforeseen", f"{type(error).__name__}: {error}"[:300]
    took = time.process_time() - began
    if took > SLOW_SECONDS and result != "unforeseen":
        return "slow", f"{took:.1f} s; {more}"[:300], took
    return result, more, took
