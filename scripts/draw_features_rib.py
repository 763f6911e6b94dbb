"""The panel of a rib in its plane: segments before, the contour after, its normals."""

from __future__ import annotations

import numpy as np
from draw_features_scene import CLEAN, FOUND, MENDED, SKETCHED, Size, write
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from patterndb.geometry.points import Points
from patterndb_sketch.features.ribs import STITCH, segments_of, slice_model
from patterndb_sketch.features.snap import Snap
from viewer import style

#: Dots to an inch of the figure that is drawn, twice as fine as the panel.
DPI = 200

#: Half the width of what is magnified, as a share of the rib's radius.
MAGNIFIED = 0.11

#: Colours of segments, in turn.
TINTS = (CLEAN, "#009e73", "#cc79a7", "#56b4e9", "#7a5195")

#: Normals drawn on a rib, and their length as a share of its radius.
NORMALS, NORMAL = 33, 0.09


def segments_at(found: Snap, number: int) -> list[Points]:
    """The segments (k, 2) of a rib's plane, in its frame."""
    rib = found.ribs[number]
    assert rib is not None
    radius = found.settings.radius * found.model.diagonal
    cut = slice_model(found.model, rib.origin, found.tangents[number], radius)
    pieces = segments_of(cut, STITCH * found.model.diagonal)
    turn = cut.axes[:2] @ rib.axes[:2].T
    return [pieces[i] @ turn for i in range(len(pieces))]


def rib_panel(found: Snap, number: int, size: Size) -> Image.Image:
    """Above, the segments of a rib's plane; below, its contour, normals and the curve; each with
    what is about the curve magnified. Outward is upwards."""
    rib = found.ribs[number]
    assert rib is not None
    radius = found.settings.radius * found.model.diagonal
    outward = (rib.normals @ rib.axes[:2].T).mean(axis=0)
    x, y = outward / np.linalg.norm(outward)
    upright = np.array([[y, x], [-x, y]])

    def flat(points: Points) -> Points:
        return (points - rib.origin) @ rib.axes[:2].T @ upright

    segments = [segment @ upright for segment in segments_at(found, number)]
    contour, samples = flat(rib.polygon), flat(rib.points)
    normals = rib.normals @ rib.axes[:2].T @ upright
    place = flat(found.curve.samples[number][None])[0]

    def before(axes: Axes, scale: float) -> None:
        for k, segment in enumerate(segments):
            tint = TINTS[k % len(TINTS)]
            axes.plot(*segment.T, color=tint, lw=1.8 * scale, solid_capstyle="round")
            axes.plot(*segment[[0, -1]].T, "o", color=tint, ms=3.4 * scale)

    def after(axes: Axes, scale: float) -> None:
        for k in np.linspace(0, len(samples) - 1, NORMALS).astype(int):
            tip = samples[k] + NORMAL * radius * normals[k]
            axes.plot(*np.stack([samples[k], tip]).T, color=SKETCHED, lw=0.7 * scale)
        axes.plot(*contour.T, color=MENDED, lw=2.2 * scale, solid_capstyle="round")
        axes.plot(*place, "o", color=FOUND, ms=6.0 * scale, mec="white", mew=1.0)

    every = np.concatenate([*segments, contour])
    low, high = every.min(axis=0), every.max(axis=0)
    middle, reach = (low + high) / 2.0, 0.56 * float((high - low).max()) + 0.1 * radius
    figure = Figure((size[0] / 100.0, size[1] / 100.0), dpi=DPI)
    canvas = FigureCanvasAgg(figure)
    for bottom, paint in ((0.5, before), (0.0, after)):
        axes = figure.add_axes((0.0, bottom, 0.68, 0.44))
        axes.set_axis_off()
        axes.set_aspect("equal")
        axes.set_xlim(middle[0] - reach, middle[0] + reach)
        axes.set_ylim(middle[1] - 0.65 * reach, middle[1] + 0.65 * reach)
        paint(axes, 1.0)
        axes.plot(0.0, 0.0, "+", color=style.TEXT, ms=9, mew=1.2)
        near = figure.add_axes((0.69, bottom + 0.09, 0.28, 0.28))
        near.set_xticks([])
        near.set_yticks([])
        near.set_xlim(-MAGNIFIED * radius, MAGNIFIED * radius)
        near.set_ylim(-MAGNIFIED * radius, MAGNIFIED * radius)
        for spine in near.spines.values():
            spine.set_color(style.FAINT_TEXT)
            spine.set_linewidth(0.6)
        paint(near, 1.4)
        near.plot(0.0, 0.0, "+", color=style.TEXT, ms=11, mew=1.4)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    image = image.resize(size, Image.Resampling.LANCZOS)
    count = f"{len(segments)} segment{'s' if len(segments) > 1 else ''}"
    write(image, (20, 18), f"before: {count} in the plane of a rib", 14.0)
    write(image, (20, 298), "after: one contour, its normals, and where the curve goes", 14.0)
    return image
