"""What a cluster's workers do: learn parts of a mesh, put parts together, and give columns back.

A mesh travels as the bytes of its quads, never as a path: workers need no files. What comes back
are columns: arrays of numbers, and rows of bytes as one array with their ends. Nothing here knows
of Dask; :mod:`ingest.cluster` sends it to workers, where patterndb must be installed.
"""

from __future__ import annotations

import platform
import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import fields
from hashlib import sha256
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ingest.learning import MeshLearning, Tally, merge_tallies
from patterndb._native import __version__
from patterndb.core.code import pattern_ids
from patterndb.core.halfedge import Int32Array
from patterndb.core.packing import PackedRows
from patterndb.errors import ClusterError
from patterndb.store.records import Learned, LearningOptions, take_patterns

RecordT = TypeVar("RecordT", Tally, Learned)

#: A result on its way: the fields of a Tally or of Learned, rows of bytes as array and ends.
Columns = Mapping[str, Any]

#: Prepared meshes that a worker keeps, since it may get another part of one next.
KEPT_MESHES = 2

#: Fields that are rows of bytes.
_BYTES = ("codes", "examples")


class MeshParcel(NamedTuple):
    """A mesh as it travels.

    quads: (q, 4) int32, as bytes. faces: (q,) int64 their places in the file, as bytes; empty where
    they are 0, 1, 2... shard_quads: the most quads of a task. versions: of the client.
    """

    quads: bytes
    faces: bytes
    options: LearningOptions
    shard_quads: int
    versions: Mapping[str, str]

    @classmethod
    def wrap(
        cls,
        quads: Int32Array,
        faces: NDArray[np.int64],
        options: LearningOptions,
        shard_quads: int,
    ) -> MeshParcel:
        """Make the parcel of a mesh of quads (q, 4) at these places (q,) of its file."""
        plain = np.array_equal(faces, np.arange(len(quads)))
        return cls(
            np.ascontiguousarray(quads, np.int32).tobytes(),
            b"" if plain else np.ascontiguousarray(faces, np.int64).tobytes(),
            options,
            shard_quads,
            list_versions(),
        )


def list_versions() -> dict[str, str]:
    """Versions of what the results depend on, in this process."""
    return {
        "python": platform.python_version(),
        "patterndb": __version__,
        "numpy": np.__version__,
    }


def find_differences(mine: Mapping[str, str], theirs: Mapping[str, str]) -> list[str]:
    """Say in words what versions differ: "numpy is 2.3.0 there and 2.4.1 here"."""
    return [
        f"{name} is {theirs.get(name, 'missing')} there and {version} here"
        for name, version in mine.items()
        if theirs.get(name) != version
    ]


def hold_parcel(parcel: MeshParcel) -> MeshParcel:
    """Give the mesh back: a task of its own, so that its bytes are sent once, and again to another
    worker where one is lost."""
    return parcel


def learn_part(parcel: MeshParcel, part: int, n_parts: int) -> Columns:
    """Learn part number ``part`` of a mesh, from 0. Returns the columns of a Tally.

    Raises ClusterError where this worker's versions are not the client's.
    """
    learning = _prepare(parcel)
    return to_columns(merge_tallies([task() for task in learning.tasks[part::n_parts]]))


def merge_parts(parts: Sequence[Columns]) -> Columns:
    """Make one tally of several."""
    return to_columns(merge_tallies([from_columns(Tally, part) for part in parts]))


def finish_mesh(parcel: MeshParcel, parts: Sequence[Columns]) -> Columns:
    """Put the parts of a mesh together. Returns the columns of Learned, its patterns in the order
    of their ids: that in which the writer wants them."""
    learned = _prepare(parcel).finish([from_columns(Tally, part) for part in parts])
    order = np.argsort(pattern_ids(learned.codes, learned.sides))
    return to_columns(take_patterns(learned, order))


def learn_whole(parcel: MeshParcel) -> Columns:
    """Learn a mesh of one part. Returns the columns of Learned."""
    return finish_mesh(parcel, [learn_part(parcel, 0, 1)])


def to_columns(record: Tally | Learned) -> dict[str, Any]:
    """The columns of a record."""
    columns: dict[str, Any] = {}
    for field in fields(record):
        value = getattr(record, field.name)
        if field.name in _BYTES:
            rows = PackedRows.of(value)
            columns[field.name] = rows.raw
            columns[f"{field.name}_ends"] = rows.ends
        else:
            columns[field.name] = value
    return columns


def from_columns(kind: type[RecordT], columns: Columns) -> RecordT:
    """The record of such columns."""
    held: dict[str, Any] = {
        field.name: PackedRows(columns[field.name], columns[f"{field.name}_ends"])
        if field.name in _BYTES
        else columns[field.name]
        for field in fields(kind)
    }
    return kind(**held)


_kept: OrderedDict[bytes, MeshLearning] = OrderedDict()
_preparing = threading.Lock()


def _prepare(parcel: MeshParcel) -> MeshLearning:
    """The mesh ready to be learned; kept for its other parts."""
    differences = find_differences(parcel.versions, list_versions())
    if differences:
        raise ClusterError(f"a worker differs from this program: {'; '.join(differences)}")
    key = sha256(
        b"".join((parcel.quads, parcel.faces, repr((parcel.options, parcel.shard_quads)).encode()))
    ).digest()
    with _preparing:
        learning = _kept.pop(key, None)
        if learning is None:
            quads = np.frombuffer(parcel.quads, np.int32).reshape(-1, 4)
            faces = np.frombuffer(parcel.faces, np.int64)
            learning = MeshLearning(
                quads,
                faces if len(faces) else np.arange(len(quads)),
                parcel.options,
                shard_quads=parcel.shard_quads,
                pulse=np.zeros(2, np.int64),
            )
        _kept[key] = learning
        while len(_kept) > KEPT_MESHES:
            _kept.popitem(last=False)
    return learning
