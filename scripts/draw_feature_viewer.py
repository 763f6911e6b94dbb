"""Draw the picture of the viewer of feature curves of the documentation.

    python scripts/draw_feature_viewer.py [--out DIR]

The model is a car-like body in the state that models come in: patches that leave gaps or run
through each other. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from viewer.features import FeatureState
from viewer.features.keys import KEYS
from viewer.features.picture import FeaturePainter
from viewer.picture import save_drawn

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import Body, body, degrade, stroke

ROOT = Path(__file__).parents[1]

#: Bytes that a picture may have, and its pixels.
LARGEST_PICTURE = 300_000
SIZE = (1200, 800)

#: The body, and how far its patches end short of their borders or run beyond them, as a share of
#: the diagonal.
CAR, GAPS, CROSSINGS = "fastback", 0.002, 0.002

#: The features that are drawn along, how far off at most, as a share of the diagonal, and the
#: seeds of the strokes.
STROKES = (
    ("roof_rail", 0.008, 1),
    ("a_pillar", 0.008, 2),
    ("front_arch", 0.006, 5),
    ("shoulder", 0.008, 3),
)

#: Where along the last curve it is pulled, and to where, in points of the picture.
PULLED, PULL = 0.335, (2.0, -6.0)


def draw_curve(state: FeatureState, clean: Body, feature: str, error: float, seed: int) -> None:
    """Click along a feature, and give the curve its name."""
    KEYS.press(state, "c")
    for point in stroke(clean, feature, error, seed):
        place = state.camera.view.seen(point)[:2].tolist()
        state.move(*place)
        state.press(*place)
        state.release(*place)
    KEYS.press(state, "Enter")
    state.settle()
    state.editing.rename(feature)


def pull(state: FeatureState) -> None:
    """Pull the selected curve."""
    curve = state.editing.curve
    look = None if curve is None else state.editing.look(curve)
    if look is None:
        sys.exit("no curve to pull")
    begun = state.camera.view.seen(look.line[round(PULLED * len(look.line))])[:2]
    state.move(*begun.tolist())
    state.press(*begun.tolist())
    for share in np.linspace(0.2, 1.0, 5).tolist():
        state.move(*(begun + share * np.array(PULL)).tolist())
    state.release(*(begun + PULL).tolist())
    state.settle()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    out = parser.parse_args().out / "features-viewer.png"
    clean = body(CAR)
    mess = degrade(clean, 4, uneven=True, gaps=GAPS, crossings=CROSSINGS, exterior=True)
    state = FeatureState(Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles)))
    try:
        painter = FeaturePainter()
        painter.compose(state, float(SIZE[0]), float(SIZE[1]))
        for feature, error, seed in STROKES:
            draw_curve(state, clean, feature, error, seed)
        pull(state)
        KEYS.press(state, "r")
        # The pointer on nothing.
        state.move(0.0, 400.0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.png"
            save_drawn(path, painter.compose(state, float(SIZE[0]), float(SIZE[1])), SIZE[1])
            with Image.open(path) as image:
                image.convert("RGB").save(out, optimize=True)
                if out.stat().st_size > LARGEST_PICTURE:
                    few = image.convert("RGB").quantize(256, dither=Image.Dither.FLOYDSTEINBERG)
                    few.save(out, optimize=True)
    finally:
        state.close()
    size = out.stat().st_size
    print(f"{out}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        sys.exit(f"{out} has over {LARGEST_PICTURE:,} bytes; draw less in it")


if __name__ == "__main__":
    main()
