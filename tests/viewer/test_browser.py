"""The browser: its state under keys, its scene, and a picture of it where one can be drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patterndb.core.disk import Disk
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import PatternClass
from patterndb.errors import InvalidBoundaryError, NotFoundError
from tests.support.viewer.disks import ALL, expand, pattern
from tests.support.viewer.sayings import read_sheet
from viewer import PictureFormatError, browse
from viewer.browser_commands import KEYS
from viewer.browser_picture import compose_browser, describe_browser
from viewer.browser_state import MAX_WIDTH, PER_PAGE, BrowserState
from viewer.facts import FactSheet
from viewer.keymap import Effect


class Source:
    """Patterns in memory; copies of a square fill several pages."""

    def __init__(self) -> None:
        self.classes: dict[int, list[Pattern]] = {}
        for i, quads in enumerate(q for name, q in ALL.items() if name != "ring"):
            p = pattern(quads, frequency=200 - i)
            self.classes.setdefault(p.n_sides, []).append(p)
        self.classes[4] += [pattern(ALL["one quad"], frequency=50 - i) for i in range(45)]

    def sides_histogram(self) -> dict[int, int]:
        return {n: len(p) for n, p in self.classes.items()} | {99: 0}

    def pattern_class(self, n_sides: int) -> PatternClass:
        return PatternClass.from_patterns(n_sides, self.classes[n_sides])


SOURCE = Source()


@pytest.fixture
def state() -> BrowserState:
    return BrowserState(SOURCE, n_sides=4, expand=expand)


def keys(state: BrowserState, text: str) -> None:
    for key in text.split():
        assert KEYS.press(state, key) is Effect.REDRAW


def test_it_begins_with_the_smallest_class() -> None:
    state = BrowserState(SOURCE)
    assert state.patterns.n_sides == min(state.classes) and state.position == state.page == 0
    assert 99 not in state.classes


def test_nothing_to_browse() -> None:
    class Empty(Source):
        def sides_histogram(self) -> dict[int, int]:
            return {}

    with pytest.raises(NotFoundError, match="no pattern to browse"):
        BrowserState(Empty())
    with pytest.raises(NotFoundError, match="no pattern of 99 sides"):
        BrowserState(SOURCE, n_sides=99)


def test_steps_and_pages(state: BrowserState) -> None:
    last = len(state.rows) - 1
    assert last > 2 * PER_PAGE
    keys(state, "Left")
    assert state.position == 0
    keys(state, "Right Right n")
    assert (state.position, state.page) == (2 + PER_PAGE, 1)
    keys(state, "n n n")
    assert state.page == state.n_pages - 1
    assert state.position == min(2 + (state.n_pages - 1) * PER_PAGE, last)
    keys(state, "Right End Right")
    assert state.position == last
    keys(state, "p p p p")
    assert state.page == 0
    keys(state, "End Ctrl+Home")
    assert state.position == 0


def test_classes(state: BrowserState) -> None:
    keys(state, "comma")
    assert state.patterns.n_sides == 3
    keys(state, ". .")
    assert state.patterns.n_sides == 5
    keys(state, ", " * 20)
    assert state.patterns.n_sides == min(state.classes)


def test_filters_keep_the_selection_if_it_passes(state: BrowserState) -> None:
    keys(state, "+")
    assert state.n_irregular == 0 and state.filters() == "0 irregular"
    assert (state.patterns.n_irregular[state.rows] == 0).all()
    keys(state, "Right plus plus")
    assert state.n_irregular == 2 and state.position == 0
    selected = state.selected
    assert selected is not None and selected.valences == (2, 2)
    keys(state, "c")
    assert state.selected is None and state.filters() == "2 irregular, convex"
    keys(state, "- c +")
    again = state.selected
    assert again is not None and again.id == selected.id
    keys(state, "- - -")
    assert state.n_irregular is None and state.position == 0
    keys(state, "v")
    assert state.valences == (3, 5) and (state.patterns.min_valence[state.rows] >= 3).all()
    keys(state, "v v v v c")
    assert state.valences is None
    assert (state.patterns.n_reflex[state.rows] == 0).all()


def test_filters_that_leave_nothing(state: BrowserState) -> None:
    keys(state, "+ +")
    assert len(state.rows) == 0 and state.n_pages == 1
    assert state.selected is None and state.selected_disk() is None and state.widths == ()
    keys(state, "Right n End ] Up Down r l")
    assert "no pattern passes" in " ".join(
        t.text for t in compose_browser(state, 1376.0, 860.0).texts
    )
    keys(state, "-")
    assert state.selected is not None


def test_widths(state: BrowserState) -> None:
    pattern = state.selected
    assert pattern is not None and pattern.n_quads == 1
    keys(state, "]")
    assert state.chord == 0 and state.widths == (1, 1)
    keys(state, "Up Up bracketright Up")
    assert state.widths == (3, 2) and state.chord == 1
    disk = state.selected_disk()
    assert disk is not None and disk.n_quads == 6
    keys(state, "Down Down Down")
    assert state.widths == (3, 1)
    keys(state, "]")
    assert state.chord is None
    keys(state, "[")
    assert state.chord == 1
    keys(state, "Up " * (MAX_WIDTH + 5))
    assert state.widths == (3, MAX_WIDTH)
    keys(state, "r")
    assert state.widths == (1, 1) and state.chord is None
    keys(state, "Up Right")
    assert set(state.widths) == {1}


def test_an_expansion_that_fails_says_so_and_changes_nothing() -> None:
    def refuse(pattern: Pattern, widths: object) -> Disk:
        raise InvalidBoundaryError("too wide")

    state = BrowserState(SOURCE, n_sides=4, expand=refuse)
    keys(state, "Up")
    assert state.widths == (1, 1) and state.message == "too wide"
    keys(state, "m")
    assert state.message == "" and state.mirrored
    state = BrowserState(SOURCE, n_sides=4)
    keys(state, "Up")
    assert "no expansion" in state.message


def test_the_window_s_own_keys(state: BrowserState) -> None:
    assert KEYS.press(state, "s") is KEYS.press(state, "S") is Effect.PICTURE
    assert KEYS.press(state, "q") is KEYS.press(state, "Q") is Effect.QUIT
    assert KEYS.press(state, "F13") is Effect.NOTHING


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([*sorted(KEYS.actions), "Up", "Right", "n"]), max_size=25))
def test_any_keys_leave_a_state_that_can_be_shown(pressed: list[str]) -> None:
    state = BrowserState(SOURCE, n_sides=4, expand=expand)
    for key in pressed:
        KEYS.press(state, key)
        assert 0 <= state.position < max(len(state.rows), 1)
        assert 0 <= state.page < state.n_pages
        selected = state.selected
        n = 0 if selected is None else selected.n_chords + selected.n_loops
        assert len(state.widths) == n
        assert state.chord is None or 0 <= state.chord < n
    scene = compose_browser(state, 1376.0, 860.0)
    for patch in scene.patches:
        assert np.isfinite(patch.corners).all() and len(patch.corners) == len(patch.colours)


def test_a_page_has_a_caption_for_every_thumbnail(state: BrowserState) -> None:
    keys(state, "n")
    scene = compose_browser(state, 1376.0, 860.0)
    ranks = [str(i) for i in range(21, 41)]
    captions = [t for t in scene.texts if t.align == "center" and t.text.split(" ")[0] in ranks]
    assert len(captions) == PER_PAGE == len({(t.x, t.y) for t in captions})


def test_facts_say_what_is_known(state: BrowserState) -> None:
    keys(state, "l ]")
    texts = [t.text for t in compose_browser(state, 1376.0, 860.0).texts]
    assert state.selected is not None
    assert {"side 3", "4 sides"} <= set(texts)
    assert any(t.startswith(state.selected.name) and "polychord 0: 1 wide" in t for t in texts)
    sheet = FactSheet()
    describe_browser(sheet, state, lambda p: ["cow.obj"])
    assert {state.selected.name, "cow.obj", "4 sides"} <= set(read_sheet(sheet))
    keys(state, "i")
    sheet = FactSheet()
    describe_browser(sheet, state, lambda p: ["cow.obj"])
    assert state.selected.name not in read_sheet(sheet)


def test_a_picture_needs_no_window(tmp_path: Path) -> None:
    path = tmp_path / "browser.png"
    state = browse(
        SOURCE,
        n_sides=4,
        expand=expand,
        off_screen=path,
        keys="Right ] Up l s",
        screenshots=tmp_path,
        window_size=(900, 600),
    )
    assert state.widths == (2, 1, 1)
    from matplotlib.image import imread

    image = np.asarray(imread(path))
    assert image.shape[:2] == (600, 900)
    assert len(np.unique((image.reshape(-1, image.shape[2]) * 255).astype(int), axis=0)) > 100
    assert (image[:4] == 1.0).all(), "the margin is blank"
    assert len(list(tmp_path.glob("pattern-*.png"))) == 1


def test_wrong_wishes_are_refused_before_anything_is_drawn(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no key 'zz'"):
        browse(SOURCE, off_screen=tmp_path / "a.png", keys="n zz")
    with pytest.raises(PictureFormatError):
        browse(SOURCE, off_screen=tmp_path / "a.jpg")
    assert list(tmp_path.iterdir()) == []
