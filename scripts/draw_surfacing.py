"""Draw the pictures of surfaced curve networks of the documentation.

    python scripts/draw_surfacing.py --data DIR [--db FILE] [--out DIR] [NAME ...]

DIR has curves/ (networks of Salvi and of the CASSIE data set) and meshes/spot.obj; without NAME
all pictures are drawn. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.interpolate import CubicSpline

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from patterndb.store import Database
from patterndb_sketch.curvenetwork.drawing import Drawing
from patterndb_sketch.curvenetwork.network import Curve, CurveNetwork, Cycle
from patterndb_sketch.surfacing.methods import SurfaceRequest
from patterndb_sketch.surfacing.networkfile import read_drawing
from patterndb_sketch.surfacing.sampling import Loop
from viewer.picture import save_drawn
from viewer.surfacing import SurfacingState, draw
from viewer.surfacing.commands import KEYS
from viewer.surfacing.picture import compose_surface

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks" / "surfacing"))


#: Bytes that a picture may have.
LARGEST_PICTURE = 200_000

#: Pixels of the picture of the viewer itself.
VIEWER = (1200, 750)

#: Times that the cage of the cow is cut finer to make curves of its edges.
CUT = 2


#: Drawings with patches that are not found.
OPEN = ("01-2-1", "hmd_modern", "monster_head", "10-2-2")

#: Drawings of the CASSIE data set, each with the direction that it is seen from.
SKETCHES = {
    "computer-mouse": (0.6, 0.6, 1.0),
    "vacuum": (0.8, 0.4, 1.0),
    "05-2-1": (0.6, 0.5, 1.0),
    "monster_head": (0.4, 0.2, 1.0),
}
GROWING = ("computer-mouse", (0.6, 0.6, 1.0))


@dataclass(frozen=True, slots=True)
class Place:
    """Where data is and where pictures go."""

    data: Path
    out: Path
    db: Database

    def curves(self, name: str) -> Drawing:
        """A drawing of the data."""
        return read_drawing(self.data / "curves" / name)

    def save(self, name: str, pictures: Sequence[Image.Image], columns: int = 9) -> None:
        """Pictures of one size in rows of so many as one, in few colours if it is large."""
        columns = min(columns, len(pictures))
        width, height = pictures[0].size
        rows = -(-len(pictures) // columns)
        row = Image.new("RGB", (columns * width, rows * height), "white")
        for i, picture in enumerate(pictures):
            row.paste(picture, (i % columns * width, i // columns * height))
        path = self.out / f"surfacing-{name}.png"
        row.save(path, optimize=True)
        if path.stat().st_size > LARGEST_PICTURE:
            row.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
        size = path.stat().st_size
        print(f"{path}: {size:,} bytes")
        if size > LARGEST_PICTURE:
            sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")


def picture(
    source: Drawing | CurveNetwork, size: tuple[int, int], **options: Any
) -> tuple[Image.Image, SurfacingState]:
    """One picture, and the state it is of."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        drawn = {name: options.pop(name) for name in ("keys", "caption") if name in options}
        state = draw(SurfacingState(source, **options), path, size, **drawn)
        with Image.open(path) as image:
            return image.convert("RGB"), state


def network_of_loop(loop: Loop) -> CurveNetwork:
    """One closed curve, and the cycle around it."""
    points = np.concatenate([loop.points, loop.points[:1]])
    return CurveNetwork((Curve(points, (0, 0), 0, 0),), points[:1], (Cycle(((0, False),)),))


def finer(points: Points, faces: list[list[int]]) -> tuple[Points, list[list[int]], dict]:
    """A mesh after a step of Catmull and Clark (1978), and the vertex within every edge.

    The vertices stay the first ones, in their order.
    """
    n = len(points)
    edges = sorted({(min(e), max(e)) for f in faces for e in zip(f, f[1:] + f[:1], strict=True)})
    within = {edge: n + i for i, edge in enumerate(edges)}
    centres = np.array([points[f].mean(axis=0) for f in faces])
    around: dict[tuple[int, int], list[int]] = {edge: [] for edge in edges}
    of_vertex: list[list[int]] = [[] for _ in points]
    for i, f in enumerate(faces):
        for a, b in zip(f, f[1:] + f[:1], strict=True):
            around[min(a, b), max(a, b)].append(i)
            of_vertex[a].append(i)
    middles = np.array([points[list(edge)].mean(axis=0) for edge in edges])
    inner = np.array([len(around[edge]) == 2 for edge in edges])
    on_edges = np.array(
        [(m + centres[around[e]].mean(axis=0)) / 2 if len(around[e]) == 2 else m
         for e, m in zip(edges, middles, strict=True)]
    )  # fmt: skip
    beside: list[list[int]] = [[] for _ in points]
    for i, (a, b) in enumerate(edges):
        beside[a].append(i)
        beside[b].append(i)
    moved = points.copy()
    for v in range(n):
        rim = [i for i in beside[v] if not inner[i]]
        if rim:
            moved[v] = 0.75 * points[v] + 0.25 * middles[rim].mean(axis=0)
            continue
        k = len(of_vertex[v])
        face, edge = centres[of_vertex[v]].mean(axis=0), middles[beside[v]].mean(axis=0)
        moved[v] = (face + 2.0 * edge + (k - 3.0) * points[v]) / k
    cut: list[list[int]] = []
    for i, f in enumerate(faces):
        for before, v, after in zip(f[-1:] + f[:-1], f, f[1:] + f[:1], strict=True):
            ends = within[min(v, after), max(v, after)], within[min(before, v), max(before, v)]
            cut.append([v, ends[0], n + len(edges) + i, ends[1]])
    return np.concatenate([moved, on_edges, centres]), cut, within


def network_of_cage(path: Path) -> CurveNetwork:
    """The edges of a cage as smooth curves, and its faces as cycles."""
    mesh = read_mesh(path)
    faces = [face.tolist() for face in np.split(mesh.corners, mesh.offsets[1:-1])]
    edges = sorted({(min(e), max(e)) for f in faces for e in zip(f, f[1:] + f[:1], strict=True)})
    lines = {edge: list(edge) for edge in edges}
    points, cut = mesh.points, faces
    for _ in range(CUT):
        points, cut, within = finer(points, cut)
        for edge, line in lines.items():
            fine = line[:1]
            for a, b in pairwise(line):
                fine += [within[min(a, b), max(a, b)], b]
            lines[edge] = fine
    number = {edge: i for i, edge in enumerate(edges)}
    curves = tuple(Curve(points[lines[e]], e, i, i) for e, i in number.items())
    cycles = tuple(
        Cycle(
            tuple(
                (number[min(a, b), max(a, b)], a > b) for a, b in zip(f, f[1:] + f[:1], strict=True)
            )
        )
        for f in faces
    )
    return CurveNetwork(curves, points[: len(mesh.points)], cycles)


def viewer(place: Place) -> None:
    """The viewer: a patch that is off, a stroke, and the facts of the patch at the pointer."""
    state = SurfacingState(place.curves("salvi/trebol_network.json"), db=place.db)
    try:
        compose_surface(state, float(VIEWER[0]), float(VIEWER[1]))
        state.settle()
        click(state, (0.0, 110.0))
        KEYS.press(state, "d")
        drag(state, [(-232.0, 216.0), (-150.0, 170.0), (-215.0, 40.0), (-190.0, -12.0)])
        KEYS.press(state, "Escape")
        state.move(230.0, 150.0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.png"
            save_drawn(path, compose_surface(state, float(VIEWER[0]), float(VIEWER[1])), VIEWER[1])
            with Image.open(path) as image:
                place.save("viewer", [image.convert("RGB")])
    finally:
        state.close()


def click(state: SurfacingState, place: tuple[float, float]) -> None:
    """A click at a place of the picture, in points from the middle."""
    state.press(*place)
    state.release(*place)
    state.settle()


def drag(state: SurfacingState, places: Sequence[tuple[float, float]]) -> None:
    """A drag on a smooth way through places of the picture."""
    at = np.arange(len(places))
    way = CubicSpline(at, np.array(places))(np.linspace(0.0, at[-1], 60))
    state.press(*places[0])
    for x, y in way.tolist():
        state.move(x, y)
    state.release(*places[-1])


def quads(place: Place) -> None:
    """The trebol in quads beside its chords."""
    drawing = place.curves("salvi/trebol_network.json")
    chords, _ = picture(
        drawing, (620, 600), settings=SurfaceRequest(method="chords"), caption="chords"
    )
    filled, _ = picture(
        drawing, (620, 600), settings=SurfaceRequest(method="quads"), spacing=1.35, db=place.db,
        keys="e", caption="quads",
    )  # fmt: skip
    place.save("quads", [chords, filled])


def ribbon(place: Place) -> None:
    """A twisted ribbon at three prices of chords."""
    from intended import ribbon as twisted  # pyright: ignore[reportMissingImports]

    network = network_of_loop(twisted(500.0).loop)
    shown = [
        picture(network, (900, 210), settings=SurfaceRequest(method="chords", alpha=alpha),
                caption=f"α = {alpha:g}", spacing=0.1,
                toward=(0.25, -1.0, 0.55), up=(0.0, 0.0, 1.0))[0]
        for alpha in (0.0, 0.2, 0.4)
    ]  # fmt: skip
    place.save("ribbon", shown, columns=1)


def ramp(place: Place) -> None:
    """A spiral ramp at three prices of chords."""
    from intended import helix  # pyright: ignore[reportMissingImports]

    network = network_of_loop(helix(2).loop)
    shown = [
        picture(network, (400, 400), settings=SurfaceRequest(method="chords", alpha=alpha),
                caption=f"α = {alpha:g}", spacing=0.07,
                toward=(0.6, -1.0, 0.75), up=(0.0, 0.0, 1.0))[0]
        for alpha in (0.0, 0.2, 0.4)
    ]  # fmt: skip
    place.save("ramp", shown)


def cow(place: Place) -> None:
    """A cage's edges as curves, every face a cycle."""
    network = network_of_cage(place.data / "meshes" / "spot.obj")
    shown, _ = picture(network, (900, 800), toward=(-0.9, 0.3, 0.8))
    place.save("cow", [shown])


def sketches(place: Place) -> None:
    """Four drawings of the CASSIE data set, their cycles found."""
    shown = [
        picture(place.curves(f"cassie/graph/{name}.json"), (480, 420), toward=toward,
                caption=name)[0]
        for name, toward in SKETCHES.items()
    ]  # fmt: skip
    place.save("sketches", shown, columns=2)


def openings(place: Place) -> None:
    """Four drawings of which parts stay open."""
    shown = [
        picture(place.curves(f"cassie/graph/{name}.json"), (480, 380), caption=name)[0]
        for name in OPEN
    ]
    place.save("open", shown, columns=2)


def fair(place: Place) -> None:
    """A sphere in six patches and the trebol, each patch by itself and faired."""
    at = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    sides = sorted({(min(e), max(e)) for f in faces for e in pairwise([*f, f[0]])})
    shares = np.linspace(0.0, 1.0, 41)[:, None]
    arcs = [(1.0 - shares) * at[a] + shares * at[b] for a, b in sides]
    arcs = [arc / np.linalg.norm(arc, axis=1, keepdims=True) for arc in arcs]
    curves = tuple(
        Curve(arc, ends, i, i) for i, (arc, ends) in enumerate(zip(arcs, sides, strict=True))
    )
    cycles = tuple(
        Cycle(tuple((sides.index((min(e), max(e))), e[0] > e[1]) for e in pairwise([*f, f[0]])))
        for f in faces
    )
    sphere = CurveNetwork(curves, at / np.sqrt(3.0), cycles)
    shown = [
        picture(source, (460, 380), settings=SurfaceRequest(fair=faired), caption=name)[0]
        for source in (sphere, place.curves("salvi/trebol_network.json"))
        for faired, name in ((False, "each by itself"), (True, "faired"))
    ]
    place.save("fair", shown, columns=2)


def growing(place: Place) -> None:
    """A drawing of the CASSIE data set in four of its stages."""
    name, toward = GROWING
    drawing = place.curves(f"cassie/graph/{name}.json")
    shown: list[Image.Image] = []
    n = len(drawing.stages)
    for share in (0.3, 0.5, 0.75, 1.0):
        stage = round(share * n)
        keys = " ".join(["End", *["Left"] * (n - stage)])
        made, state = picture(
            drawing, (360, 260), toward=toward, keys=keys, caption=f"stroke {stage} of {n}"
        )
        shown.append(made)
        print(f"stage {stage} of {n}: {len(state.surfaces.patches)} patches")
    place.save("growing", shown)


PICTURES: dict[str, Callable[[Place], None]] = {
    "viewer": viewer,
    "quads": quads,
    "ribbon": ribbon,
    "ramp": ramp,
    "cow": cow,
    "sketches": sketches,
    "open": openings,
    "fair": fair,
    "growing": growing,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}")
    parser.add_argument("--data", type=Path, required=True, help="curves/ and meshes/ are in here")
    parser.add_argument("--db", type=Path, help="the database that quads come from")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    with patterndb.open(arguments.db) as db:
        for name in arguments.names or PICTURES:
            PICTURES[name](Place(arguments.data, arguments.out, db))


if __name__ == "__main__":
    main()
