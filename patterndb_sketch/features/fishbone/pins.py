"""Pins: points that a curve passes through say which of the creases beside the stroke is meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.fishbone.fishbone import Fishbone
from patterndb_sketch.features.fishbone.terms import Terms, scale_term, weigh_nearness
from patterndb_sketch.features.splines import Constraint

#: Within this share of the diagonal along the curve a pin says how far off the stroke is: strokes
#: wobble from click to click.
TELLS_WHERE = 0.03

#: Pins in neighbouring ribs are nearly one: this share of the variance keeps systems regular.
JITTER = 1e-6

#: What is nothing like the pinned crease costs so many times what the worst sample costs more.
UNLIKE = 1.5

#: Within this share of the diagonal along the curve a pin says which crease is meant: it is the
#: same crease much longer than the stroke is as far off.
TELLS_WHICH = 0.3

#: At a pin a crease is as near as this share of the usual distance: it may have been set a little
#: off.
NARROWEST = 0.5

#: The sharpest of so many samples to either side of a pin is its crease's.
SET_OFF = 3

#: Once the crease is known, bends count within this share of the usual distance from it.
SETTLED = 0.5

#: A curve that was elsewhere before it was pinned counts as near its crease within so many times as
#: far as the pin is off it.
DRAGGED = 2.0

#: A pin says nothing of a rib that has nothing like it, and all it can say from this likeness on:
#: one on the corner of a crease is like no other place of it.
ALIKE = 0.5

#: A pin on what bends by less, of the bends that count as 1, is on no crease.
ON_CREASE = 0.05


def move_with_pins(
    samples: Points,
    constraints: Sequence[Constraint],
    diagonal: float,
    *,
    closed: bool = False,
) -> Points:
    """(m, 3) samples of a stroke, moved about constraints by as much as it is off there.

    closed: the last sample is beside the first.

    How far a stroke is off is taken for a normal process along it: TELLS_WHERE away from a pin
    samples move by 0.6 times as much, and pins farther apart do not disturb each other.
    """
    if not constraints:
        return samples
    around = np.concatenate([samples, samples[:1]])
    arcs = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))] / diagonal
    pins = np.array([number for number, _ in constraints])
    off = np.stack([np.asarray(place, np.float64) for _, place in constraints]) - samples[pins]
    away = np.abs(arcs[:-1, None] - arcs[pins])
    alike = _alikeness(np.minimum(away, arcs[-1] - away) if closed else away)
    return samples + alike @ np.linalg.solve(alike[pins] + JITTER * np.eye(len(pins)), off)


def compare_with_pins(
    terms: Terms,
    fishbone: Fishbone,
    held: Int64Array,
    nearness: float,
    diagonal: float,
    pulled: float = 0.0,
) -> tuple[Floats, Floats]:
    """((m, k), (m,)) how unlike the crease at the nearest pin samples are, as costs up to UNLIKE,
    and how near the backbone that crease is in each rib, as ``nearness`` says it without pins.

    held: (m,) rows of pins, -1 for ribs without one. nearness: as of weigh_creases, and pulled: how
    far pins are from where the curve was without them, in the model's unit.

    A sample is like a pin if its bend is, as a vector: neither a sharper crease nor one that is
    bent another way draws the curve away from the one that was pinned. About a pin the crease is
    nearer, for there the backbone is where it belongs: how far a stroke is off is taken for a
    normal process along the curve, whose values the pins tell.

    Differs from the paper: there a constraint holds its own rib alone, and the next ones may
    leave the crease again.
    """
    pins = np.flatnonzero(held >= 0)
    if not len(pins):
        return np.zeros(fishbone.valid.shape), np.full(len(held), nearness)
    away = fishbone.measure_along(pins) / diagonal
    width = nearness * np.maximum(np.sqrt(_unknown(away, pins)), NARROWEST)
    sizes = np.linalg.norm(terms.bends, axis=2)
    nearest = away.argmin(axis=1)
    wanted = np.stack([_bend_at(terms, sizes, i, int(held[i])) for i in pins.tolist()])[nearest]
    size = np.linalg.norm(wanted, axis=1)
    told = np.exp(-0.5 * (away.min(axis=1) / TELLS_WHICH) ** 2) * (size > ON_CREASE)
    apart = np.linalg.norm(terms.bends - wanted[:, None], axis=2)
    like = np.maximum(1.0 - apart / np.maximum(size, ON_CREASE)[:, None], 0.0)
    width = np.maximum(width, DRAGGED * pulled)
    about = (like * weigh_nearness(fishbone, width)).max(axis=1)
    told *= np.minimum(about / ALIKE, 1.0)
    return UNLIKE * told[:, None] * (1.0 - like), width


def settle_on_crease(terms: Terms, fishbone: Fishbone, rows: Int64Array, nearness: float) -> Terms:
    """The terms with all bends for what they are, but next to nothing far from rows (m,).

    What is like a pinned crease is all alike on a rounded one that is sharper elsewhere: the track
    tells which crease it is, and the bends about it where its middle is.
    """
    away = np.arange(fishbone.valid.shape[1]) - rows[:, None]
    width = SETTLED * nearness
    near = np.exp(-0.5 * (away * fishbone.spacing[:, None] / width) ** 2)
    sizes = np.linalg.norm(terms.bends, axis=2) * near
    return replace(terms, curvature=scale_term(sizes, fishbone.valid, 0.0))


def _unknown(away: Floats, pins: Int64Array) -> Floats:
    """(m,) the share of a stroke's variance that pins, (m, p) away along it, leave open."""
    alike = _alikeness(away)
    between = alike[pins] + JITTER * np.eye(len(pins))
    known = np.einsum("mp,pm->m", alike, np.linalg.solve(between, alike.T))
    return np.clip(1.0 - known, 0.0, 1.0)


def _alikeness(away: Floats) -> Floats:
    """How alike a stroke is off at two places so far away along it, in shares of the diagonal."""
    return np.exp(-0.5 * (away / TELLS_WHERE) ** 2)


def _bend_at(terms: Terms, sizes: Floats, rib: int, row: int) -> Floats:
    """(3,) the sharpest bend at a pin or right beside it."""
    first = max(row - SET_OFF, 0)
    return terms.bends[rib, first + int(sizes[rib, first : row + SET_OFF + 1].argmax())]
