"""What a window says beside its picture, as plain texts."""

from __future__ import annotations

import re
from html import unescape

from viewer.facts import FactSheet


def read_sheet(sheet: FactSheet) -> list[str]:
    """The texts of a sheet, each by itself."""
    parts = re.split(r"<[^>]+>", sheet.format_html())
    return [text for part in parts if (text := unescape(part).replace("\xa0", " ").strip())]
