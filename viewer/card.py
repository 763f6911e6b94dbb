"""A disk with what is written under it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.geometry.points import Points
from viewer.drawing import StrokeMark

#: Valences are listed one by one up to this many, then counted.
LISTED_VALENCES = 6

#: How much of a code, and how many meshes, the facts show.
SHOWN_SYMBOLS = 20
SHOWN_MESHES = 3


@dataclass(frozen=True, slots=True)
class Card:
    """One disk of a picture or a sheet.

    title: its name. rank: its place in a list, if it has one. facts: one short line for a
    sheet. details: further lines, for a picture of its own. points: (v, 2) float64 where its
    vertices are drawn, None where its own corners decide. marks: of strokes.
    """

    disk: Disk
    title: str = ""
    rank: int | None = None
    facts: str = ""
    details: tuple[str, ...] = ()
    points: Points | None = None
    marks: tuple[StrokeMark, ...] = ()

    @classmethod
    def of_pattern(cls, pattern: Pattern, rank: int | None = None) -> Card:
        """The card of a pattern: name, irregular valences and frequency."""
        seen = f"{pattern.frequency:,}×" if pattern.frequency else ""
        return cls(
            disk=pattern.disk(),
            title=pattern.name,
            rank=rank,
            facts="   ".join(t for t in (format_valences(pattern.valences), seen) if t),
            details=(_counts(pattern), _polychords(pattern)),
        )

    @classmethod
    def of_disk(
        cls, disk: Disk, title: str = "", rank: int | None = None, facts: str | None = None
    ) -> Card:
        """The card of any disk, such as a fill; facts default to its valences and quads."""
        valences = disk.valence()[disk.irregular()].tolist()
        text = f"{format_valences(valences)}   {format_count(disk.n_quads, 'quad')}"
        lengths = " ".join(str(n) for n in disk.side_lengths().tolist())
        return cls(
            disk,
            title,
            rank,
            text if facts is None else facts,
            (f"{format_count(disk.n_sides, 'side')}: {lengths}",),
        )


def format_valences(valences: Iterable[int]) -> str:
    """Format the irregular valences as people write them: "3·3·5·5", "3×6 · 5×8", "regular"."""
    counts = sorted(Counter(valences).items())
    if not counts:
        return "regular"
    if sum(n for _, n in counts) <= LISTED_VALENCES:
        return "·".join(str(v) for v, n in counts for _ in range(n))
    return " · ".join(f"{v}×{n}" for v, n in counts)


def format_count(count: int, noun: str) -> str:
    """Format a count with its noun: "1 quad", "2 quads", "1,200 quads"."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def collect_facts(
    pattern: Pattern, disk: Disk, widths: Sequence[int], meshes: Sequence[str] = ()
) -> list[tuple[str, str]]:
    """Collect all there is to say about a pattern, as (name, value) lines.

    disk: the pattern at these widths. meshes: those it occurs in.
    """
    lengths = " ".join(str(n) for n in disk.side_lengths().tolist())
    corners = "all convex" if pattern.n_sides else "none"
    if not pattern.convex:
        corners = " ".join(str(k) for k in pattern.corners) + "  quads at each"
    quads = f"{pattern.n_quads:,}"
    if disk.n_quads != pattern.n_quads:
        quads += f", widened {disk.n_quads:,}"
    chords = f"{pattern.n_chords} open, {format_count(pattern.n_loops, 'loop')}"
    turns = "none" if pattern.rotations == 1 else f"{pattern.rotations} rotations"
    mirror = "mirror image differs" if pattern.chiral else "mirror image is the same"
    code = [str(s) for s in pattern.code[:SHOWN_SYMBOLS].tolist()]
    facts = [
        ("name", pattern.name),
        ("sides", f"{pattern.n_sides}: {lengths}" if pattern.n_sides else f"0: {lengths} round"),
        ("corners", corners),
        ("quads", quads),
        ("irregular", format_valences(pattern.valences)),
        ("polychords", chords + (", crosses itself" if pattern.self_crossing else "")),
        ("widths", " ".join(str(w) for w in widths)),
        ("symmetry", f"{turns}, {mirror}"),
        ("code", " ".join(code) + (" …" if len(pattern.code) > SHOWN_SYMBOLS else "")),
        ("seen", format_count(pattern.frequency, "time")),
    ]
    if meshes:
        shown = ", ".join(meshes[:SHOWN_MESHES])
        more = len(meshes) - SHOWN_MESHES
        facts.append(("meshes", shown + (f" and {more:,} more" if more > 0 else "")))
    return facts


def _counts(pattern: Pattern) -> str:
    reflex = sum(k > 2 for k in pattern.corners)
    sides = format_count(pattern.n_sides, "side") + (f" ({reflex} reflex)" if reflex else "")
    return f"{sides} · {format_count(pattern.n_quads, 'quad')}"


def _polychords(pattern: Pattern) -> str:
    text = format_count(pattern.n_chords, "chord")
    if pattern.n_loops:
        text += f" + {format_count(pattern.n_loops, 'loop')}"
    if pattern.rotations > 1:
        text += f" · {pattern.rotations} rotations"
    return text + (" · chiral" if pattern.chiral else "")
