"""What is shown beside the shape, and which modes: all that keys choose without the pointer."""

from __future__ import annotations

from numpy.typing import ArrayLike

from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.shapemodel import ShapeModel
from viewer.shapes.layout import MODES, pages
from viewer.shapes.shaping import Shaping


class Switches(Shaping):
    """Switches and pages.

    The arguments are those of :class:`viewer.shapes.shaping.Shaping`. curves_shown, edges_shown,
    helping: are the curves, the edges of faces, the list of keys shown? chosen: the mode that
    arrow keys change. page: of the modes.
    """

    def __init__(
        self, shapes: ShapeModel, template: Template, coefficients: ArrayLike | None = None
    ) -> None:
        super().__init__(shapes, template, coefficients)
        self.curves_shown = True
        self.edges_shown = self.helping = False
        self.page = self.chosen = 0

    def toggle(self, name: str) -> None:
        """Turn one of the switches, such as helping or edges_shown."""
        setattr(self, name, not getattr(self, name))

    def turn_page(self, by: int) -> None:
        """Other modes in the panel."""
        count = pages(self.shapes.n_modes)
        if count == 1:
            self.message = "all modes are shown"
        self.page = (self.page + by) % count
        if self.chosen // MODES != self.page:
            self.chosen = self.page * MODES

    def choose_mode(self, by: int) -> None:
        """The next mode, or the one before, for the arrow keys."""
        self.chosen = (self.chosen + by) % self.shapes.n_modes
        self.page = self.chosen // MODES
