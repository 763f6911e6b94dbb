"""What a window says beside its picture: headings, names with values, sentences, markers."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from patterndb.geometry.points import Points
from viewer import style

#: A marker's outline (k, 2), its colour, the colour of its rim or "none", and what it means.
LegendEntry = tuple[Points, str, str, str]

#: Characters that look like the markers of :mod:`viewer.style`, by the corners of the outline.
SHAPES = {3: "▲", 4: "◆", 5: "⬟", 6: "⬢", 24: "●"}


#: Markers on paper are no lighter than this, as a mean of their red, green and blue.
LIGHTEST = 0.72

#: And those below this are ink, as text is.
DARKEST = 0.2


def darken_pale(colour: str) -> str:
    """Darken a colour that would hardly be seen on paper, where no rim can be drawn around it."""
    rgb = style.parse_colour(colour)
    share = min(1.0, LIGHTEST / max(float(rgb.mean()), LIGHTEST))
    return "#" + "".join(f"{round(255.0 * float(c) * share):02x}" for c in rgb)


class FactSheet:
    """Collects facts, and gives them as HTML."""

    def __init__(self) -> None:
        self._parts: list[str] = []
        self._in_table = False

    def heading(self, text: str, size: float = 13.5) -> None:
        """Write a line in bold."""
        self._end_table()
        tag = "h3" if size > 15.0 else "h4"
        self._parts.append(f'<{tag} style="margin:8px 0 2px 0">{escape(text)}</{tag}>')

    def fact(self, name: str, value: str, *, mono: bool = False) -> None:
        """Write a name and its value."""
        if not self._in_table:
            self._parts.append('<table cellspacing="0" cellpadding="1" width="100%">')
            self._in_table = True
        said = f"<code>{escape(value)}</code>" if mono else escape(value)
        self._parts.append(
            f'<tr><td width="34%" style="padding-right:8px">{escape(name)}</td><td>{said}</td></tr>'
        )

    def paragraph(self, text: str, colour: str) -> None:
        """Write a sentence; the colour of messages makes it stand out."""
        self._end_table()
        strong = colour == style.MESSAGE
        said = f"<b>{escape(text)}</b>" if strong else f"<i>{escape(text)}</i>"
        self._parts.append(f'<p style="margin:2px 0">{said}</p>')

    def legend(self, entries: Sequence[LegendEntry]) -> None:
        """Write what markers mean, several in a line."""
        self._end_table()
        said: list[str] = []
        for shape, face, line, text in entries:
            colour = line if face == style.PAPER and line != "none" else darken_pale(face)
            sign = SHAPES.get(len(np.asarray(shape)), "★")
            if face == style.PAPER:
                sign = {"●": "○", "◆": "◇"}.get(sign, sign)
            # What is all but black has the colour of the text, which a dark window has light.
            if style.parse_colour(colour).mean() > DARKEST:
                sign = f'<span style="color:{colour}">{sign}</span>'
            said.append(f"{sign}&nbsp;{escape(text)}")
        self._parts.append(f'<p style="margin:2px 0">{" &nbsp; ".join(said)}</p>')

    def format_html(self) -> str:
        """Format all that was written."""
        self._end_table()
        return "".join(self._parts)

    def _end_table(self) -> None:
        if self._in_table:
            self._parts.append("</table>")
            self._in_table = False
