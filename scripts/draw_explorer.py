"""Draw the fill explorer's pictures of the documentation, on meshes of examples/.

    python scripts/draw_explorer.py [--db FILE] [--out DIR]

Without --db the starter database is asked. Boundaries and strokes are drawn as a person would
draw them: clicks and drags at places of the picture.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import patterndb
from ingest.formats import read_mesh
from patterndb.store import Database
from query.contour import make_flat_boundary
from query.placing import Surface
from viewer.camera import FILLED, fit_view
from viewer.explorer_commands import KEYS
from viewer.explorer_picture import compose_explorer
from viewer.explorer_state import ExplorerState
from viewer.picture import save_drawn

ROOT = Path(__file__).parents[1]

#: Pixels of a picture, and bytes that it may have.
SIZE = (1200, 750)
LARGEST_PICTURE = 300_000

#: Times that the surfaces, which are coarse, are cut finer and smoothed.
SMOOTHED = 2

Places = Sequence[tuple[float, float]]


def smooth(path: Path) -> Surface:
    """An example mesh as a smooth surface: Loop subdivision of its triangles."""
    import trimesh

    coarse = Surface.from_polygons(read_mesh(path))
    vertices, triangles = trimesh.remesh.subdivide_loop(
        coarse.vertices, coarse.triangles, iterations=SMOOTHED
    )
    return Surface.from_arrays(vertices, triangles)


@contextlib.contextmanager
def looking(
    db: Database, surface: Surface, toward: Sequence[float], radius: float
) -> Iterator[ExplorerState]:
    """An explorer that sees a surface from a direction."""
    state = ExplorerState(db, surface=surface)
    size = 2.0 * radius / FILLED
    try:
        state.camera.view = fit_view(surface.vertices, toward, (0.0, 1.0, 0.0), size, size)
        yield state
    finally:
        state.close()


def click(state: ExplorerState, places: Places) -> None:
    """Draw a boundary."""
    KEYS.press(state, "b")
    for place in places:
        state.press(*place)
        state.release(*place)
    KEYS.press(state, "Enter")
    assert state.finder.boundary is not None, state.message


def drag(state: ExplorerState, key: str, places: Places) -> None:
    """Draw a stroke."""
    before = len(state.finder.strokes)
    KEYS.press(state, key)
    state.press(*places[0])
    fine = np.linspace(0.0, len(places) - 1.0, 12 * len(places))
    at = np.arange(len(places))
    ways: NDArray[np.float64] = np.array(places, np.float64)
    for x, y in zip(np.interp(fine, at, ways[:, 0]), np.interp(fine, at, ways[:, 1]), strict=True):
        state.move(float(x), float(y))
    state.release(*places[-1])
    assert len(state.finder.strokes) == before + 1, state.message


def save(state: ExplorerState, path: Path, rank: int = 1) -> None:
    """The picture of a fill, when all are found."""
    state.settle(rank - 1)
    state.settle()
    state.camera.pointer = None
    save_drawn(path, compose_explorer(state, float(SIZE[0]), float(SIZE[1])), SIZE[1])
    size = path.stat().st_size
    print(f"{path}: {size:,} bytes")
    if size > LARGEST_PICTURE:
        sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--db", type=Path, help="the database to ask")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    out: Path = arguments.out
    head = smooth(ROOT / "examples" / "head.obj")
    with patterndb.open(arguments.db) as db:
        with looking(db, head, (0.85, 0.05, 1.0), 370.0) as state:
            state.camera.view = state.camera.view.zoomed(2.0, 40.0, -70.0)
            click(state, [(-70, -200), (120, -215), (215, 20), (110, 105), (-80, 30)])
            drag(state, "s", [(-82, -80), (60, -95), (172, -90)])
            save(state, out / "explorer-cheek.png", 2)
        with looking(db, smooth(ROOT / "examples" / "jug.obj"), (0.2, -1.0, 0.35), 330.0) as state:
            click(state, [(-120, -160), (90, -160), (100, 120), (-30, 120), (-30, 0), (-130, 0)])
            KEYS.press(state, "]")
            save(state, out / "explorer-reflex.png", 2)
        state = ExplorerState(db, make_flat_boundary((5, 4, 6, 5, 6)))
        try:
            turn = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
            ring = [(130.0 * np.cos(t), 130.0 * np.sin(t) - 20.0) for t in turn.tolist()]
            drag(state, "l", ring)
            save(state, out / "explorer-loop.png", 5)
        finally:
            state.close()


if __name__ == "__main__":
    main()
