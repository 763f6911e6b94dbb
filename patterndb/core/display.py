"""How a pattern or a fill is drawn in a notebook: by a renderer that a higher layer registers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

Suffix = Literal[".svg", ".png"]

#: Returns the bytes of a picture of an item, in a format.
Renderer = Callable[[Any, Suffix], bytes]

_renderers: list[Renderer] = []


def set_renderer(renderer: Renderer) -> None:
    """Set what draws patterns and fills from now on."""
    _renderers[:] = [renderer]


def render(item: object, suffix: Suffix) -> bytes:
    """Draw a pattern or fill, as the bytes of an SVG or PNG file."""
    return _renderers[0](item, suffix)
