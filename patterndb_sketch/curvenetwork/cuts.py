"""Where drawn curves are cut, and the nodes that their cuts are gathered in.

Places that are joined become one node, and so do neighbours on a curve within its reach, nearest
first. Exact nodes stay:

- two nodes at which curves were put exactly never become one, and neither moves;
- a node gathers places of several curves that are drawn exactly only where these meet exactly: such
  a curve is cut where another one meets it, and does not move.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from patterndb.core.halfedge import Int64Array
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.curvenetwork.meetings import Joins
from patterndb_sketch.curvenetwork.polylines import Groups, PackedCurves
from patterndb_sketch.curvenetwork.survey import Survey

#: How firmly a place holds its node; nodes are where they are held most firmly. ENDING, PASSING:
#: a cut of a curve that ends there, or goes on. SETTLED: of one that is drawn exactly. EXACT: an
#: exact meeting. FIRM: one that is meant. PUT: one where curves were put as they were drawn.
ENDING, PASSING, SETTLED, EXACT, FIRM, PUT = range(6)


@dataclass(frozen=True, slots=True)
class CurveCuts:
    """The cuts of all curves, those of each in order; one alone if the curve vanishes.

    starts: (c + 1,) where those of each curve begin. lengths: (m,) arc lengths. nodes: (m,) the
    nodes. places: (k, 3) of the nodes. counts: (k,) how many cuts each has. spreads: (k,) how far
    the farthest of them is away.
    """

    starts: Int64Array = field(repr=False)
    lengths: Floats = field(repr=False)
    nodes: Int64Array = field(repr=False)
    places: Points = field(repr=False)
    counts: Int64Array = field(repr=False)
    spreads: Floats = field(repr=False)


@dataclass(frozen=True, slots=True)
class _Sites:
    """Places on curves: both of every join, then both ends of every curve.

    met: of joins. exact: of joins that are so. holds: how firmly these hold their nodes, else 0.
    """

    curves: Int64Array
    lengths: Floats
    met: NDArray[np.bool_]
    exact: NDArray[np.bool_]
    holds: Int64Array


def cut_curves(
    curves: PackedCurves,
    fixed: Joins,
    holds: Int64Array,
    loose: Joins,
    survey: Survey,
    exact: float,
) -> CurveCuts:
    """Gather the places of joins in nodes, and cut the curves there.

    fixed: joins that are exact. holds: (m,) EXACT, FIRM or PUT, how firmly they hold their nodes.
    loose: the others. exact: what is no further apart is one place.
    """
    n, n_fixed, c = len(fixed) + len(loose), len(fixed), len(curves)
    joins = fixed.append(loose)
    is_fixed = np.arange(n) < n_fixed
    both = np.r_[holds, np.zeros(len(loose), np.int64)]
    ends = np.zeros(2 * c, bool)
    sites = _Sites(
        np.r_[joins.curves.T.reshape(-1), np.arange(c), np.arange(c)],
        np.r_[joins.lengths.T.reshape(-1), np.zeros(c), curves.lasts],
        np.r_[np.ones(2 * n, bool), ends],
        np.r_[is_fixed, is_fixed, ends],
        np.r_[both, both, np.zeros(2 * c, np.int64)],
    )
    order = np.lexsort((sites.lengths, sites.curves))
    number = _number_nodes(sites, order, joins, is_fixed, survey, exact)
    return _cut_runs(
        curves, sites, order, number, np.maximum(survey.reaches, exact), survey.settled
    )


def _number_nodes(
    sites: _Sites,
    order: Int64Array,
    joins: Joins,
    is_fixed: NDArray[np.bool_],
    survey: Survey,
    exact: float,
) -> Int64Array:
    """(s,) the node of every site, numbered from 0. order: of sites, by curve and arc length."""
    s, n = len(sites.curves), len(joins)
    gaps = np.diff(sites.lengths[order])
    same = np.diff(sites.curves[order]) == 0
    # What is one place of one curve, and what meets exactly.
    one = np.flatnonzero(same & (gaps <= exact))
    met = np.flatnonzero(is_fixed)
    links = np.r_[order[one], met], np.r_[order[one + 1], met + n]
    graph = coo_array((np.ones(len(links[0]), bool), links), shape=(s, s))
    count, label = connected_components(graph, directed=False)
    label = label.astype(np.int64)
    # Then the others, nearest first.
    rest = np.flatnonzero(~is_fixed)
    rest = rest[np.argsort(joins.gaps[rest], kind="stable")]
    reach = survey.reaches[sites.curves[order[:-1]]]
    near = np.flatnonzero(same & (gaps > exact) & (gaps <= reach))
    near = near[np.argsort(gaps[near], kind="stable")]
    pairs = np.r_[label[rest], label[order[near]]], np.r_[label[rest + n], label[order[near + 1]]]
    firm = np.zeros(count, bool)
    firm[label[sites.holds >= FIRM]] = True
    settled: dict[int, set[int]] = {}
    open_to_more = np.isin(label, np.concatenate(pairs))
    for k in np.flatnonzero(survey.settled[sites.curves] & open_to_more).tolist():
        settled.setdefault(int(label[k]), set()).add(int(sites.curves[k]))
    groups = Groups(count)
    firms, nothing = firm.tolist(), set[int]()
    for a, b in zip(*(part.tolist() for part in pairs), strict=True):
        a, b = groups.find(a), groups.find(b)
        ours, theirs = settled.get(a, nothing), settled.get(b, nothing)
        if a == b or (firms[a] and firms[b]):
            continue
        if not (ours <= theirs or theirs <= ours):
            continue
        both = groups.unite(a, b)
        firms[both] = firms[a] or firms[b]
        if ours or theirs:
            settled[both] = ours | theirs
    roots = np.array([groups.find(k) for k in range(count)], np.int64)
    return np.unique(roots[label], return_inverse=True)[1].reshape(-1)


def _cut_runs(
    curves: PackedCurves,
    sites: _Sites,
    order: Int64Array,
    number: Int64Array,
    reaches: Floats,
    settled: NDArray[np.bool_],
) -> CurveCuts:
    """Cut every curve once in each run of neighbouring sites of one node."""
    curve, length, node = sites.curves[order], sites.lengths[order], number[order]
    apart = (np.diff(curve) > 0) | (np.diff(node) != 0) | (np.diff(length) > reaches[curve[1:]])
    first = np.flatnonzero(np.r_[True, apart])
    run = np.r_[0, np.cumsum(apart)]
    met, exact = sites.met[order], sites.exact[order]
    of_run = curve[first]
    last = curves.lasts[of_run]

    def has(flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return np.logical_or.reduceat(flags, first)

    def mean(flags: NDArray[np.bool_]) -> Floats:
        # From one of them on: the mean of equal lengths is that length.
        start = np.minimum.reduceat(np.where(flags, length, np.inf), first)
        start = np.where(np.isfinite(start), start, 0.0)
        total = np.add.reduceat(np.where(flags, length - start[run], 0.0), first)
        return start + total / np.maximum(np.add.reduceat(flags.astype(float), first), 1.0)

    at_start, at_end = length == 0.0, length == curves.lasts[curve]
    # A curve is cut at its end if others meet it there, else where they do meet it: what goes on
    # beyond is an overshoot.
    lengths = np.where(has(exact), mean(exact), mean(met))
    lengths = np.where(has(met & at_end), last, lengths)
    lengths = np.where(has(met & at_start), 0.0, lengths)
    unmet = ~has(met)
    lengths = np.where(unmet, np.where(has(at_start), 0.0, last), lengths)
    nodes = node[first]
    ending = has(~met)
    starts = np.searchsorted(of_run, np.arange(len(curves) + 1))
    cut_places = curves.locate(of_run, lengths)
    held = np.r_[
        np.where(settled[of_run], SETTLED, np.where(ending, ENDING, PASSING)),
        sites.holds[order][exact],
    ]
    held_nodes = np.r_[nodes, node[exact]]
    held_places = np.concatenate([cut_places, curves.locate(curve[exact], length[exact])])
    places = _place_nodes(held_nodes, held_places, held)
    spreads = np.zeros(len(places))
    np.maximum.at(spreads, nodes, np.linalg.norm(cut_places - places[nodes], axis=1))
    return CurveCuts(starts, lengths, nodes, places, np.bincount(nodes), spreads)


def _place_nodes(nodes: Int64Array, places: Points, held: Int64Array) -> Points:
    """(k, 3) every node at the mean of the places that hold it most firmly."""
    most = np.zeros(int(nodes.max()) + 1, np.int64)
    np.maximum.at(most, nodes, held)
    some = held == most[nodes]
    nodes, places = nodes[some], places[some]
    order = np.argsort(nodes, kind="stable")
    nodes, places = nodes[order], places[order]
    first = np.flatnonzero(np.r_[True, np.diff(nodes) > 0])
    start = places[first]
    return start + np.add.reduceat(places - start[nodes], first) / np.bincount(nodes)[:, None]
