"""Templates on models: the membrane, the normals' hits, what is hidden, and the mirror image."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bodies import degrade
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from patterndb.core.polygonmesh import PolygonMesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import FeatureChain, Template, TemplatePart, register
from patterndb_sketch.features.registration.mapping import (
    Hits,
    Lines,
    Membrane,
    find_hits,
    find_normals,
    find_occluded,
    map_membrane,
    measure_shortest_edges,
)
from tests.support.features.models import sphere, together
from tests.support.features.registration import (
    bump,
    car,
    car_curves,
    car_model,
    car_template,
    grid_quads,
    hill,
    laid,
    rim,
    sheet,
)

N = 9
SHEET = sheet(N)
MEMBRANE = Membrane.of(SHEET)


def rim_places(seed: int) -> np.ndarray:
    """(v, 3) random places of feature vertices, nan for the others."""
    places = np.random.default_rng(seed).normal(size=(N * N, 3))
    places[~SHEET.fixed] = np.nan
    return places


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_membrane_has_every_free_vertex_in_the_middle_of_its_neighbours(seed: int) -> None:
    """And feature vertices where they were, to the last bit."""
    features = rim_places(seed)
    points = MEMBRANE.spanned(features)
    assert np.array_equal(points[SHEET.fixed], features[SHEET.fixed])
    grid = points.reshape(N, N, 3)
    mean = (grid[:-2, 1:-1] + grid[2:, 1:-1] + grid[1:-1, :-2] + grid[1:-1, 2:]) / 4.0
    assert grid[1:-1, 1:-1] == pytest.approx(mean, abs=1e-12)


def test_a_membrane_needs_all_its_features() -> None:
    features = rim_places(0)
    features[0, 0] = np.nan
    with pytest.raises(InvalidFeatureError, match="has no place"):
        MEMBRANE.spanned(features)


def test_normals_and_shortest_edges() -> None:
    points, _ = hill(N, height=0.0)
    assert find_normals(points, grid_quads(N)) == pytest.approx(np.tile([0, 0, 1.0], (N * N, 1)))
    points[40, 0] += 0.02
    near = measure_shortest_edges(points, grid_quads(N))
    assert near[40] == near[41] == pytest.approx(1 / (N - 1) - 0.02)
    assert near[0] == pytest.approx(1 / (N - 1))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_of_nested_spheres_the_outer_is_hit(seed: int) -> None:
    """From inside, between and outside them, along normals that point away from the middle;
    from a hollow part the nearer one."""
    rng = np.random.default_rng(seed)
    model = Surface.from_soup(
        PolygonMesh.from_faces(*together(sphere(40, 80, 1.0), sphere(40, 80, 2.0)))
    )
    normals = rng.normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    radius = rng.uniform(0.1, 3.0, 60)
    points = radius[:, None] * normals
    hollow = np.arange(60) % 2 == 1
    lines = Lines(points, normals, np.ones(60, bool), hollow)
    found = find_hits(model, lines, np.full(60, 100.0))
    at = np.linalg.norm(found.points, axis=1)
    # The spheres are polyhedra: within their sagitta.
    assert found.found.all()
    assert at[~hollow] == pytest.approx(np.full(30, 2.0), abs=0.01)
    # A line crosses each sphere twice: the nearest of the four is the near side of one.
    near = np.where(np.abs(radius - 1.0) < np.abs(radius - 2.0), 1.0, 2.0)
    clear = hollow & (np.abs(radius - 1.5) > 0.02)
    assert at[clear] == pytest.approx(near[clear], abs=0.01)
    assert found.doubt == pytest.approx(np.abs(at - radius) / 100.0, abs=1e-9)


def test_without_a_hit_there_is_doubt_alone() -> None:
    model = Surface.from_soup(PolygonMesh.from_faces(*sphere()))
    points = np.array([[5.0, 0, 0], [0.0, 0, 0], [0.0, 0, 0], [0.0, 0, 0.5]])
    normals = np.array([[0.0, 0, 1], [0.0, 0, 0], [0.0, 0, 1], [0.0, 0, 1]])
    lines = Lines(points, normals, np.array([True, True, False, True]), np.zeros(4, bool))
    found = find_hits(model, lines, np.array([1.0, 1.0, 1.0, 0.4]))
    assert found.found.tolist() == [False, False, False, True]
    assert found.trusted.tolist() == [False] * 4
    assert found.doubt.tolist() == [1.0] * 4


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_the_mapping_is_the_constrained_least_squares_of_the_paper(seed: int) -> None:
    """Against the dense system with Lagrange multipliers, whose feature vertices are unknowns."""
    rng = np.random.default_rng(seed)
    features = rim_places(seed)
    v, fixed = N * N, SHEET.fixed
    found = rng.random(v) < 0.7
    doubt = np.where(found, rng.choice([0.0, 0.3, 0.8, 1.0], v), 1.0)
    places = np.where(found[:, None], rng.normal(size=(v, 3)), np.nan)
    result = map_membrane(MEMBRANE, features, Hits(places, found, doubt))
    assert np.array_equal(result[fixed], features[fixed])
    near = SHEET.adjacency().toarray()
    smooth = (np.eye(v) - near / near.sum(axis=1, keepdims=True))[~fixed] * doubt[~fixed, None]
    met = found & ~fixed
    select = np.eye(v)[met] * (1.0 - doubt[met, None])
    a = np.concatenate([smooth, select])
    b = np.concatenate([np.zeros((len(smooth), 3)), (1.0 - doubt[met, None]) * places[met]])
    m = np.eye(v)[fixed]
    kkt = np.block([[a.T @ a, m.T], [m, np.zeros((len(m), len(m)))]])
    both = np.linalg.solve(kkt, np.concatenate([a.T @ b, features[fixed]]))
    assert result == pytest.approx(both[:v], abs=1e-8)


def test_with_doubt_alone_the_mapping_is_the_membrane() -> None:
    features = rim_places(3)
    assert map_membrane(MEMBRANE, features, Hits.nothing(N * N)) == pytest.approx(
        MEMBRANE.spanned(features), abs=1e-10
    )


def test_a_sheet_is_laid_on_a_hill() -> None:
    """One round comes near, more come nearer; feature vertices are on the straight rim."""
    model = Surface.from_soup(PolygonMesh.from_faces(*hill()))
    found = [register(model, rim(), sheet(13), rounds=rounds) for rounds in (1, 4)]
    away = [model.measure_distances(one.points).max() for one in found]
    height = model.measure_distances(found[0].membrane).max()
    assert away[0] < 0.1 * height and away[1] < 5e-3 * height
    for one in found:
        assert one.projected[~one.fixed].all() and not one.notes
        assert np.array_equal(one.points[one.fixed], one.membrane[one.fixed])
        # No half of anything: no mirror image.
        assert len(one.points) == 169


def spiked(at: tuple[float, float], out: float) -> Surface:
    """The hill with a narrow spike, and a strut that is far above and on one side."""
    points, triangles = hill()
    x, y = at
    z = float(bump(np.array(x), np.array(y)))
    low = [[x - 0.03, y - 0.03, z], [x + 0.03, y - 0.03, z], [x, y + 0.04, z], [x, y, z + out]]
    faces = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]])
    return Surface.from_soup(
        PolygonMesh.from_faces(*together((points, triangles), (np.array(low), faces)))
    )


def test_a_spike_like_a_mirror_is_ignored() -> None:
    """Outermost there is the spike, far beyond reach: smoothness bridges it. A vertex's hit
    that is taken at its word would be at the tip."""
    template = sheet(13)
    plain = register(Surface.from_soup(PolygonMesh.from_faces(*hill())), rim(), template)
    vertex = 6 * 13 + 4
    at = (float(plain.points[vertex, 0]), float(plain.points[vertex, 1]))
    model = spiked(at, 0.4)
    found = register(model, rim(), template)
    assert not found.projected[vertex] and plain.projected[vertex]
    assert found.doubt[vertex] == 1.0
    assert found.notes == ("1 of 121 free vertices have a hit too far off to count: "
                           "smoothness alone",)  # fmt: skip
    assert np.abs(found.points - plain.points).max() < 0.01
    assert np.array_equal(found.points[found.fixed], plain.points[plain.fixed])
    # With a reach beyond all reason the spike is believed.
    eager = register(model, rim(), template, delta=50.0)
    assert eager.points[vertex, 2] > 0.3


def test_delta_says_how_far_a_hit_may_be() -> None:
    model = Surface.from_soup(PolygonMesh.from_faces(*hill(height=0.3)))
    template = sheet(13)
    near, far = (register(model, rim(), template, delta=delta) for delta in (1.0, 3.0))
    edge = 1.0 / 12.0
    off = np.abs(0.3 * bump(*near.membrane[:, :2].T) / 0.1)
    free = ~near.fixed
    assert near.doubt[free] == pytest.approx(np.minimum(off / edge, 1.0)[free], abs=0.02)
    assert far.doubt[free] == pytest.approx(np.minimum(off / (3.0 * edge), 1.0)[free], abs=0.02)
    assert far.projected.sum() > near.projected.sum()


def test_what_means_nothing_is_refused() -> None:
    model = Surface.from_soup(PolygonMesh.from_faces(*hill()))
    for change in ({"delta": 0.0}, {"delta": np.nan}, {"rounds": 0}, {"rounds": 21}):
        with pytest.raises(InvalidFeatureError):
            register(model, rim(), SHEET, **change)


def two_sheets(gap: float) -> tuple[Template, np.ndarray]:
    """A plate, and above it a smaller roof to which it yields."""
    chains = SHEET.chains
    above = tuple(
        FeatureChain(f"{c.name} roof", (c.vertices + N * N).astype(np.int32), c.steps)
        for c in chains
    )
    template = Template(
        "two",
        np.concatenate([SHEET.quads, SHEET.quads + N * N]).astype(np.int32),
        (TemplatePart("plate", ("roof",)), TemplatePart("roof")),
        np.repeat(np.arange(2, dtype=np.int32), N * N),
        chains + above,
        np.zeros(2 * N * N, np.bool_),
    )
    flat, _ = hill(N, 0.0)
    return template, np.concatenate([flat, 0.45 * flat + [0.01, 0.01, gap]])


@pytest.mark.parametrize("gap", [0.2, -0.2])
def test_what_a_roof_is_above_is_hidden(gap: float) -> None:
    """Exactly the free vertices under it; the roof itself never is. A sheet behind the plate
    that faces it is a well that the plate spans; one that is turned away is none."""
    template, points = two_sheets(gap)
    normals = find_normals(points, template.quads)
    below = (np.abs(points[:, :2] - 0.01) < 0.225).all(axis=1)
    free = ~template.fixed
    wanted = below & free & (template.of_part == 0)
    assert wanted.sum() == 9
    assert np.array_equal(find_occluded(template, points, normals), wanted)
    if gap < 0.0:
        turned = template.quads.copy()
        turned[template.of_part[turned[:, 0]] == 1] = turned[template.of_part[turned[:, 0]] == 1][
            :, ::-1
        ]
        away = replace(template, quads=turned)
        assert not find_occluded(away, points, normals).any()


def test_of_a_car_the_roof_hides_the_body_and_the_body_spans_the_wells() -> None:
    """Under the roof's footprint and before the wells, not on the hood, the doors or the nose;
    hidden vertices are smoothness' alone."""
    template, found = car_template(), laid()
    half = slice(None, template.n_vertices)
    points, corners = found.membrane[half], car().corners
    body_ = (template.of_part == 1) & ~template.fixed
    hidden = found.occluded[half]
    assert not (hidden & ~body_).any()
    x, z = points[:, 0], points[:, 2]
    top = body_ & (z > corners["nose_top_side"][2] + 0.02)
    front, rear = corners["windscreen_base_centre"][0], corners["rear_window_base_centre"][0]
    inside = (points[:, 1] > corners["a_pillar_base"][1] + 0.1) & (x > front + 0.3)
    inside &= x < rear - 0.3
    assert hidden[top & inside].all() and (top & inside).sum() >= 4
    assert not hidden[body_ & (x < front - 0.05) & (z > 0.4)].any()
    arch = car().car.arch_radius
    side = body_ & (points[:, 1] < -0.6) & (z < 0.5)
    axles = np.minimum(np.hypot(x, z), np.hypot(x - car().car.wheelbase, z))
    assert hidden[side & (axles < arch - 0.05)].all()
    assert not hidden[side & (axles > arch + 0.05)].any()
    assert not found.projected[found.occluded].any()
    assert (found.doubt[found.occluded] == 1.0).all()


def test_the_halves_are_mirror_images_and_welded() -> None:
    """To the last bit; the plane's vertices are there once, at y = 0; the whole has no border
    but the openings, and all of its quads face outwards."""
    template, found = car_template(), laid()
    v = template.n_vertices
    half, image = found.points[:v], found.points[v:]
    assert not half[template.plane, 1].any()
    assert len(image) == v - template.plane.sum()
    assert np.array_equal(image, half[~template.plane] * [1.0, -1.0, 1.0])
    here = {tuple(point) for point in found.points.tolist()}
    assert here == {(x, -y, z) for x, y, z in here}
    directed = np.stack([found.quads, np.roll(found.quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    assert len(np.unique(directed, axis=0)) == len(directed)
    there = {tuple(edge) for edge in directed.tolist()}
    border = {a for a, b in there if (b, a) not in there}
    assert not np.isin(
        list(border), np.flatnonzero(template.plane[:v] & (template.of_part == 1))
    ).any()
    # The body is closed: its volume by the divergence theorem is about that of a car.
    body_part = np.r_[template.of_part, template.of_part[~template.plane]] == 1
    quads = found.quads[body_part[found.quads[:, 0]]]
    a, b, c, d = (found.points[quads[:, k]] for k in range(4))
    volume = (np.einsum("ij,ij->", a, np.cross(b, c)) + np.einsum("ij,ij->", a, np.cross(c, d))) / 6
    box = np.prod(np.ptp(found.points[np.unique(quads)], axis=0))
    assert 0.5 * box < volume < box


def test_a_car_is_laid_on_its_body_though_it_is_torn_and_cluttered() -> None:
    """Feature vertices are the same; roof and body stay near the clean body, mirrors and all."""
    name = "sedan"
    clean = laid(name)
    mess = degrade(
        car(name), 2, uneven=True, cuts=2, gaps=0.004, crossings=0.004, flips=0.5, interior=True,
        exterior=True, shuffle=True,
    )  # fmt: skip
    messy = register(
        Surface.from_soup(PolygonMesh.from_faces(mess.points, mess.triangles)),
        car_curves(name),
        car_template(),
    )
    assert np.array_equal(messy.points[messy.fixed], clean.points[clean.fixed])
    template = car_template()
    skin = np.zeros(len(messy.points), bool)
    skin[: template.n_vertices] = template.of_part < 2
    skin &= ~messy.occluded & ~messy.fixed
    away = car_model(name).measure_distances(messy.points[skin]) / car(name).diagonal
    assert away.mean() < 0.004 and away.max() < 0.02
    before = car_model(name).measure_distances(messy.membrane[skin]) / car(name).diagonal
    assert away.mean() < 0.5 * before.mean()


def test_the_least_squares_of_the_mapping_have_no_smaller_sum() -> None:
    """On a car, by another solver, for one coordinate."""
    template, found = car_template(), laid()
    membrane = Membrane.of(template)
    model = car_model()
    points = found.membrane[: template.n_vertices]
    hidden = found.occluded[: template.n_vertices]
    asked = ~template.fixed & ~hidden
    lines = Lines(points, find_normals(points, template.quads), asked, template.hollow)
    got = find_hits(model, lines, 2.0 * measure_shortest_edges(points, template.quads))
    free, smooth = membrane.free, got.doubt[membrane.free]
    met = np.flatnonzero(got.trusted[free])
    select = np.eye(len(free))[met] * (1.0 - smooth[met])[:, None]
    a = np.concatenate([smooth[:, None] * membrane.inner.toarray(), select])
    pull = smooth[:, None] * membrane.pull(points)
    b = np.concatenate([pull, (1.0 - smooth[met])[:, None] * got.points[free][met]])
    best = lsq_linear(a, b[:, 2]).x
    assert found.points[free, 2] == pytest.approx(best, abs=1e-6)
