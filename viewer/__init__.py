"""Seeing patterns and fills: flat drawings, pictures, contact sheets and a browser."""

from viewer.browse import browse
from viewer.browser_state import BrowserState, PatternSource
from viewer.card import Card
from viewer.embedding import embed, flipped
from viewer.gallery import save_gallery
from viewer.opengl import DisplayError
from viewer.paper import PictureFormatError, save_picture

__all__ = [
    "BrowserState",
    "Card",
    "DisplayError",
    "PatternSource",
    "PictureFormatError",
    "browse",
    "embed",
    "flipped",
    "save_gallery",
    "save_picture",
]
