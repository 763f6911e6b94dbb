"""Draw the pictures of feature curves of the documentation.

    python scripts/draw_features.py --shared ../shared --out docs/images [NAME ...]

NAME: body, ribs, real, registration; all by default. real and registration draw models that are
not part of this project: --shared has data/cad and data/meshes. Where they are not there, real
is left out, and registration shows a generated body alone. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from draw_features_laid import FRONT_LEFT, stages
from draw_features_rib import rib_panel, segments_at
from draw_features_scene import (
    BOLD,
    CLAY_TURNED,
    CLEAN,
    FOUND,
    MENDED,
    SKETCHED,
    THIN,
    TURNED_KEY,
    Scene,
    key,
    save,
    sheet,
    write,
)
from draw_offscreen import prepare_offscreen
from PIL import Image

from ingest.formats import read_mesh
from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.files.networkjson import read_network, spline_through
from patterndb_sketch.features.files.strokesjson import read_strokes
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.registration import box_template, register
from patterndb_sketch.features.snap import Snap, snap
from patterndb_sketch.features.splines import Spline
from viewer import style

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from bodies import body, degrade, stroke

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples" / "features"

#: What is wrong with the body that strokes are drawn on, and its seed.
MESS = {
    "uneven": True, "cuts": 2, "gaps": 0.001, "crossings": 0.002, "flips": 0.5,
    "interior": True, "exterior": True,
}  # fmt: skip
SEED = 3

#: How far strokes are off at most, as a share of the diagonal.
OFF = 0.01

#: The models of the contact sheet: their files, what they are called, from where they are seen.
REAL: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("audi_chrono", "fastback", (0.75, -1.0, 0.5)),
    ("uazbus_chrono", "bus", (0.95, -1.0, 0.42)),
    ("gclass_chrono", "cross-country car", (0.8, -1.0, 0.48)),
    ("suv_patrol_chrono", "cross-country car", (0.8, -1.0, 0.48)),
    ("hatchback_gazebo", "hatchback", (-1.0, -0.75, 0.5)),
    ("q_car_normalcar1", "saloon", (0.75, -1.0, 0.5)),
)

#: Parts that stand far out of a model and would make it small: what is above this height, in
#: units of the model, is not looked at when it is fitted into its panel.
CROWN = {"gclass_chrono": 1.55}

#: Pixels above a model of the contact sheet, for its name.
HEAD = 60

#: Vertices along the edges of the template, and along the car.
EDGE, ALONG = 15, 37

#: The real body that the template is laid onto.
LAID = "q_car_suv"


@dataclass(frozen=True, slots=True)
class Place:
    """Where models are, None if they are not there, and where pictures go."""

    data: Path | None
    out: Path

    def model(self, name: str) -> Surface:
        """A model of the data. Raises FileNotFoundError if it is not there."""
        assert self.data is not None
        for folder in ("cad", "meshes"):
            path = self.data / folder / f"{name}.obj"
            if path.exists():
                return Surface.from_soup(read_mesh(path))
        raise FileNotFoundError(f"there is no {name}.obj in {self.data}/cad or {self.data}/meshes")


def turned(model: Surface) -> Surface:
    """A car that looks along -y, turned so that it looks along -x, as templates have it."""
    x, y, z = model.vertices.T
    return Surface.from_soup(PolygonMesh.from_faces(np.stack([y, -x, z], axis=1), model.triangles))


def draw_stroke(scene: Scene, model: Surface, clicked: Points) -> None:
    """What was sketched: the points, and in dashes the curve through them on the model."""
    scene.dashed(find_initial_curve(model, clicked).samples)
    scene.dots(clicked)


def draw_body(place: Place) -> None:
    """A generated body with all faults at once: strokes, and the curves recovered from them."""
    made = body("sedan", resolution=1.6)
    mess = degrade(made, SEED, **MESS)  # pyright: ignore[reportArgumentType]
    model = Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles))
    scene = Scene.around((1240, 640), FRONT_LEFT, mess.points[mess.triangles].reshape(-1, 3), 0.03)
    turned_over = mess.flipped[mess.parts]
    scene.solid(mess.points, mess.triangles[~turned_over])
    scene.solid(mess.points, mess.triangles[turned_over], CLAY_TURNED)
    count = 0
    for feature in made.features:
        if feature.kind not in ("crease", "round", "arch") or "inner" in feature.name:
            continue
        if "tub" in feature.name:
            continue
        drawn = stroke(made, feature.name, OFF, SEED)
        draw_stroke(scene, model, drawn)
        scene.curve(snap(model, drawn).spline.sample(300))
        count += 1
    image = scene.image()
    key(image, (28, 26), [
        (SKETCHED, "sketched, up to 1 % of the diagonal off"), (FOUND, "recovered B-spline"),
        (TURNED_KEY, "patches turned inside out"),
    ])  # fmt: skip
    write(
        image, (28, 612), f"{count} curves on {len(mess.triangles):,} triangles in "
        f"{len(mess.flipped)} patches: gaps, crossings, clutter inside and out", 14.0,
        style.FAINT_TEXT,
    )  # fmt: skip
    save(image, place.out / "features-body.png")


def draw_ribs(place: Place) -> None:
    """A curve with its ribs on a body that is torn up to its middle, and one rib in its plane."""
    made = body("sedan", resolution=1.6, whole=True)
    mess = degrade(made, 3, gaps=0.004, crossings=0.005)
    line = made.feature("roof_rail").smooth
    middle = line[len(line) // 2]
    torn, whole = (
        triangles[points[triangles].mean(axis=1)[:, 0] * sign < middle[0] * sign]
        for points, triangles, sign in (
            (mess.points, mess.triangles, 1.0), (made.points, made.triangles, -1.0)
        )
    )  # fmt: skip
    points = np.concatenate([mess.points, made.points])
    triangles = np.concatenate([torn, whole + len(mess.points)])
    model = Surface.from_soup(PolygonMesh.from_faces(points, triangles))
    found = Snap.begin(model, stroke(made, "roof_rail", 0.006, 3))
    scene = Scene((840, 560), (-0.35, -1.0, 0.75), middle - (0.0, 0.0, 0.02), 0.92)
    scene.solid(points, triangles)
    chosen = most_mended(found)
    for number, rib in enumerate(found.ribs):
        if rib is not None:
            colour = MENDED if rib.repaired else CLEAN
            scene.curve(rib.polygon, colour, 1.6 * THIN if number == chosen else 0.7 * THIN)
    draw_stroke(scene, model, found.stroke)
    scene.curve(found.curve.spline.sample(300))
    left = scene.image()
    key(left, (22, 18), [
        (SKETCHED, "sketched"), (FOUND, "recovered"), (CLEAN, "rib"),
        (MENDED, "mended; bold: the one beside"),
    ])  # fmt: skip
    right = rib_panel(found, chosen, (560, 560))
    save(sheet([[left, right]]), place.out / "features-ribs.png")


def most_mended(found: Snap) -> int:
    """The number of the rib that reaches its circle on both sides and has the most segments of
    those that were mended."""
    counts = [
        len(segments_at(found, number))
        if rib is not None and rib.repaired and all(rib.reaches)
        else 0
        for number, rib in enumerate(found.ribs)
    ]
    return int(np.argmax(counts))


def draw_real(place: Place) -> None:
    """A contact sheet of models of vehicles, with strokes and recovered curves."""
    panels: list[Image.Image] = []
    for name, kind, look in REAL:
        model = place.model(name)
        seen = model.vertices[model.vertices[:, 2] < CROWN.get(name, np.inf)]
        scene = Scene.around((640, 424), look, seen, 0.04, HEAD)
        scene.solid(model.vertices, model.triangles, sharp=True)
        strokes = read_strokes(EXAMPLES / f"{name}.strokes.json")
        for one in strokes:
            draw_stroke(scene, model, one.points)
            scene.curve(
                snap(model, one.points, one.settings, closed=one.closed).spline.sample(300),
                radius=1.15 * BOLD,
            )
        image = scene.image()
        # What stands far out of a model would strike its name out.
        image.paste(style.PAPER, (0, 0, image.width, HEAD))
        write(image, (18, 14), name, 15.0, bold=True)
        write(
            image, (18, 36), f"{kind}: {len(model.triangles):,} triangles in {model.n_components} "
            f"parts, {len(strokes)} curves", 13.0, style.FAINT_TEXT,
        )  # fmt: skip
        panels.append(image)
    whole = sheet([panels[k : k + 2] for k in range(0, len(panels), 2)])
    key(whole, (1030, 12), [(SKETCHED, "sketched"), (FOUND, "recovered")])
    save(whole, place.out / "features-real.png")


def draw_registration(place: Place) -> None:
    """Models with their networks, the membranes through those, and the quads on the models."""
    template = box_template(EDGE, ALONG)
    made = body("wagon", resolution=1.6, whole=True)
    curves: dict[str, Spline] = {
        one.name: spline_through(one.smooth) for one in made.features if one.kind != "hidden"
    }
    generated = Surface.from_soup(PolygonMesh.from_faces(made.points, made.triangles))
    rows = [stages(generated, register(generated, curves, template), "a generated body")]
    if place.data is None:
        print("registration: --shared has no data/meshes, so no real model is shown")
    else:
        model = turned(place.model(LAID))
        laid = register(model, read_network(EXAMPLES / f"{LAID}.network.json"), template)
        rows.append(stages(model, laid, LAID))
    save(sheet(rows), place.out / "features-registration.png")


PICTURES: dict[str, Callable[[Place], None]] = {
    "body": draw_body,
    "ribs": draw_ribs,
    "real": draw_real,
    "registration": draw_registration,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in PICTURES]
    if unknown:
        parser.error(f"there is no picture {unknown[0]!r}; there are {', '.join(PICTURES)}")
    prepare_offscreen()
    data = arguments.shared / "data"
    place = Place(data if (data / "meshes").is_dir() else None, arguments.out)
    for name in arguments.names or PICTURES:
        if name == "real" and place.data is None:
            print(f"real: left out, as there is no {data}/meshes; give --shared")
            continue
        PICTURES[name](place)


if __name__ == "__main__":
    main()
