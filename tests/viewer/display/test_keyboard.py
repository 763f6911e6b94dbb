"""What keys do in all windows, on a real display; what was chosen, and what a crash left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.display.hands import Shown, end
from tests.support.display.jobs import JOBS, draw_boundary
from tests.support.display.six_windows import KEEPERS, MAKERS

#: The widget that has the focus of the keyboard, and how it is told apart.
FOCUS = "app.focusWidget()"


@contextmanager
def another(display: dict[str, str], folder: Path, *words: str) -> Iterator[Shown]:
    """A process of its own that shows windows, and goes by the settings of a folder."""
    shown = Shown(display, folder, *words)
    try:
        yield shown
    finally:
        end(shown.process)


@contextmanager
def kept(display: dict[str, str], folder: Path, name: str) -> Iterator[Shown]:
    """A window that keeps what is not saved."""
    with another(display, folder, name, "kept") as shown:
        shown.until("'window' in globals() and window.picture.width() > 100")
        yield shown


#: What was drawn or chosen in each window.
DRAWN = {
    "retopo": "[[c.id, c.points.tolist()] for c in state.network.chains.values()]",
    "features": "[[c.name, c.clicked.tolist()] for c in state.editing.edits.curves]",
    "explore": "[[side.tolist() for side in state.contour.sides], state.contour.lengths]",
    "surface": "[part.tolist() for ink in state.surfaces.edits.inks for part in ink.parts]",
    "shape-model": "state.shaping.choice.coefficients.tolist()",
}


@pytest.mark.parametrize("name", KEEPERS)
def test_what_a_killed_window_had_is_offered_and_opened(
    display: dict[str, str], tmp_path: Path, name: str
) -> None:
    job, session = JOBS[name], tmp_path / JOBS[name].file
    autosave = "window.saver.files.autosave"
    is_kept = (
        f"{autosave}._kept is not {autosave}._saved and "
        f"{autosave}._same({autosave}._kept, window.saver.kept_work())"
    )
    with kept(display, tmp_path, name) as shown:
        shown.until("window.isActiveWindow()")
        job.do(shown)
        shown.until(f"({job.done}) and {is_kept}")
        was = shown.tell(DRAWN[name])
        shown.process.kill()
        shown.process.wait()
    assert len(list(tmp_path.glob("*.recovery"))) == 1
    with kept(display, tmp_path, name) as shown:
        shown.press_button("Open it")
        # The fill that is looked at is no part of what was drawn.
        shown.until("state.finder.placed is not None" if name == "explore" else job.done)
        assert shown.tell(DRAWN[name]) == was
        assert shown.tell("bool(window.saver.would_lose())")
        # The next crash loses nothing either: it goes only once it is saved.
        assert list(tmp_path.glob("*.recovery"))
        shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
        shown.keys("ctrl+s")
        if name != "shape-model":
            # The command line has said where a shape goes.
            shown.name_file(session)
        shown.until("not window.saver.would_lose()")
        assert not list(tmp_path.glob("*.recovery")) and session.stat().st_size > 0
        shown.close_by_manager()
        shown.until("not window.isVisible()")
        shown.finish()


def test_a_key_that_was_chosen_works_and_is_remembered(
    display: dict[str, str], tmp_path: Path
) -> None:
    with another(display, tmp_path) as shown:
        shown.open("browse")
        shown.keys("j")
        assert not shown.tell("state.mirrored")
        shown.keys("ctrl+comma")
        shown.until("getattr(app.activeModalWidget(), 'keys', None) is not None")
        shown.until("app.activeModalWidget().isActiveWindow()")
        place = shown.tell(
            "(lambda d, i: (d.keys.scrollToItem(i), (lambda p: (p.x(), p.y()))"
            "(d.keys.viewport().mapToGlobal(d.keys.visualItemRect(i).center())))[1])"
            "(app.activeModalWidget(), next(app.activeModalWidget().keys.item(r, 1) for r in "
            "range(app.activeModalWidget().keys.rowCount()) if app.activeModalWidget()"
            ".keys.item(r, 1).data(256) == 'mirror'))"
        )
        shown.do("mousemove", *place, "click", 1)
        shown.until("app.activeModalWidget()._chosen() == 'mirror'")
        click_child(shown, "edit")
        shown.keys("j")
        shown.until("app.activeModalWidget().edit.keySequence().toString() == 'J'")
        click_button(shown, "Use")
        shown.until("window.table.bound['mirror'].action.shortcut().toString() == 'J'")
        click_button(shown, "Close")
        shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
        shown.keys("j")
        shown.until("state.mirrored")
        shown.close_by_manager()
        shown.until("not window.isVisible()")
        shown.finish()
    with another(display, tmp_path) as shown:
        shown.open("browse")
        shown.keys("m")
        assert not shown.tell("state.mirrored"), "its own key is free now"
        shown.keys("j")
        shown.until("state.mirrored")
        shown.close_by_manager()
        shown.until("not window.isVisible()")
        shown.finish()


def click_child(shown: Shown, child: str) -> None:
    """Click a widget of the dialog, an attribute of it."""
    place = shown.tell(
        f"(lambda w: (lambda p: (p.x(), p.y()))(w.mapToGlobal(w.rect().center())))"
        f"(app.activeModalWidget().{child})"
    )
    shown.do("mousemove", *place, "click", 1)


def click_button(shown: Shown, text: str) -> None:
    """Click a button of the dialog by its text."""
    place = shown.until(
        "next(((lambda p: (p.x(), p.y()))(b.mapToGlobal(b.rect().center()))"
        " for b in app.activeModalWidget().findChildren(QPushButton)"
        f" if b.text().replace('&', '') == {text!r}), None)"
    )
    shown.do("mousemove", *place, "click", 1)


#: Letters that find one command of each window, and what holds after it was done.
TYPED = {
    "browse": ("mirr", "state.mirrored"),
    "explore": ("draw bound", "state.mode.name == 'CORNERS'"),
    "retopo": ("densit", "state.tool.mode.tool == 'density'"),
    "surface": ("draw", "state.drawing_mode"),
    "features": ("draw cur", "state.editing.clicks is not None"),
    "shape-model": ("mean", "not state.shaping.choice.coefficients.any()"),
}


@pytest.mark.parametrize("name", MAKERS)
def test_any_window_is_used_by_the_keyboard_alone(shown: Shown, name: str) -> None:
    """A command is found by letters; F6 leads into every panel, Tab to each of its controls, and
    F6 back to the picture."""
    shown.open(name)
    letters, done = TYPED[name]
    shown.keys("ctrl+p")
    shown.until("app.activeModalWidget() is not None and app.activeModalWidget().isActiveWindow()")
    shown.do("type", letters)
    shown.until(f"app.activeModalWidget().field.text() == {letters!r}")
    wanted = shown.tell("app.activeModalWidget().list.currentItem().text()")
    assert letters.split()[0] in wanted.lower()
    shown.keys("Return")
    shown.until(f"app.activeModalWidget() is None and window.isActiveWindow() and ({done})")
    picture = "(window.picture.focusProxy() or window.picture)"
    reached: set[int] = set()
    docks = shown.tell("len(window.docks)")
    for number in range(docks):
        shown.tell(f"{picture}.setFocus()")
        shown.keys(*["F6"] * (number + 1))
        dock = f"window.docks[{number}]"
        shown.until(f"{FOCUS} is not None and {dock}.isAncestorOf({FOCUS})")
        seen: list[int] = []
        while (at := shown.tell(f"id({FOCUS})")) not in seen:
            seen.append(at)
            if not shown.tell(f"{dock}.isAncestorOf({FOCUS})"):
                break
            shown.keys("Tab")
        reached |= set(seen)
    missing = shown.tell(
        "[type(w).__name__ + ' ' + w.toolTip() for d in window.docks for k in (QAbstractSlider, "
        "QComboBox, QAbstractSpinBox, QCheckBox, QLineEdit, QAbstractItemView) "
        "for w in d.findChildren(k) if not isinstance(w.parent(), QAbstractSpinBox) "
        "and w.isEnabled() and w.isVisibleTo(d) and not isinstance(w, QScrollBar) "
        f"and id(w) not in {sorted(reached)}]"
    )
    assert not missing
    shown.tell(f"{picture}.setFocus()")
    shown.keys(*["F6"] * docks, "shift+F6", "F6", "F6")
    shown.until(f"{FOCUS} is {picture}")


#: Surface and marks of the legend, as they are on the screen: the lightness of a corner of the
#: picture, and the least and the greatest of the text beside it; 0 to 255.
SEEN = """(lambda picture, text: [picture.pixelColor(3, 3).lightness(), *(
    f(text.pixelColor(x, y).lightness() for x in range(text.width())
      for y in range(0, text.height(), 2)) for f in (min, max))])(
    window.picture.grab().toImage(), window.facts.label.grab().toImage())"""


def test_dark_and_light_are_shown_at_once_everywhere(shown: Shown) -> None:
    """The surface of the picture, panels, and the marks in the text beside it change together."""
    shown.open("explore")
    draw_boundary(shown)
    shown.until("state.finder.placed is not None")
    shown.tell("window.facts.raise_()")
    seen: list[list[int]] = []
    for theme in ("dark", "light", "dark"):
        shown.keys("ctrl+comma")
        shown.until("getattr(app.activeModalWidget(), 'theme', None) is not None")
        shown.until("app.activeModalWidget().isActiveWindow()")
        shown.tell("app.activeModalWidget().theme.setFocus()")
        shown.do("type", theme[0])
        shown.until(f"app.activeModalWidget().theme.currentText() == {theme!r}")
        click_button(shown, "Close")
        shown.until("app.activeModalWidget() is None and window.isActiveWindow()")
        surface = "180" if theme == "dark" else "255"
        shown.until(f"abs(({SEEN})[0] - {surface}) < 12")
        seen.append(shown.tell(SEEN))
    dark, light, again = (one[1:] for one in seen)
    assert dark == again
    # Ink on paper, and light letters and marks on a dark surface.
    assert light[0] < 60 and light[1] > 230
    assert dark[0] < 60 and dark[1] > 200
