"""Curves snapped on models of real vehicles, and a template laid onto cars of one pack.

    python benchmarks/feature_real.py --shared ../shared [--soup]
    python benchmarks/feature_real.py --frames      (what becomes of models in a wrong frame)

Strokes and networks are those of examples/features/; the models are not part of this project:
--shared has data/cad and data/meshes, models without a file there are left out and named.
Strokes are drawn by hand, so there is no true curve to compare with. "moved" is the mean
distance of a curve from its stroke, in thousandths of the diagonal; "off" how far the spline is
from the model on the mean, in the same. --soup: are curves the same, bit for bit, on the model
as a shuffled soup of triangles that are turned either way? Times are medians of curves, after a
first one that compiles. Prints Markdown.
"""

from __future__ import annotations

import argparse
import re
import statistics
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.networkjson import read_network
from patterndb_sketch.features.files.strokesjson import read_strokes
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.registration import (
    FeatureCurves,
    Registration,
    box_template,
    register,
)
from patterndb_sketch.features.registration.frame import Turn
from patterndb_sketch.features.shapemodel import ShapeModel
from patterndb_sketch.features.snap import FeatureCurve, snap
from patterndb_sketch.features.splines import Spline
from patterndb_sketch.features.strokes import FeatureStroke

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples" / "features"
STROKES, NETWORK = ".strokes.json", ".network.json"

#: Samples of a curve whose distances are measured.
DENSE = 801

#: Vertices along the edges of the template.
EDGE = 11


def mesh_path(data: Path, name: str) -> Path | None:
    """Where a model is, None if it is not there."""
    found = [data / folder / f"{name}.obj" for folder in ("cad", "meshes")]
    return next((path for path in found if path.exists()), None)


def soup_of(model: Surface, seed: int = 1) -> Surface:
    """The same triangles, each with points of its own, in another order and sense."""
    rng = np.random.default_rng(seed)
    corners = model.corners[rng.permutation(len(model.corners))]
    corners = np.take_along_axis(
        corners, rng.permuted(np.tile(np.arange(3), (len(corners), 1)), axis=1)[..., None], axis=1
    )
    return Surface.from_soup(
        PolygonMesh.from_faces(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    )


def snapped(
    model: Surface, strokes: tuple[FeatureStroke, ...]
) -> tuple[list[FeatureCurve], list[float]]:
    """The curves, and the seconds that each took."""
    curves: list[FeatureCurve] = []
    seconds: list[float] = []
    for one in strokes:
        start = time.perf_counter()
        curves.append(snap(model, one.points, one.settings, closed=one.closed))
        seconds.append(time.perf_counter() - start)
    return curves, seconds


def row(name: str, model: Surface, strokes: tuple[FeatureStroke, ...], soup: bool) -> str:
    curves, seconds = snapped(model, strokes)
    ribs = sum(len(curve.samples) for curve in curves)
    mended = sum(len(curve.repaired) for curve in curves)
    failed = sum(len(curve.failed) for curve in curves)
    moved: list[float] = []
    off: list[float] = []
    for one, curve in zip(strokes, curves, strict=True):
        along = curve.spline.sample(DENSE)
        sketch = find_initial_curve(model, one.points, closed=one.closed).samples
        moved.append(float(KDTree(along).query(sketch)[0].mean()) / model.diagonal)
        off.append(float(model.measure_distances(along).mean()) / model.diagonal)
    same = "-"
    if soup:
        others = snapped(soup_of(model), strokes)[0]
        alike = [
            np.array_equal(one.spline.control, other.spline.control)
            for one, other in zip(curves, others, strict=True)
        ]
        same = f"{sum(alike)} of {len(alike)}"
    return (
        f"| {name} | {len(model.triangles):,} | {model.n_components} | {len(strokes)} | {ribs} | "
        f"{mended / ribs:.0%} | {failed / ribs:.1%} | {1e3 * statistics.mean(moved):.1f} | "
        f"{1e3 * statistics.mean(off):.2f} | {sum(len(c.notes) for c in curves)} | "
        f"{1e3 * statistics.median(seconds):.0f} | {1e3 * max(seconds):.0f} | {same} |"
    )


def strokes_table(data: Path, soup: bool) -> None:
    print(
        "| model | triangles | parts | curves | ribs | mended | failed | moved | off | notes | "
        "ms per curve | slowest, ms | same on the soup |"
    )
    print("|---|" + "---:|" * 12)
    for path in sorted(EXAMPLES.glob(f"*{STROKES}")):
        name = path.name.removesuffix(STROKES)
        mesh = mesh_path(data, name)
        if mesh is None:
            print(f"{name} is left out: it is not in {data}", file=sys.stderr)
            continue
        model, strokes = Surface.from_soup(read_mesh(mesh)), read_strokes(path)
        # The first use loads modules.
        snap(model, strokes[0].points, strokes[0].settings)
        print(row(name, model, strokes, soup), flush=True)


def registrations_table(data: Path) -> None:
    template = box_template(EDGE)
    laid: dict[str, Registration] = {}
    print(f"\nTemplate {template.name}:\n")
    print("| model | curves | widest gap | drawn to the model | hidden | smoothness alone | s |")
    print("|---|" + "---:|" * 6)
    for path in sorted(EXAMPLES.glob(f"*{NETWORK}")):
        name = path.name.removesuffix(NETWORK)
        mesh = mesh_path(data, name)
        if mesh is None:
            print(f"{name} is left out: it is not in {data}", file=sys.stderr)
            continue
        # These cars look along -y; a template is of one that looks along -x.
        whole = Surface.from_soup(read_mesh(mesh))
        x, y, z = whole.points.T
        model = Surface.from_soup(
            PolygonMesh.from_faces(np.stack([y, -x, z], axis=1), whole.triangles)
        )
        network = read_network(path)
        start = time.perf_counter()
        laid[name] = one = register(model, network, template)
        seconds = time.perf_counter() - start
        free = ~one.fixed
        alone = (free & ~one.projected & ~one.occluded).sum()
        gap = 1e3 * max(one.network.gaps.values()) / model.diagonal
        drawn, hidden = one.projected.sum() / free.sum(), one.occluded.sum() / free.sum()
        print(
            f"| {name} | {len(network.curves)} | {gap:.1f} | {drawn:.0%} | {hidden:.0%} | "
            f"{alone / free.sum():.1%} | {seconds:.2f} |",
            flush=True,
        )
    if len(laid) > 1:
        shapes = ShapeModel.from_registrations(list(laid.values()), names=list(laid))
        shares = ", ".join(f"{share:.1%}" for share in shapes.shares)
        print(f"\nShape model of {len(laid)} cars: its modes have {shares} of the variance.")
    print("\nGaps in thousandths of the diagonal; shares are of the vertices off the curves.")


def wrong_frames(
    model: Surface, network: FeatureCurves
) -> Iterator[tuple[str, Surface, FeatureCurves]]:
    """A model and its network, right and wrong in every way that frames are."""

    def moved(change: Callable[[Points], Points]) -> Surface:
        return Surface.from_soup(PolygonMesh.from_faces(change(model.vertices), model.triangles))

    yield "right", model, network
    for axis, name in enumerate("xyz"):
        for quarters in (1, 2, 3):
            turn = Rotation.from_rotvec(np.pi / 2.0 * quarters * np.eye(3)[axis]).as_matrix()
            yield f"{90 * quarters} degrees about {name}", moved(lambda p, t=turn: p @ t.T), network
    for title, scale in (
        ("in millimetres", 1e3),
        ("in centimetres, curves in metres", 100.0),
        ("in inches", 1.0 / 0.0254),
        ("in metres, curves in millimetres", 1e-3),
        ("twice as large", 2.0),
        ("half as large", 0.5),
        ("a tenth larger", 1.1),
        ("a twentieth larger", 1.05),
    ):
        yield title, moved(lambda p, s=scale: p * s), network
    for axis, title in enumerate(("nose to tail", "left to right", "upside down")):
        sign = np.where(np.arange(3) == axis, -1.0, 1.0)
        yield f"mirrored, {title}", moved(lambda p, s=sign: p * s), network
    side = np.array([1.0, -1.0, 1.0])
    curves = {
        name: Spline(one.degree, one.knots, one.control * side, one.closed)
        for name, one in network.curves.items()
    }
    near = {name: at * side for name, at in network.near.items()}
    yield "curves of the other half", model, replace(network, curves=curves, near=near)


def frames_table(data: Path) -> None:
    """What register says of cars in wrong frames, and of how many."""
    template = box_template(EDGE)
    said: dict[str, Counter[str]] = {}
    for path in sorted(EXAMPLES.glob(f"*{NETWORK}")):
        mesh = mesh_path(data, path.name.removesuffix(NETWORK))
        if mesh is None:
            continue
        # These cars look along -y; a template is of one that looks along -x.
        model = Turn.parse("y,-x,z").turn_model(Surface.from_soup(read_mesh(mesh)))
        for title, other, network in wrong_frames(model, read_network(path)):
            try:
                register(other, network, template)
                answer = "laid"
            except InvalidFeatureError as error:
                answer = f"refused: {str(error).rpartition('; ')[2]}"
            said.setdefault(title, Counter())[re.sub(r" it (is|would be) \d+%", "", answer)] += 1
    print("| frame | of so many cars | what is said |\n|---|---:|---|")
    for title, answers in said.items():
        for answer, count in answers.items():
            print(f"| {title} | {count} | {answer} |")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--soup", action="store_true", help="snap on a shuffled soup, too")
    parser.add_argument("--frames", action="store_true", help="lay models in wrong frames alone")
    arguments = parser.parse_args()
    data = arguments.shared / "data"
    if not data.is_dir():
        parser.error(f"there is no {data}; give --shared, a folder with data/cad and data/meshes")
    if arguments.frames:
        frames_table(data)
        return
    strokes_table(data, arguments.soup)
    registrations_table(data)


if __name__ == "__main__":
    main()
