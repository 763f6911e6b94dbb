"""Registration: a template laid onto a model along the model's feature curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Bools, Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import DELTA, MAPPING_ROUNDS
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration.frame import check_frame, check_sense
from patterndb_sketch.features.registration.joints import (
    FeatureCurves,
    JoinedFeatures,
    join_features,
)
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
from patterndb_sketch.features.registration.template import Mirroring, Template, sample_features
from patterndb_sketch.features.splines import Spline

#: Rounds of mapping at most.
MOST_ROUNDS = 20


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """A named chain of vertices (n,) int32."""

    name: str
    vertices: Int32Array


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """A template laid onto a model; of a half, with its mirror image.

    points:    (w, 3) float64. quads: (k, 4) int32, counter-clockwise from outside.
    features:  the template's chains; of a half, those of the half that was registered.
    membrane:  (w, 3) float64, where the vertices were before they were mapped.
    fixed:     (w,) bool, feature vertices: exactly on the curves.
    projected: (w,) bool, vertices that a hit on the model has drawn to it.
    occluded:  (w,) bool, vertices that another component hides: the membrane's.
    doubt:     (w,) float64 from 0, the hit alone counts, to 1, smoothness alone; 1 without a
               hit, nan at feature vertices.
    network:   the curves as they were followed.
    notes:     what is not as it might be expected.
    """

    points: Points
    quads: Int32Array
    features: tuple[Feature, ...]
    membrane: Points
    fixed: Bools
    projected: Bools
    occluded: Bools
    doubt: NDArray[np.float64]
    network: JoinedFeatures
    notes: tuple[str, ...]


def register(
    model: Surface,
    drawn: FeatureCurves | Mapping[str, Spline],
    template: Template,
    *,
    delta: float = DELTA,
    rounds: int = MAPPING_ROUNDS,
) -> Registration:
    """The template on a model, along its curves; of a half, mirrored in the plane y = 0.

    drawn:     curves by the names that the template asks for; others are not looked at.
    delta:     how far vertices may go from the membrane, in their shortest edges.
    rounds:    of mapping; each takes the surface of the one before for its membrane.

    Source: feature curve recovery paper, section 5.1. Differs from the paper: see find_hits,
    find_occluded, join_features, and rounds, of which the paper has one. Raises
    InvalidFeatureError for curves that are missing, do not meet, do not lie on the model or are
    those of the other half, and for a delta or rounds that mean nothing.
    """
    if not (np.isfinite(delta) and delta > 0.0):
        raise InvalidFeatureError(f"delta is {delta}; give a number above 0, such as {DELTA:g}")
    if not 1 <= rounds <= MOST_ROUNDS:
        raise InvalidFeatureError(f"rounds are {rounds}; give 1 to {MOST_ROUNDS}")
    if not isinstance(drawn, FeatureCurves):
        drawn = FeatureCurves(drawn)
    joints = template.joints([name for name in template.curves if name in drawn.curves])
    network = join_features(drawn, joints, template.in_plane())
    check_frame(model, [drawn.curves[name] for name in template.curves if name in drawn.curves])
    features, notes = sample_features(template, network)
    membrane, mirroring = prepare_template(template)
    spanned = membrane.spanned(features)
    check_sense(template, spanned)
    fixed = template.fixed
    hidden = find_occluded(template, spanned, find_normals(spanned, template.quads))
    asked = ~fixed & ~hidden
    points, found = spanned, Hits.nothing(len(spanned))
    for _ in range(rounds):
        lines = Lines(points, find_normals(points, template.quads), asked, template.hollow)
        found = find_hits(model, lines, delta * measure_shortest_edges(points, template.quads))
        points = map_membrane(membrane, features, found)
    notes += _notes(found, asked, hidden)
    return Registration(
        mirroring.whole(points),
        mirroring.quads,
        tuple(Feature(chain.name, chain.vertices) for chain in template.chains),
        mirroring.whole(spanned),
        fixed[mirroring.source],
        found.trusted[mirroring.source],
        hidden[mirroring.source],
        np.where(fixed, np.nan, found.doubt)[mirroring.source],
        network,
        notes,
    )


@lru_cache(maxsize=8)
def prepare_template(template: Template) -> tuple[Membrane, Mirroring]:
    """What is the same for every model; kept for the last few templates."""
    return Membrane.of(template), Mirroring.of(template)


def _notes(found: Hits, asked: Bools, hidden: Bools) -> tuple[str, ...]:
    count = int(asked.sum())
    counts = (
        (int((asked & ~found.found).sum()), "have no hit on the model"),
        (int((found.found & ~found.trusted).sum()), "have a hit too far off to count"),
    )
    notes = [f"{n} of {count} free vertices {what}: smoothness alone" for n, what in counts if n]
    if hidden.any():
        notes.append(f"{int(hidden.sum())} vertices are hidden by other components: the membrane's")
    return tuple(notes)
