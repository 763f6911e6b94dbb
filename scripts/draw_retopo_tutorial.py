"""Draw the pictures of the tutorial of retopology: the stages of the penguin in examples/.

    python scripts/draw_retopo_tutorial.py --data DIR [--db FILE] [--out DIR] [NUMBER ...]

DIR has surfaces/penguin.obj; without NUMBER all pictures are drawn. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.filling import RetopoMesh, find_irregular_vertices, weld_patches
from patterndb_sketch.retopo.filling.fills import filling_of
from patterndb_sketch.retopo.script import Script, script_of

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "examples" / "retopo" / "penguin.tutorial.jsonl"


#: Bytes that a picture may have.
LARGEST_PICTURE = 300_000

#: Pictures are drawn this many times as large, and made smaller.
FINER = 2

SURFACE, CURVE, EDGE, FLOW, PAPER, WORDS = (
    "#d9d5cc", "#1c2a3f", "#6f7886", "#8a3ffc", "#ffffff", "#3a4350",
)  # fmt: skip

#: Colours of patches, so that neighbours differ.
PATCHES = (
    "#f4d6a0", "#a9cdee", "#b9dcb4", "#f3bfd0", "#d5c2e8", "#f0c9a0", "#bfe3e0", "#e9e2a6",
)  # fmt: skip

#: Of irregular vertices by their number of quads, and of others.
VALENCES, OTHER_VALENCE = {3: "#0072b2", 5: "#d55e00"}, "#7a1fa2"

#: In edges: how far quads lie above the surface, curves above them, and how much deeper the
#: surface is drawn below quads, so that it does not come through.
LIFT, ABOVE, SINK = 0.06, 0.22, 0.5

#: Pixels for a caption.
CAPTION = 34

#: Radii in edges.
TUBE, DOT = 0.075, 0.17


@dataclass(frozen=True, slots=True)
class View:
    """A look at the surface: towards the eye, what is up, the middle, half the height shown, and
    how thick curves and dots are, in their usual size."""

    toward: tuple[float, float, float]
    middle: tuple[float, float, float] = (0.03, -0.13, 0.0)
    half: float = 1.56
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    thick: float = 1.0


FRONT = View((-0.45, 0.2, 1.0))
BACK = View((0.5, 0.25, -1.0))
BELOW = View((0.5, -0.6, -0.75), half=1.66)
HIP = View((0.45, -0.15, 0.45), (0.36, -1.1, 0.2), 0.34)

#: The right hip's front, and the line that its edges are to follow in the last of its pictures.
HIP_AT = [0.4, -1.08, 0.28]
HIP_LINE = [[0.24, -1.325, 0.09], [0.3, -1.2, 0.21], [0.38, -1.02, 0.3], [0.45, -0.85, 0.36]]


def stages(path: Path) -> list[tuple[str, Script]]:
    """The parts of a script, each begun by a comment, with their titles."""
    lines = path.read_text(encoding="utf-8").splitlines()
    found: list[tuple[str, list[str]]] = []
    for text in lines[1:]:
        if text.startswith("#"):
            found.append((text[1:].strip(), []))
        elif text.strip():
            found[-1][1].append(text)
    return [(title, script_of([lines[0], *calls])) for title, calls in found if calls]


def play(editor: Retopology, script: Script) -> None:
    """All calls of a part; each must be obeyed."""
    for line in script.lines:
        outcome = editor.do(line.call)
        if outcome.refused is not None:
            sys.exit(f"{line.call.tool}: {outcome.refused}")
        editor.fill()


def colours(editor: Retopology) -> dict[int, str]:
    """A colour for every patch, the first that no neighbour has."""
    network = editor.network
    taken = network.patch_of()
    found: dict[int, str] = {}
    for patch in network.patches.values():
        beside = {taken.get(half ^ 1) for half in patch.loop}
        used = {found[p] for p in beside if p in found}
        # Begun elsewhere for each, so that all colours are used.
        k = patch.id % len(PATCHES)
        order = PATCHES[k:] + PATCHES[:k]
        found[patch.id] = next((c for c in order if c not in used), order[0])
    return found


def picture(
    editor: Retopology, view: View, size: tuple[int, int], *, quads: bool = True
) -> Image.Image:
    """The surface, its quads and its curves."""
    surface, edge = editor.surface, view.thick * editor.sizes.edge
    eye = np.array(view.toward) / np.linalg.norm(view.toward)
    plotter = pv.Plotter(off_screen=True, window_size=[FINER * size[0], FINER * size[1]])
    plotter.set_background(PAPER)  # pyright: ignore[reportCallIssue, reportArgumentType]
    filled = editor.fill()
    mesh = weld_patches(filled)
    at = surface.vertices
    if quads and len(mesh.quads):
        at = at - _depths(mesh, surface, edge)[:, None] * eye
    if not (quads and _closed(mesh)):
        shown = pv.PolyData.from_regular_faces(at, surface.triangles)
        shown.point_data["Normals"] = surface.normals
        plotter.add_mesh(shown, color=SURFACE, smooth_shading=True, ambient=0.28, specular=0.05)
    if quads and len(mesh.quads):
        _quads(plotter, editor, mesh.vertices + LIFT * edge * mesh.normals, eye, edge)
    for chain in editor.network.chains.values():
        line = pv.lines_from_points(chain.round + ABOVE * edge * eye)
        _tube(plotter, line, TUBE * edge, CURVE)
    for node in editor.network.nodes.values():
        ball = pv.Sphere(radius=1.7 * TUBE * edge, center=node.point + ABOVE * edge * eye)
        plotter.add_mesh(ball, color=CURVE, lighting=False)
    for patch in editor.network.patches.values():
        for flow in filling_of(patch).flows:
            line = pv.lines_from_points(flow.points + 1.5 * ABOVE * edge * eye)
            _tube(plotter, line, 0.8 * TUBE * edge, FLOW)
    camera = plotter.camera
    camera.focal_point = view.middle
    camera.position = np.array(view.middle) + 10.0 * eye
    camera.up = view.up
    plotter.enable_parallel_projection()  # pyright: ignore[reportCallIssue]
    camera.parallel_scale = view.half
    camera.clipping_range = (0.1, 30.0)
    image = Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))
    plotter.close()
    return image.resize(size, Image.Resampling.LANCZOS)


def _tube(plotter: pv.Plotter, line: pv.PolyData, radius: float, colour: str) -> None:
    tube = line.tube(radius=radius)
    assert isinstance(tube, pv.PolyData)
    plotter.add_mesh(tube, color=colour, lighting=False)


def _depths(mesh: RetopoMesh, surface: Surface, edge: float) -> NDArray[np.float64]:
    """(v,) how much deeper the surface's vertices are drawn: those that lie below quads."""
    halves = np.concatenate([mesh.quads[:, [0, 1, 2]], mesh.quads[:, [0, 2, 3]]])
    feet = Surface.from_arrays(mesh.vertices, halves).nearest(surface.vertices)
    corner = mesh.vertices[halves[feet.triangles]]
    up = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    away = surface.vertices - feet.points
    far = np.linalg.norm(away, axis=1)
    # Beside quads, not below them, the way to the nearest is along the surface.
    below = np.abs(np.einsum("nc,nc->n", away, surface.normals)) >= 0.7 * far
    below &= (far < edge) & (np.einsum("nc,nc->n", up, surface.normals) > 0.0)
    return np.where(below, SINK * edge + 2.0 * far, 0.0)


def _closed(mesh: RetopoMesh) -> bool:
    """Are there quads on both sides of every edge, so that nothing else is to be seen?"""
    ends = np.stack([mesh.quads, np.roll(mesh.quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    _, uses = np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)
    return len(uses) > 0 and bool((uses == 2).all())


def _quads(
    plotter: pv.Plotter, editor: Retopology, points: Points, eye: Points, edge: float
) -> None:
    """Quads in the colours of their patches, their edges, and irregular vertices; edge: the
    length that these are as large as."""
    mesh = weld_patches(editor.fill())
    colour = colours(editor)
    body = pv.PolyData.from_regular_faces(points, mesh.quads)
    tints = [[int(colour[p][k : k + 2], 16) for k in (1, 3, 5)] for p in mesh.patch.tolist()]
    body.cell_data["tint"] = np.array(tints, np.uint8)
    plotter.add_mesh(
        body, scalars="tint", rgb=True, show_edges=True, edge_color=EDGE,
        line_width=FINER * 0.8, ambient=0.35, specular=0.0,
    )  # fmt: skip
    wrong, valences = find_irregular_vertices(mesh)
    for k, valence in zip(wrong.tolist(), valences.tolist(), strict=True):
        ball = pv.Sphere(radius=DOT * edge, center=points[k] + 1.2 * ABOVE * edge * eye)
        plotter.add_mesh(ball, color=VALENCES.get(valence, OTHER_VALENCE), lighting=False)


def save(path: Path, pictures: Sequence[Image.Image], captions: Sequence[str] = ()) -> None:
    """Pictures of one size side by side, with captions above, in few colours if it is large."""
    width, height = pictures[0].size
    above = CAPTION if captions else 0
    row = Image.new("RGB", (width * len(pictures), height + above), PAPER)
    for k, one in enumerate(pictures):
        row.paste(one, (k * width, above))
    draw = ImageDraw.Draw(row)
    for k, words in enumerate(captions):
        place = ((k + 0.5) * width, above / 2.0)
        draw.text(place, words, fill=WORDS, font=ImageFont.load_default(18), anchor="mm")
    row.save(path, optimize=True)
    if path.stat().st_size > LARGEST_PICTURE:
        few = row.quantize(256, Image.Quantize.MEDIANCUT, kmeans=3, dither=Image.Dither.NONE)
        few.save(path, optimize=True)
    bytes_ = path.stat().st_size
    print(f"{path}: {bytes_:,} bytes")
    if bytes_ > LARGEST_PICTURE:
        sys.exit(f"{path} has over {LARGEST_PICTURE:,} bytes; draw less in it")


def hip(editor: Retopology) -> list[Image.Image]:
    """One patch with fills of its list, and with one that follows a line."""
    before = editor.state
    shown: list[Image.Image] = []
    for call in (
        Call("choose", {"at": HIP_AT, "number": 0}),
        Call("choose", {"at": HIP_AT, "number": 1}),
        Call("choose", {"at": HIP_AT, "number": 2}),
        Call("flow", {"points": HIP_LINE}),
    ):
        editor.restore(before)
        outcome = editor.do(call)
        if outcome.refused is not None:
            sys.exit(f"{call.tool}: {outcome.refused}")
        shown.append(picture(editor, HIP, (292, 330)))
    editor.restore(before)
    return shown


#: After which parts of the script a picture is drawn: how their titles begin.
LIMBS, JOINED, COUNTED = "SurfacePoints", "The underside", "Counts"
TRUNK = "Collar"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("numbers", nargs="*", type=int, metavar="NUMBER", help="1 to 5")
    parser.add_argument("--data", type=Path, required=True, help="surfaces/ is in here")
    parser.add_argument("--db", type=Path, help="the database that quads come from")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    wanted = set(arguments.numbers or range(1, 6))
    surface = Surface.from_polygons(read_mesh(arguments.data / "surfaces" / "penguin.obj")).orient()

    def to(number: int) -> Path:
        return arguments.out / f"retopo-tutorial-{number}.png"

    with patterndb.open(arguments.db) as db:
        editor = Retopology(surface, db)
        for title, script in stages(SCRIPT):
            play(editor, script)
            large = (400, 560)
            if title.startswith(LIMBS) and 1 in wanted:
                curves = picture(editor, FRONT, large, quads=False)
                save(to(1), [curves, picture(editor, FRONT, large), picture(editor, BACK, large)])
            if title.startswith(TRUNK) and 2 in wanted:
                curves = picture(editor, FRONT, large, quads=False)
                save(to(2), [curves, picture(editor, FRONT, large), picture(editor, BACK, large)])
            if title.startswith(JOINED) and 3 in wanted:
                curves = picture(editor, FRONT, large, quads=False)
                save(to(3), [curves, picture(editor, FRONT, large), picture(editor, BELOW, large)])
            if title.startswith(COUNTED) and 4 in wanted:
                save(to(4), hip(editor), ("fill 0", "fill 1", "fill 2", "along a line"))
        if 5 in wanted:
            save(to(5), [picture(editor, v, (400, 560)) for v in (FRONT, BACK, BELOW)])


if __name__ == "__main__":
    main()
