"""Write the letters that pictures are lettered with: outlines of the DejaVu fonts, as lines.

    python scripts/build_letters.py FOLDER

FOLDER has the fonts (DejaVuSans.ttf and the like, and LICENSE_DEJAVU); without one,
matplotlib's are taken. Needs fontTools, which comes with matplotlib. Writes
viewer/letters/dejavu.npz and the fonts' licence beside it.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
from fontTools.pens.basePen import BasePen
from fontTools.ttLib import TTFont

TARGET = Path(__file__).resolve().parents[1] / "viewer" / "letters"

#: The styles, as viewer.lettering names them, and their files.
STYLES = {
    "sans": "DejaVuSans",
    "sans-bold": "DejaVuSans-Bold",
    "mono": "DejaVuSansMono",
    "mono-bold": "DejaVuSansMono-Bold",
}

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

#: How far a line may stray from its curve, in the fonts' units (2048 to the em): at 30 pixels
#: to the em a twentieth of a pixel.
TOLERANCE = 3.4


class LinePen(BasePen):
    """Collects the contours of a glyph, curves as lines."""

    def __init__(self, glyphs: object) -> None:
        super().__init__(glyphs)
        self.contours: list[list[tuple[float, float]]] = []

    def _moveTo(self, point: tuple[float, float]) -> None:  # noqa: N802 (fontTools' name)
        self.contours.append([point])

    def _lineTo(self, point: tuple[float, float]) -> None:  # noqa: N802
        self.contours[-1].append(point)

    def _qCurveToOne(  # noqa: N802
        self, control: tuple[float, float], end: tuple[float, float]
    ) -> None:
        a, b, c = (np.array(p, float) for p in (self.contours[-1][-1], control, end))
        # A quadratic curve of n pieces strays by |a - 2b + c| / 4n^2 at most.
        n = max(1, int(np.ceil(np.sqrt(np.linalg.norm(a - 2 * b + c) / (4 * TOLERANCE)))))
        for t in np.arange(1, n + 1) / n:
            p = (1 - t) ** 2 * a + 2 * t * (1 - t) * b + t**2 * c
            self.contours[-1].append((float(p[0]), float(p[1])))


def describe_font(path: Path) -> dict[str, np.ndarray]:
    """Describe a font: see viewer.lettering for the arrays."""
    font = TTFont(path)
    assert font["head"].unitsPerEm == 2048
    glyphs, names, metrics = font.getGlyphSet(), font.getBestCmap(), font["hmtx"]
    characters = [0, *(c for c in CHARACTERS if c in names)]
    points: list[tuple[float, float]] = []
    contour_starts, letter_starts, advances = [0], [0], []
    for character in characters:
        name = names[character] if character else ".notdef"
        pen = LinePen(glyphs)
        glyphs[name].draw(pen)
        for contour in pen.contours:
            points += contour[:-1] if contour[0] == contour[-1] else contour
            contour_starts.append(len(points))
        letter_starts.append(len(contour_starts) - 1)
        advances.append(metrics[name][0])
    return {
        "characters": np.array(characters, np.int32),
        "advances": np.array(advances, np.int16),
        "letters": np.array(letter_starts, np.int32),
        "contours": np.array(contour_starts, np.int32),
        "points": np.round(np.array(points)).astype(np.int16),
    }


def main() -> None:
    if len(sys.argv) > 1:
        folder = Path(sys.argv[1])
    else:
        from matplotlib import get_data_path

        folder = Path(get_data_path()) / "fonts" / "ttf"
    arrays = {
        f"{style}/{name}": array
        for style, file in STYLES.items()
        for name, array in describe_font(folder / f"{file}.ttf").items()
    }
    np.savez_compressed(TARGET / "dejavu.npz", **arrays)
    shutil.copy(folder / "LICENSE_DEJAVU", TARGET)


if __name__ == "__main__":
    main()
