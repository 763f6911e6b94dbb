"""Snapping: a sketched curve moves to the feature beside it.

A curve (Snap) with the ribs about it is cut at the feature; SnapSettings say what draws it there
and how stiff it is, a FeatureCurve is what comes of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points, as_points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.defaults import (
    ALPHA,
    AXES,
    AXIS,
    BETA,
    DEGREE,
    RADIUS,
    SNAP_ROUNDS,
    STIFFNESS,
)
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.fishbone import (
    Fishbone,
    Terms,
    compare_with_pins,
    cut,
    find_held_rows,
    find_moves,
    find_reach,
    find_terms,
    move_with_pins,
    settle_on_crease,
    synchronise,
    tau,
    track_crease,
    weigh_creases,
)
from patterndb_sketch.features.fishbone.cut import hold_rows
from patterndb_sketch.features.initial import find_initial_curve
from patterndb_sketch.features.ribs import SAMPLES, STITCH, Rib, build_ribs
from patterndb_sketch.features.splines import Constraint, Spline, fit_spline

#: The length over which bends are measured, as a share of the diagonal.
WINDOW = 0.003

#: How near the backbone bends count, as a share of the diagonal: see
#: :func:`patterndb_sketch.features.fishbone.find_terms`.
NEARNESS = 0.012

#: Cost of moving across by as much as along: see :meth:`SnapSettings.cross`.
THETA = 0.4

#: Cost of changing from one crease to another: see :attr:`SnapSettings.continuity`.
CONTINUITY = 2.0

#: Ribs kept when the curve is dragged have moved by at most this share of their radius, and
#: turned by at most this, in radians.
MOVED = 0.02

TURNED = 0.035


@dataclass(frozen=True, slots=True)
class SnapSettings:
    """What a curve is drawn to, and how stiff it is.

    alpha:     1 for bends of the surface alone, 0 for the angle of its normals alone.
    axis:      (3,) the direction that normals are measured from. beta: the angle, in radians.
    stiffness: at least 1; the cost of moving across, as a multiple.
    theta:     that cost as such: moving across by some length costs theta times what the worst
               sample costs over the same length along the curve.
    continuity: what it costs to leave a crease of the sharpest bend, or to meet one, as a
               multiple of what the worst sample of a rib costs; 0 where every rib counts by itself.
    strict:    rather, as the paper has it, moving by one sample costs as much as the worst
               sample: the curve hardly leaves the row that it is in.
    window:    length over which bends are measured, as a share of the model's diagonal.
    nearness:  at this distance from the backbone a crease costs ASTRAY of
               :mod:`patterndb_sketch.features.fishbone.terms` more, at twice it four times as much,
               and with a continuity of 0 bends count 0.6 times and 0.14 times; a share of the
               diagonal, None where all count alike.
    degree:    of the curve.
    radius:    reach of ribs to either side, as a share of the diagonal. n_samples: of each.
    rounds:    how often the ribs are built about the curve and cut. Two bring the curve to the
               feature; a third the ribs of a stroke's ends, which at first lie askew to it.

    Raises InvalidFeatureError for numbers out of range.
    """

    alpha: float = ALPHA
    axis: tuple[float, float, float] = AXES[AXIS]
    beta: float = float(np.deg2rad(BETA))
    stiffness: float = STIFFNESS
    theta: float = THETA
    continuity: float = CONTINUITY
    strict: bool = False
    window: float = WINDOW
    nearness: float | None = NEARNESS
    degree: int = DEGREE
    radius: float = RADIUS
    n_samples: int = SAMPLES
    rounds: int = SNAP_ROUNDS

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("alpha", self.alpha, 0.0, 1.0),
            ("beta", self.beta, 0.0, np.pi),
            ("stiffness", self.stiffness, 1.0, 1e6),
            ("theta", self.theta, 0.0, 1e6),
            ("continuity", self.continuity, 0.0, 1e6),
            ("window", self.window, 1e-9, 1.0),
            ("nearness", np.inf if self.nearness is None else self.nearness, 1e-9, np.inf),
            ("radius", self.radius, 1e-6, 1.0),
            ("n_samples", self.n_samples, 5, 100_001),
            ("rounds", self.rounds, 1, 100),
        ):
            if not low <= value <= high:
                raise InvalidFeatureError(f"{name} is {value}; give {low:g} to {high:g}")

    @property
    def change(self) -> float:
        """The price of another crease, of bends that differ by 1; 0 for the paper's cut."""
        return 0.0 if self.strict else self.alpha * self.continuity

    def reach_of_bends(self, diagonal: float) -> float:
        """Return the nearness on a model of this diagonal; infinity where all bends count alike."""
        return np.inf if self.nearness is None else self.nearness * diagonal

    def list_differences(self, other: SnapSettings) -> dict[str, Any]:
        """Return the settings that are not those of another, by name."""
        names = [one.name for one in fields(self)]
        return {
            name: getattr(self, name)
            for name in names
            if getattr(self, name) != getattr(other, name)
        }

    def cross(self, fishbone: Fishbone, costs: Floats) -> Floats:
        """(m - 1,), of a closed curve (m,), capacities of the cross edges of a fishbone with sample
        costs (m, k).

        Source: feature curve recovery paper, section 4.3.3. Differs from the paper unless
        strict: capacities above all samples' make a curve that goes straight on whatever the
        surface is. Per length, rather than per sample, the result does not depend on how
        densely ribs are sampled: a cross edge costs theta f s / d where samples are s apart on
        ribs d apart.
        """
        gaps = fishbone.gaps
        if self.strict:
            return np.full(len(gaps), self.stiffness * costs[np.isfinite(costs)].max())
        if not (len(gaps) and gaps.mean() > 0.0):
            return np.zeros(len(gaps))
        return self.theta * self.stiffness * fishbone.steps / gaps.mean()


@dataclass(frozen=True, slots=True, eq=False)
class FeatureCurve:
    """A curve on a feature of a model.

    spline:      closed if the stroke was.
    samples:     (m, 3) float64, where it was found: on the model, or where a rib bridges a gap on
                 that rib, off the model by less than 1.2 times the gap; its constraints at theirs.
                 Of a closed curve the first is not repeated.
    parameters:  (m,) float64, of the samples on the spline.
    constraints: numbers of samples and the points that the spline meets exactly there.
    repaired:    numbers of ribs that were put together from several segments.
    failed:      numbers of ribs without a contour, or with one of another surface alone: samples
                 there moved as those of their neighbours.
    ended:       numbers of ribs that were cut at an end: the feature may be farther off.
    notes:       what else is not as asked for.
    """

    spline: Spline
    samples: Points
    parameters: Floats
    constraints: tuple[Constraint, ...]
    settings: SnapSettings
    repaired: tuple[int, ...]
    failed: tuple[int, ...]
    ended: tuple[int, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Snap:
    """A curve with all that it was found by, so that it can be changed while one looks on.

    stroke:   (k, 3) the clicked points.
    origins, tangents: (m, 3) where each rib was built, and across which direction.
    backbone: the spline about which the ribs are.
    ribs:     of it, None where there is no contour. fishbone: of them, synchronised.
    terms:    what pulls the curve.
    notes:    on the stroke.
    """

    model: Surface
    stroke: Points
    settings: SnapSettings
    backbone: Spline
    parameters: Floats
    origins: Points
    tangents: Points
    ribs: tuple[Rib | None, ...]
    fishbone: Fishbone
    terms: Terms
    curve: FeatureCurve
    notes: tuple[str, ...]

    @classmethod
    def begin(
        cls,
        model: Surface,
        stroke: ArrayLike,
        settings: SnapSettings | None = None,
        constraints: Sequence[Constraint] = (),
        *,
        closed: bool | None = None,
    ) -> Snap:
        """The curve of a stroke after ``settings.rounds`` rounds; see :func:`snap`."""
        chosen = SnapSettings() if settings is None else settings
        clicked = as_points(stroke, "points of a stroke", InvalidFeatureError)
        sketch = find_initial_curve(model, clicked, closed=closed)
        around = sketch.through.closed
        far = int((sketch.lengths > chosen.radius * model.diagonal).sum())
        notes = (
            (f"{far} of {len(sketch.samples)} samples of the stroke were far off the model",)
            if far
            else ()
        )
        samples = sketch.samples
        if constraints and chosen.change > 0.0:
            moved = move_with_pins(samples, constraints, model.diagonal, closed=around)
            samples = model.nearest(moved).points
        sketched = _SketchedCurve(model, clicked, around, notes)
        first = _about(sketched, chosen, samples, tuple(constraints))
        return first.again(chosen.rounds - 1)

    @property
    def closed(self) -> bool:
        """Does the curve go on from its last sample to the first?"""
        return self.backbone.closed

    def again(self, rounds: int = 1) -> Snap:
        """After more rounds: ribs about the curve as it is now."""
        snapped = self
        sketched = _SketchedCurve(self.model, self.stroke, self.closed, self.notes)
        for _ in range(rounds):
            now = snapped.curve
            snapped = _about(sketched, self.settings, now.samples, now.constraints)
        return snapped

    def with_settings(self, settings: SnapSettings) -> Snap:
        """With other settings: the same ribs are cut again, unless they would differ."""
        old = self.settings
        if (settings.radius, settings.n_samples, settings.rounds) != (
            old.radius,
            old.n_samples,
            old.rounds,
        ):
            return Snap.begin(
                self.model, self.stroke, settings, self.curve.constraints, closed=self.closed
            )
        found = self.terms
        if (settings.window, settings.nearness, settings.axis, settings.beta) != (
            old.window,
            old.nearness,
            old.axis,
            old.beta,
        ):
            found = _terms(self.model, self.fishbone, settings)
        changed = replace(self, settings=settings, terms=found)
        return changed._cut(self.curve.constraints)

    def with_constraints(self, constraints: Sequence[Constraint]) -> Snap:
        """With other constraints: only the ribs are built again that the curve leaves.

        The backbone is bent to meet the constraints, so that each is in the plane of its rib.
        """
        wanted = tuple(constraints)
        samples = self.backbone.evaluate(self.parameters)
        fit = fit_spline(
            samples, degree=self.settings.degree, constraints=wanted, parameters=self.parameters,
            rounds=0, closed=self.closed,
        )  # fmt: skip
        origins = fit.spline.evaluate(self.parameters)
        tangents = fit.spline.tangent(self.parameters)
        reach = self.settings.radius * self.model.diagonal
        moved = np.linalg.norm(origins - self.origins, axis=1) > MOVED * reach
        turned = np.einsum("mc,mc->m", tangents, self.tangents) < np.cos(TURNED)
        stale = np.flatnonzero(moved | turned)
        ribs = list(self.ribs)
        for i, rib in zip(
            stale, _ribs(self.model, origins[stale], tangents[stale], self.settings), strict=True
        ):
            ribs[i] = rib
        origins[~(moved | turned)] = self.origins[~(moved | turned)]
        tangents[~(moved | turned)] = self.tangents[~(moved | turned)]
        fishbone = synchronise(Fishbone.from_ribs(ribs), closed=self.closed)
        changed = replace(
            self, backbone=fit.spline, origins=origins, tangents=tangents, ribs=tuple(ribs),
            fishbone=fishbone, terms=_terms(self.model, fishbone, self.settings),
        )  # fmt: skip
        off = [np.linalg.norm(samples[number] - np.asarray(place)) for number, place in wanted]
        return changed._cut(wanted, float(max(off, default=0.0)))

    def _cut(self, constraints: tuple[Constraint, ...], pulled: float = 0.0) -> Snap:
        """With the curve through the cheapest way across the ribs as they are.

        pulled: how far the constraints are from where the curve was.
        """
        bone = self.fishbone
        held = find_held_rows(bone, constraints)
        rows, costs = self._find_rows(held, pulled)
        numbers = np.arange(len(self.ribs))
        period = len(numbers) if self.closed else None
        moved, told = find_moves(bone, rows, costs, period)
        # Samples of ribs that are not there are as far from the backbone as their neighbours.
        between = [np.interp(numbers, bone.ribs, moved[:, c], period=period) for c in range(3)]
        wanted = self.origins + np.stack(between, axis=1)
        samples = self.model.nearest(wanted).points
        off = np.linalg.norm(samples - wanted, axis=1)
        # Ribs leave the model only where they bridge gaps, and there the feature is on them.
        bridged = bone.ribs[told]
        bridged = bridged[off[bridged] > STITCH * self.model.diagonal]
        samples[bridged] = wanted[bridged]
        for number, place in constraints:
            samples[number] = place
        fit = fit_spline(
            samples, degree=self.settings.degree, constraints=constraints, closed=self.closed
        )
        ended = (rows == bone.first) | (rows == bone.stop - 1)
        failed = np.setdiff1d(numbers, bone.ribs).tolist()
        notes = [*self.notes, fit.note]
        if failed:
            notes.append(
                f"{len(failed)} of {len(numbers)} ribs have no contour on this surface: "
                "their samples are as far off the sketch as those of the next ribs"
            )
        used = ("curvature",) if self.settings.alpha > 0.0 else ()
        used += ("isophote",) if self.settings.alpha < 1.0 else ()
        notes += [f"the {name} is the same everywhere" for name in self.terms.flat if name in used]
        curve = FeatureCurve(
            fit.spline,
            samples,
            fit.parameters,
            constraints,
            self.settings,
            tuple(i for i, rib in enumerate(self.ribs) if rib is not None and rib.repaired),
            tuple(failed),
            tuple(bone.ribs[ended & (held < 0)].tolist()),
            tuple(note for note in notes if note),
        )
        return replace(self, curve=curve)

    def _find_rows(self, held: Int64Array, pulled: float) -> tuple[Int64Array, Floats]:
        """((m,), (m, k)) the rows that are cut, held ones among them, and the costs of samples.

        First all ribs together say which crease it is, then its middle is looked for.
        """
        bone, settings, terms = self.fishbone, self.settings, self.terms

        def price(pulls: Terms) -> Floats:
            return hold_rows(tau(pulls, settings.alpha), held)

        costs = price(terms)
        if not settings.change > 0.0:
            return cut(costs, settings.cross(bone, costs), bone.seam).rows, costs
        reach, size = find_reach(bone), self.model.diagonal
        nearness = settings.reach_of_bends(size)
        unlike, width = compare_with_pins(terms, bone, held, nearness, size, pulled)
        costs = hold_rows(weigh_creases(terms, bone, settings.alpha, width, unlike), held)
        cross = settings.cross(bone, costs)
        rows = track_crease(costs, cross, terms.bends, settings.change, reach, bone.seam).rows
        costs = price(settle_on_crease(terms, bone, rows, nearness))
        rows = track_crease(costs, cross, terms.bends, settings.change, reach, bone.seam).rows
        return rows, costs


def snap(
    model: Surface,
    stroke: ArrayLike,
    settings: SnapSettings | None = None,
    constraints: Sequence[Constraint] = (),
    *,
    closed: bool | None = None,
) -> FeatureCurve:
    """The curve on the feature that a stroke (k, 3) was drawn along.

    constraints: (number of a sample, point (3,)) that the curve meets; samples are numbered as
                 those of the initial curve, and keep their numbers.
    closed:      whether the curve goes on from the stroke's end to its start; by default if they
                 are the same place, see :func:`patterndb_sketch.features.initial.is_ring`.

    The stroke's initial curve carries ribs; the cheapest way across them is reprojected onto the
    model and fitted, and carries the ribs of the next round.

    Source: feature curve recovery paper, section 4.3. Differs from the paper: samples on a bridged
    gap stay there, as the model's nearest point is beside the feature; ribs that miss the feature
    move as those beside them; curves may be closed. Raises InvalidFeatureError for a stroke that is
    none, and if no rib has a contour.
    """
    return Snap.begin(model, stroke, settings, constraints, closed=closed).curve


@dataclass(frozen=True, slots=True, eq=False)
class _SketchedCurve:
    """What is the same in every round; fields as of :class:`Snap`."""

    model: Surface
    stroke: Points
    closed: bool
    notes: tuple[str, ...]


def _about(
    sketched: _SketchedCurve,
    settings: SnapSettings,
    samples: Points,
    constraints: tuple[Constraint, ...],
) -> Snap:
    """Make one round: ribs about the spline through the samples, cut."""
    model, closed, notes = sketched.model, sketched.closed, sketched.notes
    fit = fit_spline(samples, degree=settings.degree, constraints=constraints, closed=closed)
    origins, tangents = fit.spline.evaluate(fit.parameters), fit.spline.tangent(fit.parameters)
    ribs = _ribs(model, origins, tangents, settings)
    fishbone = synchronise(Fishbone.from_ribs(ribs), closed=closed)
    curve = FeatureCurve(
        fit.spline, samples, fit.parameters, constraints, settings, (), (), (), notes
    )
    return Snap(
        model, sketched.stroke, settings, fit.spline, fit.parameters, origins, tangents, ribs,
        fishbone, _terms(model, fishbone, settings), curve, notes,
    )._cut(constraints)  # fmt: skip


def _ribs(
    model: Surface, origins: Points, tangents: Points, settings: SnapSettings
) -> tuple[Rib | None, ...]:
    reach = settings.radius * model.diagonal
    if not len(origins):
        return ()
    ribs = build_ribs(model, origins, tangents, reach, settings.n_samples)
    return tuple(rib if len(rib) else None for rib in ribs)


def _terms(model: Surface, fishbone: Fishbone, settings: SnapSettings) -> Terms:
    size = model.diagonal
    return find_terms(
        fishbone,
        settings.window * size,
        settings.reach_of_bends(size),
        settings.axis,
        settings.beta,
    )
