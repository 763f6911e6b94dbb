"""What is drawn in space: off-screen, each thing in its colour at its place."""

from __future__ import annotations

import numpy as np
import pytest

from patterndb.geometry.points import Points
from viewer import style
from viewer.camera import StageLook, View, fit_view
from viewer.picture import make_plotter, paint_drawn
from viewer.scene import Scene
from viewer.stage import (
    MATTE,
    Curves,
    Drawn,
    Faces,
    LayerCache,
    LayerStage,
    Lift,
    LineLook,
    SmoothFaces,
    make_discs,
    make_rings,
)

RED, GREEN, BLUE = "#d00000", "#00a000", "#0000d0"

SIZE = (120.0, 100.0)


def paint(layers: list[object], view: View, texts: bool = False) -> np.ndarray:
    """The pixels (100, 120, 3), 0 to 1, of layers seen from a view."""
    scene = Scene(*SIZE)
    if texts:
        scene.text(60.0, 20.0, "HHHH", 20.0, colour=BLUE, bold=True)
        scene.box(5.0, 80.0, 20.0, 15.0, GREEN, GREEN)
    drawn = Drawn(scene, layers, view, (60.0, 50.0))  # type: ignore[arg-type]
    return paint_drawn([drawn], 100)[0] / 255.0


def is_near(pixel: Points, colour: str, within: float = 0.12) -> bool:
    """Is a pixel of a colour's hue?"""
    wanted = style.parse_colour(colour)
    scale = pixel.max() / wanted.max()
    return bool(np.abs(pixel - scale * wanted).max() < within) and pixel.max() > 0.3


def share(image: np.ndarray, colour: str) -> float:
    """The part of a picture that has a colour's hue."""
    return float(np.mean([is_near(pixel, colour) for pixel in image.reshape(-1, 3)]))


def ball(n: int, radius: float = 1.0) -> tuple[Points, np.ndarray, np.ndarray]:
    """A sphere: points, triangles, and quads of n x 2 n cells."""
    v, u = np.meshgrid(np.linspace(0.02, 0.98, n + 1), np.linspace(0.0, 2.0, 2 * n, False))
    v, u = np.pi * v.ravel(), np.pi * u.ravel()
    points = radius * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), -np.cos(v)], axis=1)
    i, j = np.meshgrid(np.arange(2 * n), np.arange(n), indexing="ij")
    a, b = i * (n + 1) + j, (i + 1) % (2 * n) * (n + 1) + j
    quads = np.stack([a, b, b + 1, a + 1], axis=-1).reshape(-1, 4)
    return points, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]), quads


def test_quads_and_curves_stay_whole_on_a_round_surface() -> None:
    fine, triangles, _ = ball(48)
    coarse, _, quads = ball(6)
    view = fit_view(fine, (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), *SIZE)
    edge = 0.5
    surface = Faces("surface", fine, triangles)
    # Flat quads lie below the sphere, at its outline by most of an edge as it is seen.
    up = coarse
    on = Faces("quads", coarse, quads, GREEN, normals=up, lift=Lift(0.0, 1.0 * edge), sheets=True)
    pairs = coarse[np.stack([quads, np.roll(quads, -1, axis=1)], axis=2)].reshape(-1, 3)
    look = LineLook(RED, 1.5, Lift(0.8, 1.0 * edge))
    lines = Curves("edges", pairs, (2,) * (len(pairs) // 2), look, pairs)
    whole, bare = paint([surface, on, lines], view), paint([on, lines], view)
    # Nothing of the surface comes through quads, and no line is broken.
    green = [
        np.array([[is_near(p, GREEN) for p in row] for row in image]) for image in (whole, bare)
    ]
    assert green[1].sum() > 3000 and (green[1] & ~green[0]).sum() < 0.03 * green[1].sum()
    red = [np.array([[is_near(p, RED) for p in row] for row in image]) for image in (whole, bare)]
    assert red[0].sum() > 300 and (red[0] ^ red[1]).sum() < 0.05 * red[1].sum()


def test_what_lies_behind_is_hidden() -> None:
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    faces = np.array([[0, 1, 2, 3]])
    look = LineLook(RED, 4.0, Lift(2.0))
    line = np.array([[-0.5, 0.0, 0.3], [0.5, 0.0, 0.3]])
    curves = Curves.of("line", [line], look)
    for side, shown in ((1, True), (-1, False)):
        view = View(np.eye(3) * (side, 1, side), np.zeros(3), 40.0)
        image = paint([Faces("wall", square, faces), curves], view)
        assert (share(image, RED) > 0.01) == shown
    # Lines that face away are left out, whatever their lift.
    up = [np.tile([0.0, 0.0, 1.0], (2, 1))]
    away = Curves.of("line", [line], look._replace(lift=Lift(0.0, 9.0)), up)
    view = View(np.eye(3) * (-1, 1, -1), np.zeros(3), 40.0)
    assert len(away.find_joined(view)) == 0 and share(paint([away], view), RED) == 0.0


def test_marks_face_the_viewer_and_flat_things_lie_over_all() -> None:
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    view = fit_view(square, (0.4, 0.2, 1.0), (0.0, 1.0, 0.0), *SIZE).turned(40.0, 20.0)
    places = np.zeros((1, 3))
    disc = make_discs("disc", places, RED, 12.0, Lift(30.0))
    image = paint([Faces("wall", square, np.array([[0, 1, 2, 3]])), disc], view, texts=True)
    x, y = (view.seen(places)[0, :2] + (60.0, 50.0)).round().astype(int).tolist()
    assert is_near(image[99 - y, x], RED)
    assert share(image, RED) == pytest.approx(np.pi * 12.0**2 / 12000.0, rel=0.06)
    assert is_near(image[12, 15], GREEN), "the box"
    assert share(image, BLUE) > 0.01, "the text"
    ring = make_rings("disc", places, RED, (8.0, 12.0), Lift(30.0))
    wanted = np.pi * (12.0**2 - 8.0**2) / 12000.0
    assert share(paint([ring], view), RED) == pytest.approx(wanted, rel=0.25)


def test_dashes_cover_about_half_of_a_line() -> None:
    line = np.array([[0.0, 0, 0], [50, 0, 0], [50, 70, 0]])
    look = LineLook(RED, 2.0, Lift(0.0), 6.0)
    curves = Curves.of("dashes", [line], look, [np.tile([0.0, 0.0, 1.0], (3, 1))])
    assert curves.normals is not None and np.allclose(curves.normals, (0.0, 0.0, 1.0))
    first = curves.find_joined(View(np.eye(3), np.zeros(3), 1.0))
    total = np.linalg.norm(curves.points[first + 1] - curves.points[first], axis=1).sum()
    assert total == pytest.approx(0.55 * 120.0)
    assert Curves.of("short", [line[:2] * 0.01], look).sizes == (2,)
    assert Curves.of("none", [], look).sizes == Curves.of("point", [line[:1]], look).sizes == ()


def test_faces_are_smooth_but_at_creases_whatever_their_sense() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 1], [0, 1, 0], [1, 1, 0], [2, 1, 1]])
    faces = np.array([[0, 1, 4], [0, 4, 3], [1, 5, 2], [1, 4, 5]])
    smooth = SmoothFaces.of(points, faces)
    assert np.allclose(points[smooth.place], smooth.points, atol=1e-6)
    assert len(smooth.points) == 8, "two points at the crease are there twice"
    flat = smooth.points[smooth.faces]
    own = np.cross(flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0])
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    assert np.allclose(smooth.normals[smooth.faces], own[:, None], atol=1e-5)
    assert len({tuple(np.sign(n).astype(int)[2:]) for n in own}) == 1, "all are turned alike"


def test_looks_change_faces_and_nothing_else() -> None:
    fine, triangles, _ = ball(12)
    view = fit_view(fine, (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), *SIZE)
    line = np.array([[0.0, -0.3, 0.0], [0.0, 0.3, 0.0]])
    layers = [
        Faces("ball", fine, triangles, GREEN),
        Curves.of("line", [line], LineLook(RED, 4.0, Lift(2.0))),
    ]
    seen = {}
    for name, look in {
        "studio": StageLook(),
        "matcap": StageLook("matcap"),
        "flat": StageLook("flat"),
        "wire": StageLook(wire=True),
        "x_ray": StageLook(x_ray=True),
        "perspective": StageLook(perspective=True),
        "clip": StageLook(clip=(np.zeros(3), view.axes[2])),
    }.items():
        drawn = Drawn(Scene(*SIZE), layers, view, (60.0, 50.0), look)  # type: ignore[arg-type]
        seen[name] = paint_drawn([drawn], 100)[0] / 255.0
    red = {name: share(image, RED) for name, image in seen.items()}
    assert red["studio"] == red["matcap"] == red["flat"] == 0.0, "the line is within the ball"
    assert min(red["wire"], red["clip"]) > 0.002
    reddish = (seen["x_ray"][..., 0] - seen["studio"][..., 0])[45:55, 55:65]
    assert reddish.max() > 0.1
    covered = {name: float((image.min(axis=2) < 0.97).mean()) for name, image in seen.items()}
    assert covered["wire"] < covered["studio"] == pytest.approx(covered["perspective"], rel=0.1)
    for name in ("matcap", "flat", "wire", "x_ray", "perspective"):
        assert np.abs(seen[name] - seen["studio"]).max() > 0.02, name
    with pytest.raises(ValueError, match="no shading 'oil'; there are studio"):
        StageLook("oil")


def test_a_large_surface_is_coarse_while_it_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("viewer.stage.LARGE", 1000)
    fine, triangles, _ = ball(96)
    view = fit_view(fine, (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), *SIZE)
    drawn = Drawn(Scene(*SIZE), [Faces("ball", fine, triangles)], view, (60.0, 50.0))
    plotter = make_plotter((120, 100))
    try:
        stage = LayerStage(plotter)
        pictures = []
        for turning in (True, False):
            assert stage.show(drawn, turning=turning) is not turning
            plotter.render()
            pictures.append(plotter.screenshot(None, return_img=True) / 255.0)
        assert 0.0 < np.abs(pictures[0] - pictures[1]).mean() < 0.02
        one = plotter.renderer.GetActors().GetNumberOfItems()
        stage.show(drawn)
        assert plotter.renderer.GetActors().GetNumberOfItems() == one, "actors stay"
    finally:
        plotter.close()


def test_what_is_cached_is_the_same() -> None:
    made: list[int] = []

    def make() -> int:
        made.append(1)
        return len(made)

    cache, key = LayerCache(), object()
    assert [cache.get("a", (key, 1.5), make) for _ in range(3)] == [1, 1, 1]
    assert cache.get("a", (key, 2.5), make) == 2 and cache.get("b", (key, 2.5), make) == 3
    assert style.parse_colour(MATTE).min() > 0.9
