"""How a pattern or a fill shows itself in a notebook: by what has been named to draw it.

The ground knows nothing of drawing. The face, ``import patterndb``, names what does
(:func:`patterndb.notebook.draw`); it comes before every other module here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

Suffix = Literal[".svg", ".png"]

#: Gives the bytes of a picture: of what, and as what.
Draw = Callable[[Any, Suffix], bytes]

_draws: list[Draw] = []


def draw_by(draw: Draw) -> None:
    """Name what draws patterns and fills from now on."""
    _draws[:] = [draw]


def draw_shown(item: object, suffix: Suffix) -> bytes:
    """Draw a pattern or fill, as the bytes of an SVG or PNG file."""
    return _draws[0](item, suffix)
