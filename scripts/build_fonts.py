"""Write the fonts that pictures are lettered with: the letters of DejaVu that they may need.

    python scripts/build_fonts.py [FOLDER]

FOLDER has the fonts (DejaVuSans.ttf and the like, and LICENSE_DEJAVU); without one,
matplotlib's are taken. Needs fontTools, which comes with matplotlib. Writes viewer/fonts/*.ttf and
the fonts' licence.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from fontTools.subset import Options, Subsetter
from fontTools.ttLib import TTFont

TARGET = Path(__file__).resolve().parents[1] / "viewer" / "fonts"

FONTS = ("DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono", "DejaVuSansMono-Bold")

#: Latin, Greek and Cyrillic letters, punctuation, and the arrows.
CHARACTERS = (
    *range(0x20, 0x7F),
    *range(0xA0, 0x180),
    *range(0x384, 0x3CF),
    *range(0x400, 0x460),
    *range(0x2010, 0x2027),
    *range(0x2190, 0x2194),
    0x2212,
    0x2248,
    0x2260,
    0x2264,
    0x2265,
)


def write_subset(source: Path, target: Path) -> None:
    """Write a font with CHARACTERS alone, without hints for screens and without ligatures."""
    font = TTFont(source, recalcTimestamp=False)
    options = Options(hinting=False, layout_features=[], notdef_outline=True)
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=CHARACTERS)
    subsetter.subset(font)
    font.save(target)


def main() -> None:
    """Write all of FONTS."""
    if len(sys.argv) > 1:
        folder = Path(sys.argv[1])
    else:
        from matplotlib import get_data_path

        folder = Path(get_data_path()) / "fonts" / "ttf"
    TARGET.mkdir(exist_ok=True)
    for name in FONTS:
        write_subset(folder / f"{name}.ttf", TARGET / f"{name}.ttf")
    shutil.copy(folder / "LICENSE_DEJAVU", TARGET)


if __name__ == "__main__":
    main()
