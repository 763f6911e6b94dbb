"""What the viewer's keys choose, and the way back: all that needs no pointer."""

from __future__ import annotations

from dataclasses import replace

from patterndb.store import Database
from patterndb_sketch.surfacing.methods import METHODS
from patterndb_sketch.surfacing.surfaces import Settings
from viewer.surfacing.edits import Edits, next_method
from viewer.surfacing.finding import Find
from viewer.surfacing.surfaces import Surfaces


class Choices(Surfaces):
    """Alpha, methods, stages and switches.

    The arguments are those of :class:`viewer.surfacing.surfaces.Surfaces`. helping: is the list
    of keys shown? surface_shown and so on: what else is. message: what went wrong last.
    """

    def __init__(
        self,
        edits: Edits,
        settings: Settings,
        spacing: float | None,
        db: Database | None,
        find: Find,
    ) -> None:
        self.surface_shown = self.chords_shown = self.curves_shown = self.off_shown = True
        self.edges_shown = METHODS[edits.method].makes_quads
        self.helping = False
        self.message = ""
        self._history: list[Edits] = []
        super().__init__(edits, settings, spacing, db, find)

    def toggle(self, name: str) -> None:
        """Turn one of the switches, such as helping or chords_shown."""
        setattr(self, name, not getattr(self, name))

    def change_alpha(self, alpha: float) -> None:
        """Another price of chords, from 0 to 1."""
        alpha = round(min(max(alpha, 0.0), 1.0), 3)
        if alpha != self.settings.alpha:
            self.settings = replace(self.settings, alpha=alpha)
            self._ask()

    def next_method(self) -> None:
        """The next method for all patches."""
        method = next_method(self.edits.method, database=self.has_database)
        self._edit(self.edits.with_method(method))
        self.edges_shown = METHODS[method].makes_quads

    def go_to_stage(self, stage: int) -> None:
        """As the drawing was after so many stages; from the end, if below 0."""
        n = self.n_stages
        if not n:
            self.message = "the drawing has no stages"
            return
        stage = min(max(stage if stage >= 0 else n + 1 + stage, 0), n)
        if stage != self.edits.stage:
            self.edits = replace(self.edits, stage=stage, inks=())
            self._ask()

    def step(self, by: int) -> None:
        """Stages forward or back, stopping at the ends."""
        self.go_to_stage(max(self.edits.stage + by, 0))

    def all_on(self) -> None:
        """Switch on whatever was switched off."""
        if self.edits.banned:
            self._edit(replace(self.edits, banned=()))

    def undo(self) -> None:
        """Take back the last stroke, curve, click on a patch or change of method."""
        if not self._history:
            self.message = "there is nothing to take back"
            return
        before, self.edits = self.edits, self._history.pop()
        if not self.edits.asks_like(before):
            self.edges_shown = METHODS[self.edits.method].makes_quads
            self._ask()

    def _edit(self, after: Edits) -> None:
        """Another step that can be taken back."""
        self._history.append(self.edits)
        self.edits = after
        self._ask()
