"""Windows that show another file: by the menu, or dropped on them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import patterndb
from ingest import ingest
from patterndb.store import LearningOptions
from patterndb_app.cli.options import read_model
from patterndb_sketch.features.session import FeatureSession
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.surfacing import read_drawing
from tests.support.shared import CHECKOUT
from tests.support.viewer.events import Events
from viewer import browse
from viewer.features import show as show_features
from viewer.surfacing import SurfacingState
from viewer.surfacing import show as show_surface

EXAMPLES = CHECKOUT / "examples"

#: Of a window that is open: what to do with it.
Act = Callable[[Any], None]


@pytest.fixture
def act_in_window(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Act], None]:
    """Have the next window be made here, and something done in it before it closes."""

    def have(act: Act) -> None:
        def open_here(
            saver: Any, pressed: object, title: str, kind: Any, opener: Any = None
        ) -> Any:
            events = Events(saver, tmp_path, kind, opener=opener)
            try:
                act(events.window)
                events.work()
                return events.window.saver
            finally:
                events.close()

        monkeypatch.setattr("viewer.shell.opening.open_window", open_here)
        monkeypatch.setattr("viewer.shell.probe.check_display", lambda: None)

    return have


def open_two(first: Path, second: Path, seen: Callable[[Any], object]) -> tuple[Act, list[object]]:
    """An act that opens a file that is not there, and another, and what is seen after each."""
    told: list[object] = []

    def act(window: Any) -> None:
        told.append(seen(window.saver.state))
        assert not window.open_file(first.with_name("missing"))
        assert window.saver.state.message and seen(window.saver.state) == told[0]
        assert window.open_file(second)
        window.refresh()
        told.append(seen(window.saver.state))
        assert second.name in window.windowTitle()

    return act, told


def test_a_model_is_opened_in_place_of_another(act_in_window: Callable[[Act], None]) -> None:
    jug, dog = EXAMPLES / "jug.obj", EXAMPLES / "dog.obj"
    act, told = open_two(jug, dog, lambda state: len(state.editing.model.triangles))
    act_in_window(act)
    state = show_features(
        read_model(jug),
        title="jug",
        session=FeatureSession("jug.obj"),
        session_path=None,
        settings=SnapSettings(),
        open_file=read_model,
    )
    models = [len(read_model(path).triangles) for path in (jug, dog)]
    assert told == models and len(state.editing.model.triangles) == models[1]


def test_a_network_is_opened_in_place_of_another(
    act_in_window: Callable[[Act], None], tmp_path: Path
) -> None:
    cup = EXAMPLES / "networks" / "teacup.json"
    other = tmp_path / "pane.json"
    other.write_text(
        '{"curves": [{"id": "a", "points": [[0,0,0],[1,0,0],[1,1,0]]},'
        ' {"id": "b", "points": [[1,1,0],[0,1,0],[0,0,0]]}]}'
    )

    def count(state: Any) -> int:
        return len(state.surfaces.edits.drawing.network.curves)

    act, told = open_two(cup, other, count)
    act_in_window(act)
    state = show_surface(
        SurfacingState(read_drawing(cup)), open_file=lambda path: SurfacingState(read_drawing(path))
    )
    assert told == [len(read_drawing(cup).network.curves), 2] and count(state) == 2


def test_a_database_is_opened_in_place_of_another(
    act_in_window: Callable[[Act], None], tmp_path: Path
) -> None:
    paths = [tmp_path / "jug.db", tmp_path / "dog.db"]
    for path in paths:
        with patterndb.open(path, "create") as database:
            small = LearningOptions(basic=3 + paths.index(path), side=0, convex=0)
            ingest(database, [EXAMPLES / f"{path.stem}.obj"], small)

    def read(path: Path) -> Any:
        database = patterndb.open(path)
        return database, lambda pattern: [one.mesh for one in database.occurrences(pattern)]

    first, known = read(paths[0])
    act, told = open_two(*paths, lambda state: (state.classes, len(state.patterns)))
    act_in_window(act)
    state = browse(first, meshes=known, open_file=read)
    assert told[0] != told[1] and state.classes == sorted(read(paths[1])[0].sides_histogram())
