"""What one request may ask for, and how many may: every limit of the service in one place."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields

MIB = 2**20


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a service; GET /v1/limits tells them with what each is for.

    The defaults let one machine serve a room of people who draw: a question of theirs has some
    kilobytes and is answered in milliseconds.
    """

    question_bytes: int = field(
        default=4 * MIB,
        metadata={"unit": "bytes", "what": "the body of a question: fills, uses"},
    )
    mesh_bytes: int = field(
        default=64 * MIB,
        metadata={"unit": "bytes", "what": "a body that holds a mesh: surfaces, holes, meshes"},
    )
    json_depth: int = field(
        default=16, metadata={"unit": "levels", "what": "lists and objects within each other"}
    )
    points: int = field(
        default=100_000,
        metadata={"unit": "points", "what": "points of the sides and strokes of a question"},
    )
    strokes: int = field(
        default=64, metadata={"unit": "strokes", "what": "strokes and loops of a question"}
    )
    sides: int = field(default=24, metadata={"unit": "sides", "what": "sides of a boundary"})
    perimeter: int = field(
        default=2_000, metadata={"unit": "edges", "what": "edges around a boundary, or a hole"}
    )
    fills: int = field(default=1_000, metadata={"unit": "fills", "what": "fills of an answer"})
    answer_bytes: int = field(
        default=64 * MIB,
        metadata={"unit": "bytes", "what": "the fills of an answer, before it is compressed"},
    )
    pool: int = field(
        default=1_000, metadata={"unit": "fills", "what": "fills that an order chooses from"}
    )
    seconds: float = field(
        default=30.0, metadata={"unit": "seconds", "what": "a search, from its first moment on"}
    )
    page: int = field(default=200, metadata={"unit": "patterns", "what": "patterns of a page"})
    header_seconds: float = field(
        default=10.0, metadata={"unit": "seconds", "what": "for a client to send its headers"}
    )
    body_seconds: float = field(
        default=60.0, metadata={"unit": "seconds", "what": "for a client to send its body"}
    )
    send_seconds: float = field(
        default=30.0,
        metadata={"unit": "seconds", "what": "for a client to take what it was sent last"},
    )
    at_work: int = field(
        default_factory=lambda: 8 * (os.cpu_count() or 1),
        metadata={"unit": "requests", "what": "at work at the same time"},
    )
    waiting: int = field(
        default=64, metadata={"unit": "requests", "what": "waiting for one at work to end"}
    )
    waiting_seconds: float = field(
        default=2.0, metadata={"unit": "seconds", "what": "that a request waits before its 429"}
    )
    per_client: int = field(
        default=64,
        metadata={"unit": "requests", "what": "of one address, at work or waiting"},
    )
    connections: int = field(
        default=1_000, metadata={"unit": "connections", "what": "open at the same time"}
    )
    surfaces_bytes: int = field(
        default=512 * MIB, metadata={"unit": "bytes", "what": "all surfaces kept in memory"}
    )
    surface_seconds: float = field(
        default=3_600.0,
        metadata={"unit": "seconds", "what": "that a surface is kept after its last use"},
    )
    jobs: int = field(default=32, metadata={"unit": "jobs", "what": "meshes waiting to be learned"})

    def to_json(self) -> dict[str, dict[str, object]]:
        """Every limit by its name: its value, unit, and what it limits."""
        return {
            one.name: {"value": getattr(self, one.name), **one.metadata} for one in fields(self)
        }


DEFAULT_LIMITS = Limits()
