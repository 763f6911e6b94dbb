"""Seeing patterns and fills: flat drawings, pictures, contact sheets, and the windows.

Read in this order. Flat pictures: :mod:`~viewer.drawing` cuts a disk that was laid out
(:mod:`patterndb.geometry.embedding`) into polygons, :mod:`~viewer.painting` paints these,
:mod:`~viewer.paper` and :mod:`~viewer.gallery` write files. What all viewers share:
:mod:`~viewer.commands` (what can be done, one table a viewer), :mod:`~viewer.keymap`,
:mod:`~viewer.saver`, :mod:`~viewer.scene` (what is flat), :mod:`~viewer.stage` (what is in space,
and VTK's actors for it), :mod:`~viewer.camera`, :mod:`~viewer.picture`, :mod:`~viewer.facts`,
:mod:`~viewer.slider`, :mod:`~viewer.pointer`; and :mod:`viewer.shell`, the window that they have
on a screen. The pattern browser: :mod:`~viewer.browser_state`, :mod:`~viewer.browser`. The fill
explorer: :mod:`patterndb_sketch.exploration`, :mod:`~viewer.explorer_state`,
:mod:`~viewer.explorer_picture`, :mod:`~viewer.explore`. In scripts and notebooks:
:mod:`~viewer.plotting`. The folders hold a viewer each. A viewer's state, its commands and its
pictures know no Qt; only its ``*_window`` or ``docks`` module does, and the shell.

Names are loaded when they are asked for: who draws a sheet waits for no window's module.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from patterndb.system.lazy import lazy_exports

if TYPE_CHECKING:
    from viewer.browser import browse
    from viewer.gallery import save_gallery
    from viewer.paper import PictureFormatError, save_picture
    from viewer.shell.probe import DisplayError

__all__ = [
    "DisplayError",
    "PictureFormatError",
    "browse",
    "save_gallery",
    "save_picture",
]

#: The module that defines each public name.
_HOMES = {
    "DisplayError": "viewer.shell.probe",
    "PictureFormatError": "viewer.paper",
    "browse": "viewer.browser",
    "save_gallery": "viewer.gallery",
    "save_picture": "viewer.paper",
}

__getattr__, __dir__ = lazy_exports(__name__, _HOMES)
