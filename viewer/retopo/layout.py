"""Where things stand in the panel: tools in two columns, and the options of the one in use."""

from __future__ import annotations

from viewer.panel import MARGIN, PANEL
from viewer.scene import HEIGHT

#: The list of tools: its first row's middle, the height of a row, and its columns.
FIRST_ROW = HEIGHT - 88.0
ROW = 24.0
COLUMNS = 2

#: From the last tool to the first option, and the height of a row of options.
BETWEEN = 52.0
OPTION = 22.0


def count_mode_rows(count: int) -> int:
    """Count the rows of the list of so many tools."""
    return -(-count // COLUMNS)


def place_mode(left: float, number: int, count: int) -> tuple[float, float, float, float]:
    """Place a tool: its box, (x, y) its lower left, width and height, in points."""
    rows = count_mode_rows(count)
    width = (PANEL - MARGIN) / COLUMNS
    column, row = divmod(number, rows)
    return (
        left + MARGIN / 2.0 + column * width,
        FIRST_ROW - row * ROW - ROW / 2.0 + 1.0,
        width,
        ROW - 2.0,
    )


def place_options(count: int) -> float:
    """Place the options: the middle of their first row."""
    return FIRST_ROW - count_mode_rows(count) * ROW - BETWEEN


def find_mode_number(left: float, x: float, y: float, count: int) -> int | None:
    """Find the tool at a place of the picture."""
    for number in range(count):
        at_x, at_y, width, height = place_mode(left, number, count)
        if at_x <= x < at_x + width and at_y <= y < at_y + height:
            return number
    return None


def find_option_number(left: float, x: float, y: float, count: int, options: int) -> int | None:
    """Find the option at a place of the picture."""
    row = int((place_options(count) + OPTION / 2.0 - y) // OPTION)
    inside = left + MARGIN / 2.0 <= x <= left + PANEL - MARGIN / 2.0
    return row if inside and 0 <= row < options else None
