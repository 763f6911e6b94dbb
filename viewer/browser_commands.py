"""The pattern browser's commands and keys, and what they do to its state."""

from __future__ import annotations

from collections.abc import Callable

from viewer.browser_state import BrowserState
from viewer.commands import Command
from viewer.keymap import Effect, KeyMap


def _has_chords(state: BrowserState) -> bool:
    return bool(state.widths)


def _turned(name: str) -> Callable[[BrowserState], bool]:
    return lambda b: bool(getattr(b, name))


COMMANDS: tuple[Command[BrowserState], ...] = (
    Command("previous", "Previous pattern", "Pattern", ("Left",), lambda b: b.step(-1),
            enabled=lambda b: b.position > 0, bar=True),
    Command("next", "Next pattern", "Pattern", ("Right",), lambda b: b.step(1),
            enabled=lambda b: b.position + 1 < len(b.rows), bar=True),
    Command("first", "First pattern", "Pattern", ("Ctrl+Home", "Home"), lambda b: b.select(0)),
    Command("last", "Last pattern", "Pattern", ("Ctrl+End", "End"),
            lambda b: b.select(len(b.rows) - 1)),
    Command("previous-page", "Previous page", "Pattern", ("p",), lambda b: b.turn_page(-1),
            enabled=lambda b: b.page > 0, bar=True),
    Command("next-page", "Next page", "Pattern", ("n",), lambda b: b.turn_page(1),
            enabled=lambda b: b.page + 1 < b.n_pages, bar=True),
    Command("fewer-sides", "Fewer sides", "Filter", (",",), lambda b: b.change_class(-1),
            "Patterns of the next smaller number of sides",
            enabled=lambda b: b.patterns.n_sides > b.classes[0], bar=True),
    Command("more-sides", "More sides", "Filter", (".",), lambda b: b.change_class(1),
            "Patterns of the next larger number of sides",
            enabled=lambda b: b.patterns.n_sides < b.classes[-1], bar=True),
    Command("more-irregular", "More irregular vertices", "Filter", ("+",),
            lambda b: b.change_irregular(1), "Patterns with one irregular vertex more"),
    Command("fewer-irregular", "Fewer irregular vertices", "Filter", ("-",),
            lambda b: b.change_irregular(-1),
            "Patterns with one irregular vertex fewer; below none, all patterns"),
    Command("valences", "Next range of valences", "Filter", ("v",),
            lambda b: b.change_valences(), "Patterns whose valences are in the next range"),
    Command("convex", "Convex patterns only", "Filter", ("c",), lambda b: b.toggle_convex(),
            "Patterns without a reflex corner only, or all", checked=_turned("convex_only")),
    Command("chord-before", "Polychord before", "Polychord", ("[",),
            lambda b: b.choose_chord(-1), "Choose the polychord before", enabled=_has_chords),
    Command("chord-after", "Next polychord", "Polychord", ("]",),
            lambda b: b.choose_chord(1), "Choose the next polychord", enabled=_has_chords),
    Command("wider", "Wider", "Polychord", ("Up",), lambda b: b.change_width(1),
            "Make the chosen polychord wider", enabled=_has_chords),
    Command("narrower", "Narrower", "Polychord", ("Down",), lambda b: b.change_width(-1),
            "Make the chosen polychord narrower", enabled=_has_chords),
    Command("reset-widths", "Widths back to 1", "Polychord", ("r",), lambda b: b.reset_widths(),
            enabled=lambda b: any(width != 1 for width in b.widths) or b.chord is not None),
    Command("mirror", "Mirror image", "View", ("m",), lambda b: b.toggle("mirrored"),
            checked=_turned("mirrored")),
    Command("tints", "Tints of polychords", "View", ("t",), lambda b: b.toggle("tinted"),
            checked=_turned("tinted")),
    Command("labels", "Labels", "View", ("l",), lambda b: b.toggle("labelled"),
            "Number the sides, and the polychords that end on them", checked=_turned("labelled")),
    Command("facts", "Facts of the pattern", "View", ("i",), lambda b: b.toggle("inspecting"),
            checked=_turned("inspecting")),
)  # fmt: skip

KEYS: KeyMap[BrowserState] = KeyMap(COMMANDS, {"s": Effect.PICTURE, "q": Effect.QUIT})
