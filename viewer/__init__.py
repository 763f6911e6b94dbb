"""Seeing patterns and fills: flat drawings, pictures, contact sheets, and the windows.

Read in this order. Flat pictures: :mod:`~viewer.embedding` (with :mod:`~viewer.relax`) lays a disk
out, :mod:`~viewer.drawing` cuts it into polygons, :mod:`~viewer.painting` paints these,
:mod:`~viewer.paper` and :mod:`~viewer.gallery` write files. What all windows share:
:mod:`~viewer.scene`, :mod:`~viewer.solid`, :mod:`~viewer.camera`, :mod:`~viewer.picture`,
:mod:`~viewer.panel`, :mod:`~viewer.slider`, :mod:`~viewer.nearness`, :mod:`~viewer.keymap`,
:mod:`~viewer.saver`, :mod:`~viewer.window`. The pattern browser: :mod:`~viewer.browser_state`,
:mod:`~viewer.browse`. The fill explorer: :mod:`~viewer.finder`, :mod:`~viewer.explorer_state`,
:mod:`~viewer.explorer_picture`, :mod:`~viewer.explore`. The folders hold a viewer each.
"""

from viewer.browse import browse
from viewer.browser_state import BrowserSource, BrowserState
from viewer.card import Card
from viewer.embedding import embed_disk, find_flipped_quads
from viewer.gallery import save_gallery
from viewer.opengl import DisplayError
from viewer.paper import PictureFormatError, save_picture

__all__ = [
    "BrowserSource",
    "BrowserState",
    "Card",
    "DisplayError",
    "PictureFormatError",
    "browse",
    "embed_disk",
    "find_flipped_quads",
    "save_gallery",
    "save_picture",
]
