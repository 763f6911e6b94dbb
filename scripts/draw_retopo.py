"""Draw the surfaces that the scripts of examples/retopo/ retopologise: curves, and quads.

    python scripts/draw_retopo.py --data DIR [--out DIR] [NAME ...]

DIR has surfaces/; NAME is a script's name, such as spot; without one, all that are here are
drawn. Needs no display.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from draw_retopo_tutorial import View, picture, play, save

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.script import read_script

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "examples" / "retopo"

#: Pixels of a panel.
PANEL = (520, 560)

#: How each surface is seen: the curves alone, and the quads from there and from elsewhere.
VIEWS = {
    "spot": (
        View((0.75, 0.3, -0.75), (0.0, 0.12, 0.15), 1.06),
        View((0.75, -0.35, 0.75), (0.0, 0.12, 0.15), 1.06),
    ),
    "hand_closed": (
        View((-0.25, 0.15, 1.0), (-0.05, 0.47, 0.05), 0.53),
        View((0.35, 0.25, -1.0), (-0.05, 0.47, 0.05), 0.53),
    ),
    "boot": (
        View((0.8, 0.45, 0.9), (0.01, 0.088, 0.0), 0.15),
        View((1.0, 0.8, 0.15), (0.022, 0.122, 0.003), 0.055, thick=0.35),
    ),
}

#: What the third panel shows.
OTHER = {"boot": "the laces"}
OTHERWISE = "from the other side"


def draw(name: str, data: Path, out: Path) -> None:
    """Play the script and write its picture."""
    script = read_script(SCRIPTS / f"{name}.jsonl")
    surface = Surface.from_polygons(
        read_mesh(data / "surfaces" / Path(script.surface).name)
    ).orient()
    one, other = VIEWS[name]
    captions = ("curves", "quads", OTHER.get(name, OTHERWISE))
    with patterndb.open() as database:
        editor = Retopology(surface, database)
        play(editor, script)
        panels = [
            picture(editor, one, PANEL, quads=False),
            picture(editor, one, PANEL),
            picture(editor, other, PANEL),
        ]
    save(out / f"retopo-{name.replace('_', '-')}.png", panels, captions)


def main() -> None:
    parser = argparse.ArgumentParser(description="Draws retopologised surfaces.")
    parser.add_argument("names", nargs="*", choices=[[], *VIEWS], metavar="NAME")
    parser.add_argument("--data", type=Path, default=ROOT.parent / "shared" / "data")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    options = parser.parse_args()
    for name in options.names or VIEWS:
        draw(name, options.data, options.out)


if __name__ == "__main__":
    main()
