"""Facts as HTML: what is small and pale is seen on paper all the same."""

from __future__ import annotations

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from viewer import style
from viewer.facts import LIGHTEST, FactSheet, darken_pale
from viewer.retopo.marks import SIDES


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_pale_colours_are_darker_with_their_hue_and_others_as_they_are(
    rgb: tuple[int, int, int],
) -> None:
    given_colour = "#" + "".join(f"{c:02x}" for c in rgb)
    found = style.parse_colour(darken_pale(given_colour))
    old = np.array(rgb) / 255.0
    assert found.mean() <= LIGHTEST + 0.003
    if old.mean() <= LIGHTEST:
        assert darken_pale(given_colour) == given_colour
    else:
        assert np.abs(found / found.max() - old / old.max()).max() < 0.01


def test_every_marker_of_sides_is_seen() -> None:
    sheet = FactSheet()
    sheet.legend([(style.make_diamond(), c, "none", f"{n} sides") for n, c in SIDES.items()])
    drawn = re.findall(r"color:(#[0-9a-f]{6})", sheet.format_html())
    assert len(drawn) == len(SIDES)
    assert all(style.parse_colour(colour).mean() <= LIGHTEST + 0.003 for colour in drawn)


def test_ink_has_the_colour_of_the_text() -> None:
    """On the docks of a dark window, black would be seen as little as white on paper."""
    sheet = FactSheet()
    for ink in (style.BOUNDARY, style.VALENCE_COLOURS[7]):
        sheet.legend([(style.make_diamond(), ink, "none", "said")])
    assert sheet.format_html().count("said") == 2 and "color:" not in sheet.format_html()
