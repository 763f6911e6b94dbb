"""Fills of a boundary explored without a window: an odd perimeter, other fills, steps back."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from patterndb_sketch import fillfinder
from patterndb_sketch.exploration import Exploration
from query import Stroke
from query.contour import make_flat_boundary
from tests.support.viewer.domed import SOURCE


@pytest.fixture
def exploration() -> Iterator[Exploration]:
    made = Exploration(SOURCE, make_flat_boundary((4, 3, 4, 3)))
    yield made
    made.finder.close()


def test_an_odd_perimeter_is_made_even_and_that_is_a_step(exploration: Exploration) -> None:
    exploration.finder.settle(0)
    assert exploration.list_even_lengths() == []
    exploration.choose_length(0, 5)
    exploration.keep_step()
    offered = exploration.list_even_lengths()
    assert (0, 4) in offered and (1, 2) in offered
    exploration.choose_length(*offered[0])
    exploration.keep_step()
    exploration.finder.settle(0)
    assert exploration.contour is not None and sum(exploration.contour.lengths) % 2 == 0
    assert exploration.undo() and exploration.undo() and not exploration.undo()
    assert exploration.contour.lengths == (4, 3, 4, 3)
    assert exploration.finder.message == "there is nothing to take back"
    assert exploration.redo() and sum(exploration.contour.lengths) % 2 == 1


def test_strokes_choices_and_boundaries_are_kept_together(exploration: Exploration) -> None:
    exploration.add_stroke(Stroke((0, 1), (2, 2)))
    exploration.finder.toggle_folded()
    exploration.keep_step()
    exploration.finder.settle(0)
    step = exploration.steps.now
    assert len(step.strokes) == 1 and not step.choices.folded and exploration.drawn_here
    exploration.scale_lengths(2.0)
    assert exploration.contour is not None and sum(exploration.contour.lengths) > 20
    exploration.take_work(step)
    assert exploration.contour.lengths == (4, 3, 4, 3) and len(exploration.finder.strokes) == 1


def test_placed_fills_that_are_kept_have_few_quads(
    exploration: Exploration, monkeypatch: pytest.MonkeyPatch
) -> None:
    finder = exploration.finder
    finder.settle()
    assert len(finder.fills) > 3
    monkeypatch.setattr(fillfinder, "KEPT_QUADS", 2 * max(f.n_quads for f in finder.fills))
    for rank in range(len(finder.fills)):
        finder.look_at(rank)
        finder.settle(rank)
        assert finder.placed is not None and finder.placed.net is None
        kept = [future.result().fill for future in finder._placer._placed.values()]
        assert sum(fill.n_quads for fill in kept) <= fillfinder.KEPT_QUADS
