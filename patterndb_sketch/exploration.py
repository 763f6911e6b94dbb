"""Exploring the fills of a boundary: what is asked, steps back and forward, and odd perimeters.

:class:`Exploration` is what a window drives, and a script can: sides get other numbers of edges,
corners are turned, strokes added, and each change is a step that can be taken back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

from patterndb.errors import PatternDBError
from patterndb.system.documents import JsonValue
from patterndb.system.numbers import TOLERANCE
from patterndb_sketch.fillfinder import LIMIT, FillFinder, Placed, Prepare
from patterndb_sketch.history import History
from patterndb_sketch.sessions import SessionFormat
from query import Boundary, Stroke
from query.contour import Contour
from query.engine import PatternSource
from query.errors import InvalidQueryError
from query.placing import Surface


@dataclass(frozen=True, slots=True)
class FinderChoices:
    """The choices of a :class:`~patterndb_sketch.fillfinder.FillFinder` that undo brings back."""

    tolerance: int
    order: str | None
    strict: bool
    folded: bool
    following: bool
    max_irregular: int | None
    max_valence: int | None


@dataclass(frozen=True, slots=True, eq=False)
class ExplorationStep:
    """What is asked for: all that undo brings back, and that is kept in case of a crash."""

    contour: Contour | None
    strokes: tuple[Stroke, ...]
    choices: FinderChoices

    def is_like(self, other: ExplorationStep) -> bool:
        """Is the same asked for?"""
        return (
            self.contour is other.contour
            and [id(one) for one in self.strokes] == [id(one) for one in other.strokes]
            and self.choices == other.choices
        )


def _open_step(step: ExplorationStep, place: JsonValue) -> ExplorationStep:
    """Return a step that was read; raises InvalidQueryError for sides that are not polylines."""
    for i, side in enumerate(() if step.contour is None else step.contour.sides):
        if side.shape != (len(side), 3) or len(side) < 2:
            place.at("contour", "sides", i).fail("a side needs two points [x, y, z] or more")
    return step


EXPLORATION_SESSION: SessionFormat[ExplorationStep, ExplorationStep] = SessionFormat(
    "explore", InvalidQueryError, ExplorationStep, lambda step: step, _open_step
)


class Exploration:
    """A boundary and strokes on a surface, and the fills that are found for them.

    surface: what fills are placed on; None is the plane of the boundary. boundary: its vertices
    placed, None for none yet. strokes: on it. tolerance, limit: as for :func:`query.fills`. folded,
    prepare: see :class:`patterndb_sketch.fillfinder.FillFinder`. finder: the fills. former: the one
    that was shown before the boundary was changed, until there is another. drawn_here: was a
    boundary or a stroke drawn since a fill was saved? steps: what was asked for.
    """

    def __init__(
        self,
        source: PatternSource,
        boundary: Boundary | None = None,
        *,
        surface: Surface | None = None,
        strokes: Sequence[Stroke] = (),
        tolerance: int = TOLERANCE,
        limit: int = LIMIT,
        folded: bool = True,
        prepare: Prepare | None = None,
    ) -> None:
        self.finder = FillFinder(source, surface, strokes, tolerance, limit, folded, prepare)
        self.contour: Contour | None = None
        self.former: Placed | None = None
        self.drawn_here = False
        if boundary is not None:
            self.change(Contour.of(boundary))
        self.steps = History(self._step())

    # Steps back and forward

    def keep_step(self) -> None:
        """Keep what was asked for before, if it has changed; call it after whatever may have."""
        now = self._step()
        if not now.is_like(self.steps.now):
            self.steps.step(now)

    def undo(self) -> bool:
        """Ask for what was asked before; False if there is no step back."""
        return self._turn(self.steps.undo(), "there is nothing to take back")

    def redo(self) -> bool:
        """Ask again for what was taken back last; False if there is no step forward."""
        return self._turn(self.steps.redo(), "there is nothing to do again")

    def take_work(self, work: ExplorationStep) -> None:
        """Take work that was kept, as one step."""
        self._show_step(work)
        self.keep_step()
        self.drawn_here = True

    def _turn(self, turned: bool, otherwise: str) -> bool:
        if turned:
            self._show_step(self.steps.now)
        else:
            self.finder.message = otherwise
        return turned

    def _show_step(self, step: ExplorationStep) -> None:
        for one in fields(step.choices):
            setattr(self.finder, one.name, getattr(step.choices, one.name))
        self.finder.strokes = list(step.strokes)
        self.contour = step.contour
        self._ask()

    def _step(self) -> ExplorationStep:
        names = [one.name for one in fields(FinderChoices)]
        choices = FinderChoices(*(getattr(self.finder, name) for name in names))
        return ExplorationStep(self.contour, tuple(self.finder.strokes), choices)

    # The boundary and its strokes

    def change(self, contour: Contour) -> None:
        """Take another form of the boundary: strokes are drawn on it anew, and fills asked for."""
        self.contour = contour
        self._ask(redraw=True)

    def begin(self, contour: Contour) -> None:
        """Take another boundary altogether, without strokes."""
        self.finder.strokes = []
        self.drawn_here = True
        self.change(contour)
        # That of another boundary is of no use.
        self.former = None

    def scale_lengths(self, factor: float) -> None:
        """Give all sides more or fewer edges."""
        if self.contour is None:
            return
        try:
            self.change(self.contour.scaled(factor))
        except PatternDBError as error:
            self.finder.message = str(error)

    def list_even_lengths(self) -> list[tuple[int, int]]:
        """List sides and the numbers of edges, one more or fewer, that would make the perimeter
        even; none if it is even."""
        return [] if self.contour is None else self.contour.list_even_lengths()

    def choose_length(self, side: int, length: int) -> None:
        """Give a side another number of edges."""
        if self.contour is not None:
            self.change(self.contour.lengthened(side, length - self.contour.lengths[side]))

    def reverse(self) -> None:
        """Fill what is on the other side of the boundary."""
        if self.contour is not None:
            self.change(self.contour.reversed())

    def add_stroke(self, stroke: Stroke) -> None:
        """Have a strand along another stroke."""
        self.finder.strokes.append(stroke)
        self.drawn_here = True
        self.finder.restart()

    def _ask(self, *, redraw: bool = False) -> None:
        """Ask for fills of the boundary as it is now; redraw: strokes were drawn on another."""
        self.former = self.finder.placed or self.former
        self.finder.boundary = None
        if self.contour is not None:
            try:
                self.finder.boundary = self.contour.boundary()
            except PatternDBError as error:
                self.finder.message = str(error)
        if redraw and self.finder.boundary is not None:
            self._redraw_strokes(self.finder.boundary)
        self.finder.restart()

    def _redraw_strokes(self, boundary: Boundary) -> None:
        kept: list[Stroke] = []
        for stroke in self.finder.strokes:
            try:
                if stroke.points is not None and not stroke.is_loop:
                    stroke = Stroke.drawn(boundary, stroke.points)
                stroke.refuse_unless_on(boundary)
            except PatternDBError as error:
                self.finder.message = f"a stroke was dropped: {error}"
            else:
                kept.append(stroke)
        self.finder.strokes = kept
