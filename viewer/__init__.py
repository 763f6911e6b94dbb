"""Seeing patterns and fills: flat drawings, pictures, contact sheets and a browser."""

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
