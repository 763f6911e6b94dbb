"""What the pattern browser shows and how that changes: no window in here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import NotFoundError, PatternDBError

#: A pattern's disk with every polychord at its width, numbered as Pattern.label does;
#: its boundary begins where the pattern's does.
Expand = Callable[[Pattern, Sequence[int]], Disk]

#: Patterns on a page: columns and rows of thumbnails.
COLUMNS, ROWS = 5, 4
PER_PAGE = COLUMNS * ROWS

#: Widest that a polychord can be made by hand; the picture is unreadable long before.
MAX_WIDTH = 24

#: Valences that the valence filter lets through, in the order in which the key takes them.
VALENCE_RANGES: tuple[tuple[int, int] | None, ...] = (None, (3, 5), (3, 6), (3, 4), (4, 5))


class BrowserSource(Protocol):
    """Where patterns come from: a database, or anything with these two methods."""

    def sides_histogram(self) -> Mapping[int, int]:
        """Number of patterns for every number of sides."""
        ...

    def pattern_class(self, n_sides: int) -> PatternClass:
        """All patterns of so many sides, in rank order."""
        ...


class BrowserState:
    """Which class, filters, pattern and widths are shown.

    Widths and the chosen polychord belong to the selected pattern and are forgotten with
    it. Raises NotFoundError if the source has no pattern at all, or none of ``n_sides``.
    """

    def __init__(
        self, source: BrowserSource, *, n_sides: int | None = None, expand: Expand | None = None
    ) -> None:
        self._source = source
        self._expand = expand
        self.classes = sorted(n for n, count in source.sides_histogram().items() if count)
        if not self.classes:
            raise NotFoundError("there is no pattern to browse; learn some from meshes first")
        if n_sides is not None and n_sides not in self.classes:
            have = ", ".join(str(n) for n in self.classes)
            raise NotFoundError(f"there is no pattern of {n_sides} sides; there are some of {have}")
        self.n_irregular: int | None = None
        self.valences: tuple[int, int] | None = None
        self.convex_only = False
        self.mirrored = False
        self.tinted = True
        self.labelled = False
        self.inspecting = True
        self.message = ""
        self._enter(self.classes[0] if n_sides is None else n_sides)

    # What is shown

    @property
    def page(self) -> int:
        """Number of the page that holds the selection, from 0."""
        return self.position // PER_PAGE

    @property
    def n_pages(self) -> int:
        """Number of pages, at least 1."""
        return max(1, -(-len(self.rows) // PER_PAGE))

    def page_rows(self) -> NDArray[np.int64]:
        """(k,) int64 rows of the class on this page."""
        return self.rows[self.page * PER_PAGE : (self.page + 1) * PER_PAGE]

    @property
    def selected(self) -> Pattern | None:
        """The selected pattern; None where the filters leave none."""
        if len(self.rows) == 0:
            return None
        return self.patterns.pattern(int(self.rows[self.position]))

    @property
    def widths(self) -> tuple[int, ...]:
        """Width of every polychord of the selection, as Pattern.label numbers them."""
        return self._widths

    def selected_disk(self) -> Disk | None:
        """The selected pattern at its widths."""
        pattern = self.selected
        if pattern is None or self._expand is None or all(w == 1 for w in self._widths):
            return None if pattern is None else pattern.disk()
        return self._expand(pattern, self._widths)

    def filters(self) -> str:
        """The filters in words, "" if there are none."""
        words: list[str] = []
        if self.n_irregular is not None:
            words.append(f"{self.n_irregular} irregular")
        if self.valences is not None:
            words.append(f"valences {self.valences[0]}–{self.valences[1]}")
        if self.convex_only:
            words.append("convex")
        return ", ".join(words)

    # What keys do, see viewer.browser_commands

    def step(self, by: int) -> None:
        """Select another pattern, stopping at the ends."""
        self.select(self.position + by)

    def turn_page(self, by: int) -> None:
        """Select the same place of another page, or the nearest there is."""
        last = (self.n_pages - 1) * PER_PAGE
        place = self.position % PER_PAGE
        self.select(min(max(self.position - place + by * PER_PAGE, 0), last) + place)

    def select(self, position: int) -> None:
        """Select by place among the patterns that pass the filters."""
        if len(self.rows) == 0:
            return
        position = max(0, min(position, len(self.rows) - 1))
        if position != self.position:
            self.position = position
            self._forget_widths()
            self._row = int(self.rows[position])

    def change_class(self, by: int) -> None:
        """Go to the next smaller or larger number of sides that has patterns."""
        at = self.classes.index(self.patterns.n_sides) + by
        if 0 <= at < len(self.classes):
            self._enter(self.classes[at])

    def change_irregular(self, by: int) -> None:
        """One irregular vertex more or fewer; below 0 the filter is off."""
        most = int(self.patterns.n_irregular.max(initial=0))
        count = -1 if self.n_irregular is None else self.n_irregular
        count = max(-1, min(count + by, most))
        self.n_irregular = None if count < 0 else count
        self._filter()

    def change_valences(self) -> None:
        """The next of VALENCE_RANGES."""
        at = VALENCE_RANGES.index(self.valences)
        self.valences = VALENCE_RANGES[(at + 1) % len(VALENCE_RANGES)]
        self._filter()

    def limit_irregular(self, count: int | None) -> None:
        """Patterns of so many irregular vertices, None for any number."""
        self.n_irregular = count
        self._filter()

    def choose_valences(self, valences: tuple[int, int] | None) -> None:
        """One of VALENCE_RANGES."""
        self.valences = valences
        self._filter()

    def choose_class(self, n_sides: int) -> None:
        """The patterns of so many sides, one of ``classes``."""
        if n_sides != self.patterns.n_sides:
            self._enter(n_sides)

    def toggle_convex(self) -> None:
        """Patterns without a reflex corner only, or all."""
        self.convex_only = not self.convex_only
        self._filter()

    def choose_chord(self, by: int) -> None:
        """Choose the next polychord, or the first; past the last, none."""
        if not self._widths:
            return
        choices = len(self._widths) + 1
        at = len(self._widths) if self.chord is None else self.chord
        at = (at + by) % choices
        self.chord = None if at == len(self._widths) else at

    def change_width(self, by: int) -> None:
        """Make the chosen polychord wider or narrower; none chosen: the first."""
        if self._expand is None:
            self.message = "polychords cannot be widened here: no expansion was given"
            return
        if not self._widths:
            return
        if self.chord is None:
            self.chord = 0
        before = self._widths
        width = max(1, min(before[self.chord] + by, MAX_WIDTH))
        self._widths = (*before[: self.chord], width, *before[self.chord + 1 :])
        try:
            self.selected_disk()
        except PatternDBError as error:
            self._widths = before
            self.message = str(error)

    def reset_widths(self) -> None:
        """All widths back to 1, no polychord chosen."""
        self._forget_widths()

    def toggle(self, name: str) -> None:
        """Turn one of the switches mirrored, tinted, labelled, inspecting."""
        setattr(self, name, not getattr(self, name))

    def poll(self) -> bool:
        """Nothing is made in the background."""
        return False

    def _enter(self, n_sides: int) -> None:
        self.patterns = self._source.pattern_class(n_sides)
        # The selection's row; outlasts filters that let nothing through.
        self._row = -1
        self._filter()

    def _filter(self) -> None:
        """Apply the filters, and keep the selection if it passes them."""
        p = self.patterns
        keep = np.ones(len(p), np.bool_)
        if self.n_irregular is not None:
            keep &= p.n_irregular == self.n_irregular
        if self.valences is not None:
            keep &= (p.min_valence >= self.valences[0]) & (p.max_valence <= self.valences[1])
        if self.convex_only:
            keep &= p.n_reflex == 0
        self.rows: NDArray[np.int64] = np.flatnonzero(keep)
        at = np.flatnonzero(self.rows == self._row)
        self.position = int(at[0]) if len(at) else 0
        if len(self.rows):
            self._row = int(self.rows[self.position])
        self._forget_widths()

    def _forget_widths(self) -> None:
        pattern = self.selected
        n = 0 if pattern is None else pattern.n_chords + pattern.n_loops
        self._widths: tuple[int, ...] = (1,) * n
        self.chord: int | None = None
