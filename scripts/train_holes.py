"""Train the models that fill holes, from meshes, and write them to a file.

    python scripts/train_holes.py MESHES -o patterndb/data/holes.npz
    python scripts/train_holes.py MESHES -o holes.npz --folds-to FOLDER --report report.json
    python scripts/train_holes.py MESHES -o small.npz --part 0.2
    python scripts/train_holes.py MESHES -o left_out.npz --leave-out NAMES.txt

Needs LightGBM (pip install lightgbm), which the package itself does not. The same meshes, options
and versions of LightGBM and NumPy give the same file to the byte: everything is drawn by the seeds
of :class:`Plan`, which the file keeps as its entry "training", and each model is fitted by one
thread. ``--part`` multiplies all numbers of holes.

Meshes are dealt into folds, meshes of one family (INDEX.csv, shares_topology_with) into one. What
is asked about the holes of a fold is asked of models and a database that have not seen its meshes.
The database is the starter database without them. Only meshes that INDEX.csv gives as free of all
rights are learned from; the others serve as tests, in whichever fold they are.

1. Patterns of holes: what the holes that scripts/cut_holes.py cuts reduce to.
2. Corner model: boosted trees that classify each loop vertex by its quads, every second hole
   mirrored, one model a fold. The model that is shipped is their mean.
3. Assignments: a conditional logit on the corners that are likeliest vertex by vertex.
4. Lists: the candidates of holes, with the artist's own fill among them: as the program makes
   them, except for fills that are paved, which are ranked by what was learned from the others.
   Lists are rich in fills with irregular vertices inside; each counts by the number of holes that
   it stands for.
5. Ranking: two conditional logits, of the facts of a candidate and of all its numbers, and trees
   on top of the second, boosted by Newton steps of the same likelihood. Early lists, those that
   the first fill is chosen from, count as well as whole ones.

Prints how often the artist's own fill is first, among five and among twenty, in folds.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import os
import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from build_starter import FREE
from cut_holes import Cut, cut_everyday, cut_holes, read_topology
from numpy.typing import NDArray
from scipy.optimize import minimize

import patterndb
from patterndb._native.query.recognition import weld_quads
from patterndb.core.code import canonical_code
from patterndb.core.packing import pack
from patterndb.core.reduction import reduce_disk
from patterndb.errors import InvalidBoundaryError
from patterndb.store.starter import PACKED_NAME, unpack_starter
from query import Boundary, fills
from query.boundary import CornerKind
from query.holes.candidates import (
    ASKED_FIRST,
    ASSIGNMENTS,
    KEPT_LATE,
    REMEMBERED,
    REMEMBERED_LATE,
    HoleSearch,
)
from query.holes.corners import (
    AssignmentModel,
    CornerModel,
    TreeModel,
    measure_assignments,
    rank_listed,
)
from query.holes.features import measure_hole, mirror_hole
from query.holes.models import shipped_models
from query.holes.neighbourhood import extract_neighbourhood
from query.holes.options import HoleOptions
from query.holes.patterns import KEPT, HolePatterns
from query.holes.projection import mend_fill, place_fill
from query.holes.ranking import (
    FACTS,
    RankingModel,
    compare_numbers,
    list_facts,
    measure_plain_fill,
    tame_numbers,
)
from query.holes.ranking import PLACED as PLACED_BY_FACTS
from query.holes.symmetry import ASYMMETRIC
from query.recognition import hash_quads

#: Of every mesh lists stand for so many everyday holes, and so many irregular ones.
EVERYDAY_STANDS, IRREGULAR_STANDS = 30, 12

#: Candidates of a list that are placed, and how they are chosen, before there is a ranking: by what
#: is added to the score for each.
PLACED = 48
PRELIMINARY = {"assignment": 0.5, "log_hole_share": 0.3, "inner_irregular": -0.4}

#: Strength of the logits' ridge.
RIDGE = 3.0

#: Fills of a plain boundary that its ranking is trained on.
PLAIN_FILLS = 40

#: Mirrors of loops count by a number of their own (query.holes.symmetry), on top of the models.
NO_MIRRORS = np.zeros(0, np.int32)

#: A list's place among three kinds: everyday and regular inside, everyday and irregular, irregular.
KINDS = ("regular", "everyday irregular", "irregular")

Arrays = dict[str, NDArray[Any]]
Numbers = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is cut, how much of it, and by which seeds; numbers of holes are for one mesh.

    corner_*: for the corner model. pattern_*: for the patterns. pool: everyday holes from which
    those for lists are drawn: list_regular, without irregular vertices inside, and list_inside,
    with some. list_irregular: of the other kind. plain: for boundaries in space. ranking_power: of
    the number of holes that a list stands for, by which it counts.
    """

    folds: int = 3
    fold_seed: int = 5
    corner_everyday: int = 400
    corner_irregular: int = 300
    corner_seed: int = 101
    corner_rounds: int = 160
    corner_leaves: int = 24
    corner_rate: float = 0.1
    pattern_everyday: int = 600
    pattern_irregular: int = 1_500
    pattern_seed: int = 77
    pool: int = 240
    list_regular: int = 12
    list_inside: int = 32
    list_irregular: int = 18
    list_seed: int = 301
    plain: int = 4
    plain_seed: int = 501
    ranking_rounds: int = 400
    ranking_leaves: int = 31
    ranking_rate: float = 0.05
    ranking_bags: int = 3
    ranking_power: float = 1.0

    def scale(self, part: float) -> Plan:
        """Return the plan with a part of the holes."""
        counted = ("corner_everyday", "corner_irregular", "pattern_everyday", "pattern_irregular")
        counted += ("pool", "list_regular", "list_inside", "list_irregular", "plain")
        return replace(
            self, **{name: max(1, round(part * getattr(self, name))) for name in counted}
        )


@dataclass(slots=True)
class CornerRows:
    """Holes of a mesh for the corner model: (v, f) float32 features, (v,) quads, (v,) quads that
    would be regular, (h + 1,) where each hole begins, (h,) whether it is an everyday one."""

    features: NDArray[np.float32]
    counts: NDArray[np.int32]
    regular_valence: NDArray[np.int32]
    start: NDArray[np.int64]
    everyday: NDArray[np.bool_]


@dataclass(slots=True)
class CandidateList:
    """The candidates of a hole.

    facts: (c, FACTS) float32. chosen: (p,) those that are placed, of which numbers (p, f) are all
    numbers and sound (p,) tells which have no flipped quad, or can be mended so. offset: (c,) what
    is added to scores. n_early: how many candidates precede the
    first fill. own: the artist's; -1 where it is not among them. at: its place in chosen.
    """

    mesh: str
    kind: int
    inside: int
    weight: float
    facts: NDArray[np.float32]
    offset: Numbers
    chosen: NDArray[np.int64]
    numbers: NDArray[np.float32]
    sound: NDArray[np.bool_]
    n_early: int
    own: int
    at: int


Choice = tuple[Numbers, int]
T, R = TypeVar("T"), TypeVar("R")
M = TypeVar("M", bound=TreeModel)


@dataclass(slots=True)
class _Shared:
    """What the processes inherit: set before they are forked. corners, patterns and databases are
    those of each fold; rows by mesh."""

    plan: Plan = field(default_factory=Plan)
    paths: dict[str, Path] = field(default_factory=dict[str, Path])
    fold_of: dict[str, int] = field(default_factory=dict[str, int])
    learned: frozenset[str] = frozenset()
    rows: dict[str, CornerRows] = field(default_factory=dict[str, CornerRows])
    corners: list[CornerModel] = field(default_factory=list[CornerModel])
    assignments: AssignmentModel | None = None
    patterns: list[HolePatterns] = field(default_factory=list[HolePatterns])
    databases: list[Path] = field(default_factory=list[Path])
    lists: list[CandidateList] = field(default_factory=list["CandidateList"])


_shared = _Shared()


def read_index(folder: Path) -> list[dict[str, str]]:
    """Return the rows of a folder's INDEX.csv."""
    with (folder / "INDEX.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def list_families(folder: Path) -> list[list[Path]]:
    """Return the meshes of a folder in families of shared topology, according to its INDEX.csv."""
    paths = {path.name: path for path in sorted(folder.glob("*.obj"))}
    family = {name: name for name in paths}

    def root_of(name: str) -> str:
        while family[name] != name:
            name = family[name]
        return name

    for row in read_index(folder):
        for other in re.findall(r"([\w.\-]+?)\(\d+\)", row["shares_topology_with"] or ""):
            name = other if other in paths else f"{other}.obj"
            if name in paths and row["file"] in paths:
                family[root_of(name)] = root_of(row["file"])
    groups: dict[str, list[Path]] = {}
    for name, path in paths.items():
        groups.setdefault(root_of(name), []).append(path)
    return list(groups.values())


def deal_folds(families: list[list[Path]], n: int, seed: int) -> list[list[Path]]:
    """Deal families into n folds of about equally many meshes."""
    folds: list[list[Path]] = [[] for _ in range(n)]
    shuffled = sorted(families)
    random.Random(seed).shuffle(shuffled)
    for family in shuffled:
        min(folds, key=len).extend(family)
    return folds


def report(text: str) -> None:
    """Print progress, with the seconds since the start."""
    print(f"{time.perf_counter() - BEGIN:6.0f} s  {text}", file=sys.stderr, flush=True)


BEGIN = time.perf_counter()


def run_parallel(work: Callable[[T], R], tasks: Sequence[T], processes: int) -> list[R]:
    """Run tasks in forked processes; results in the order of the tasks."""
    found: list[R] = []
    with get_context("fork").Pool(processes, maxtasksperchild=None) as pool:
        for number, result in enumerate(pool.imap(work, tasks), 1):
            found.append(result)
            if number % 10 == 0 or number == len(tasks):
                report(f"{work.__name__}: {number} of {len(tasks)}")
    return found


def measure_mesh(name: str) -> tuple[CornerRows, Counter[bytes], Counter[bytes]]:
    """Cut a mesh's holes: rows for the corner model, and patterns of everyday and irregular
    holes."""
    plan = _shared.plan
    topology = read_topology(str(_shared.paths[name]))
    everyday = cut_everyday(name, topology, plan.corner_everyday, plan.corner_seed, tries=4)
    irregular = cut_holes(name, topology, plan.corner_irregular, plan.corner_seed + 1, tries=10)
    features, counts, regular_valence = [], [], []
    for cut in (*everyday, *irregular):
        around = extract_neighbourhood(cut.hole)
        features.append(measure_hole(cut.hole, around).astype(np.float32))
        counts.append(cut.counts)
        regular_valence.append(around.regular_valence)
    rows = CornerRows(
        np.vstack(features),
        np.concatenate(counts),
        np.concatenate(regular_valence),
        np.cumsum([0, *map(len, counts)]),
        np.arange(len(counts)) < len(everyday),
    )
    seed = plan.pattern_seed
    return (
        rows,
        reduce_cuts(cut_everyday(name, topology, plan.pattern_everyday, seed + 1, tries=4)),
        reduce_cuts(cut_holes(name, topology, plan.pattern_irregular, seed, tries=4)),
    )


def reduce_cuts(cuts: Iterable[Cut]) -> Counter[bytes]:
    """Count the holes that reduce to each pattern, by its packed code."""
    found: Counter[bytes] = Counter()
    for cut in cuts:
        n = len(cut.counts)
        twin, _ = weld_quads(cut.quads, n + len(cut.inner), n)
        found[pack(canonical_code(reduce_disk(twin))[0])] += 1
    return found


def gather_patterns(
    families: Iterable[Sequence[str]], by_mesh: Mapping[str, tuple[Counter[bytes], Counter[bytes]]]
) -> Arrays:
    """Return the arrays of HolePatterns, most frequent first.

    Everyday and irregular holes count alike, and so do families.
    """
    share: Counter[bytes] = Counter()
    kinds: Counter[bytes] = Counter()
    for family in families:
        met: set[bytes] = set()
        for which in (0, 1):
            found = sum((by_mesh[name][which] for name in family), Counter[bytes]())
            for code, count in found.items():
                share[code] += count / found.total()  # pyright: ignore[reportArgumentType]
            met |= set(found)
        kinds.update(met)
    codes = sorted(share, key=lambda code: (-share[code], code))
    total = math.fsum(share.values())
    return {
        "pattern_codes": np.frombuffer(b"".join(codes), np.uint8),
        "pattern_ends": np.cumsum([0, *map(len, codes)]).astype(np.int32),
        "pattern_meshes": np.array([kinds[code] for code in codes], np.int32),
        "pattern_share": np.array([share[code] / total for code in codes], np.float32),
    }


def fit_corners(fold: int) -> CornerModel:
    """Fit the corner model of a fold, on the meshes of all others."""
    import lightgbm

    plan = _shared.plan
    features, counts, number = [], [], 0
    for name in sorted(_shared.rows):
        if _shared.fold_of[name] == fold or name not in _shared.learned:
            continue
        rows = _shared.rows[name]
        for first, last in zip(rows.start[:-1], rows.start[1:], strict=True):
            one = rows.features[first:last]
            features.append(mirror_hole(one).astype(np.float32) if number % 2 else one)
            number += 1
        counts.append(rows.counts)
    data = lightgbm.Dataset(
        np.vstack(features), np.concatenate(counts) - 1, params={"max_bin": 127, "verbose": -1}
    )
    booster = lightgbm.train(
        {
            "objective": "multiclass",
            "num_class": 4,
            "learning_rate": plan.corner_rate,
            "num_leaves": plan.corner_leaves,
            "min_data_in_leaf": 30,
            "lambda_l2": 1.0,
            "feature_fraction": 0.25,
            "bagging_fraction": 0.7,
            "bagging_freq": 1,
            **_lightgbm_options(1),
        },
        data,
        num_boost_round=plan.corner_rounds,
    )
    return export_trees(booster, CornerModel, 4)


def _lightgbm_options(seed: int) -> dict[str, Any]:
    return {
        "num_threads": 1,
        "deterministic": True,
        "force_row_wise": True,
        "seed": seed,
        "verbose": -1,
    }


def export_trees(booster: Any, kind: type[M], scores: int) -> M:
    """Return the trees of a fitted LightGBM model as arrays."""
    starts, features, thresholds, children, values = [0], [], [], [], []
    for info in booster.dump_model()["tree_info"]:
        order = [info["tree_structure"]]
        for node in order:
            if "split_index" in node:
                order += [node["left_child"], node["right_child"]]
        place = {id(node): i for i, node in enumerate(order)}
        for node in order:
            leaf = "split_index" not in node
            features.append(-1 if leaf else node["split_feature"])
            thresholds.append(0.0 if leaf else node["threshold"])
            children.append(0 if leaf else place[id(node["left_child"])])
            values.append(node["leaf_value"] if leaf else 0.0)
        starts.append(len(features))
    # Thresholds are kept as float32, rounded upwards: what was not above one is not above it yet.
    exact = np.array(thresholds, np.float64)
    near = exact.astype(np.float32)
    near = np.where(near < exact, np.nextafter(near, np.float32(np.inf)), near)
    return kind(
        np.array(starts, np.int32),
        np.array(features, np.int16),
        near.astype(np.float32),
        np.array(children, np.int16),
        np.array(values, np.float32),
        np.zeros(scores),
    )


def join_models(models: Sequence[M]) -> M:
    """Return the mean of models as one: all their trees, each with a part of its value."""
    firsts = np.cumsum([0, *(len(one.feature) for one in models)])
    starts = [one.start[:-1] + first for one, first in zip(models, firsts, strict=False)]
    return type(models[0])(
        np.concatenate([*starts, firsts[-1:]]).astype(np.int32),
        np.concatenate([one.feature for one in models]),
        np.concatenate([one.threshold for one in models]),
        np.concatenate([one.child for one in models]),
        np.concatenate([one.value for one in models]) / np.float32(len(models)),
        np.mean([one.base for one in models], axis=0),
    )


def fit_logit(choices: Sequence[Choice], offsets: Sequence[Numbers] | None = None) -> list[Numbers]:
    """Fit mean, spread and weights of a conditional logit to (numbers (c, f), the chosen one).

    offsets: what is added to the scores of each list.
    """
    stacked = np.vstack([numbers for numbers, _ in choices]).astype(np.float64)
    mean, spread = stacked.mean(axis=0), stacked.std(axis=0)
    spread[spread < 1e-9] = 1.0
    scaled = (stacked - mean) / spread
    first, of_list, own = _index_lists(choices)
    added = np.zeros(len(scaled)) if offsets is None else np.concatenate(offsets)

    def loss(weights: Numbers) -> tuple[float, Numbers]:
        scores = scaled @ weights + added
        top = np.maximum.reduceat(scores, first)
        chance = np.exp(scores - top[of_list])
        total = np.add.reduceat(chance, first)
        chance /= total[of_list]
        value = RIDGE * float(weights @ weights) / 2 - (scores[own] - top - np.log(total)).sum()
        return value, RIDGE * weights + scaled.T @ chance - scaled[own].sum(axis=0)

    found = minimize(loss, np.zeros(scaled.shape[1]), jac=True, method="L-BFGS-B")
    return [mean, spread, found.x]


def _index_lists(choices: Sequence[Choice]) -> tuple[Any, Any, Any]:
    """Where each list begins, the list of each row, and the row of each list's chosen one."""
    size = np.array([len(numbers) for numbers, _ in choices])
    first = np.cumsum([0, *size])[:-1]
    own = first + np.array([chosen for _, chosen in choices], np.int64)
    return first, np.repeat(np.arange(len(size)), size), own


def fit_assignments(per_mesh: int = 24) -> AssignmentModel:
    """Fit what distinguishes the artist's corners from those that are likely one by one."""
    choices: list[Choice] = []
    asked = 0
    for name in sorted(_shared.rows):
        if name not in _shared.learned:
            continue
        rows, model = _shared.rows[name], _shared.corners[_shared.fold_of[name]]
        for everyday in (True, False):
            for hole in np.flatnonzero(rows.everyday == everyday)[:per_mesh].tolist():
                span = slice(int(rows.start[hole]), int(rows.start[hole + 1]))
                logs = model.log_probabilities(rows.features[span].astype(np.float64))
                listed = rank_listed(logs, NO_MIRRORS)
                own = np.flatnonzero((listed == rows.counts[span]).all(axis=1))
                asked += 1
                if len(own):
                    traits = measure_assignments(logs, rows.regular_valence[span], listed)
                    choices.append((traits, int(own[0])))
    report(f"assignments: {len(choices)} of {asked} holes")
    return AssignmentModel(*fit_logit(choices))


def judge_corners() -> dict[str, list[float]]:
    """Return the loss at a vertex, and the part of holes with all corners right, in folds."""
    found: dict[str, list[float]] = {}
    for title, everyday in (("everyday", True), ("irregular", False)):
        loss, right, vertices, holes = 0.0, 0, 0, 0
        for name, rows in _shared.rows.items():
            model = _shared.corners[_shared.fold_of[name]]
            for hole in np.flatnonzero(rows.everyday == everyday)[:40].tolist():
                span = slice(int(rows.start[hole]), int(rows.start[hole + 1]))
                logs = model.log_probabilities(rows.features[span].astype(np.float64))
                counts = rows.counts[span]
                loss -= float(logs[np.arange(len(logs)), counts - 1].sum())
                right += bool((logs.argmax(axis=1) + 1 == counts).all())
                vertices, holes = vertices + len(counts), holes + 1
        found[title] = [round(loss / vertices, 4), round(right / holes, 4)]
    return found


def list_mesh(name: str) -> tuple[list[CandidateList], list[Choice]]:
    """List the candidates of a mesh's holes, and the fills of boundaries in space."""
    plan, fold = _shared.plan, _shared.fold_of[name]
    topology = read_topology(str(_shared.paths[name]))
    draw = random.Random(f"{plan.list_seed}{name}")
    everyday = cut_everyday(name, topology, plan.pool, plan.list_seed, tries=8)
    irregular = cut_holes(name, topology, plan.list_irregular, plan.list_seed + 1, tries=20)
    regular = [cut for cut in everyday if not cut.inside]
    inside = [cut for cut in everyday if cut.inside]
    draw.shuffle(regular)
    draw.shuffle(inside)
    found: list[CandidateList] = []
    plain: list[Choice] = []
    with patterndb.open(_shared.databases[fold]) as database:
        for kind, (cuts, of, stands) in enumerate(
            (
                (regular[: plan.list_regular], len(regular), EVERYDAY_STANDS / len(everyday)),
                (inside[: plan.list_inside], len(inside), EVERYDAY_STANDS / len(everyday)),
                (irregular, len(irregular), IRREGULAR_STANDS / max(len(irregular), 1)),
            )
        ):
            for cut in cuts:
                found.append(list_candidates(cut, kind, stands * of / len(cuts), database))
        if name in _shared.learned:
            for cut in cut_holes(name, topology, plan.plain, plan.plain_seed, tries=20):
                plain += list_plain_fills(cut, database)
    return found, plain


def list_candidates(cut: Cut, kind: int, weight: float, database: Any) -> CandidateList:
    """List the candidates of a hole, by models that have not seen its mesh."""
    assert _shared.assignments is not None
    fold = _shared.fold_of[cut.mesh]
    around = extract_neighbourhood(cut.hole)
    models = replace(
        shipped_models(),
        corners=_shared.corners[fold],
        assignments=_shared.assignments,
        patterns=_shared.patterns[fold],
    )
    options = HoleOptions(tolerance=0)
    search = HoleSearch.begin(database, cut.hole, around, models, options, {})
    candidates = [*search.regular(), *search.remembered(REMEMBERED, KEPT)]
    candidates += search.likely(0, ASKED_FIRST)
    n_early = len(candidates) + 1  # the first of the others, too
    candidates += search.likely(ASKED_FIRST, ASSIGNMENTS)
    candidates += [*search.remembered(REMEMBERED_LATE, KEPT_LATE), *search.relaxed()]
    facts = tame_numbers(list_facts(candidates, around))
    keys = [candidate.key for candidate in candidates]
    own = keys.index(cut.key) if cut.key in keys else -1
    offset = -ASYMMETRIC * np.array([candidate.asymmetric for candidate in candidates], np.float64)
    score = offset + sum(facts[:, FACTS.index(name)] * by for name, by in PRELIMINARY.items())
    chosen = np.argsort(-score, kind="stable")[:PLACED]
    if own >= 0 and own not in chosen:
        chosen = np.append(chosen, own)
    placed, sound = [], []
    for i in chosen.tolist():
        fill = place_fill(around, candidates[i].quads, candidates[i].n_vertices)
        placed.append(fill.measures)
        sound.append(not mend_fill(around, candidates[i].quads, fill).flipped)
    numbers = tame_numbers(np.hstack([facts[chosen], np.array(placed)]))
    return CandidateList(
        cut.mesh,
        kind,
        cut.inside,
        weight,
        facts.astype(np.float32),
        offset,
        chosen,
        numbers.astype(np.float32),
        np.array(sound),
        min(n_early, len(candidates)),
        own,
        int(np.flatnonzero(chosen == own)[0]) if own >= 0 else -1,
    )


def list_plain_fills(cut: Cut, database: Any) -> list[Choice]:
    """List the fills of a hole's boundary with the artist's corners as if no mesh were around; no
    list where the artist's own is not among them."""
    counts, n = cut.counts, len(cut.counts)
    corners = np.flatnonzero(counts != 2)
    if counts.max() > 3 or not len(corners):
        return []
    start = int(corners[0])
    points = np.roll(cut.hole.points, -start, axis=0)
    kinds: list[CornerKind] = ["convex" if counts[c] == 1 else "reflex" for c in corners]
    try:
        boundary = Boundary(np.diff(np.r_[corners, start + n]).tolist(), kinds, points=points)
    except InvalidBoundaryError:
        return []  # two vertices of the mesh embedding in one place
    own, rows = None, []
    for place, fill in enumerate(fills(database, boundary, order="artist", limit=PLAIN_FILLS)):
        quads = np.where(fill.quads < n, (fill.quads + start) % n, fill.quads).astype(np.int32)
        twin, fault = weld_quads(quads, fill.n_vertices, n)
        if not fault and hash_quads(quads, twin, False) == cut.key:
            own = place
        rows.append(measure_plain_fill(fill, points))
    return [] if own is None else [(tame_numbers(np.array(rows)), own)]


def fit_ranking(fold: int) -> Arrays:
    """Fit the ranking to the lists of all folds but one, -1 for none."""
    known = [
        one
        for one in _shared.lists
        if one.own >= 0 and one.mesh in _shared.learned and _shared.fold_of[one.mesh] != fold
    ]
    facts = fit_logit([(one.facts, one.own) for one in known], [one.offset for one in known])
    choices: list[Choice] = []
    offsets: list[Numbers] = []
    weights: list[float] = []
    for one in known:
        early = np.flatnonzero(one.chosen < one.n_early)
        numbers, added = one.numbers.astype(np.float64), one.offset[one.chosen]
        choices.append((numbers, one.at))
        offsets.append(added)
        weights.append(one.weight)
        if 1 < len(early) < len(numbers) and one.at in early:
            choices.append((numbers[early], int(np.flatnonzero(early == one.at)[0])))
            offsets.append(added[early])
            weights.append(one.weight)
    linear = fit_logit(choices, offsets)
    trees = fit_trees(choices, offsets, np.array(weights), linear)
    return name_logit("facts", facts) | name_logit("whole", linear) | trees.to_arrays("whole_tree_")


def fit_trees(
    choices: Sequence[Choice],
    offsets: Sequence[Numbers],
    weights: Numbers,
    linear: list[Numbers],
) -> TreeModel:
    """Boost trees on top of a logit, several times by different seeds, and join them."""
    import lightgbm

    plan = _shared.plan
    mean, spread, slopes = linear
    first, of_list, own = _index_lists(choices)
    rows = np.vstack([compare_numbers(numbers) for numbers, _ in choices]).astype(np.float32)
    begin = ((np.vstack([numbers for numbers, _ in choices]) - mean) / spread) @ slopes
    begin += np.concatenate(offsets)
    weights = weights**plan.ranking_power
    counts = (weights * len(weights) / weights.sum())[of_list]
    chosen = np.zeros(len(rows))
    chosen[own] = 1.0

    def step(scores: Numbers, _: Any) -> tuple[Numbers, Numbers]:
        chance = np.exp(scores - np.maximum.reduceat(scores, first)[of_list])
        chance /= np.add.reduceat(chance, first)[of_list]
        return (chance - chosen) * counts, np.maximum(chance * (1 - chance), 1e-6) * counts

    made: list[TreeModel] = []
    for bag in range(plan.ranking_bags):
        data = lightgbm.Dataset(
            rows, chosen, init_score=begin, params={"max_bin": 127, "verbose": -1}
        )
        booster = lightgbm.train(
            {
                "objective": step,
                "learning_rate": plan.ranking_rate,
                "num_leaves": plan.ranking_leaves,
                "min_data_in_leaf": 20,
                "min_sum_hessian_in_leaf": 1e-3,
                "lambda_l2": 1.0,
                "feature_fraction": 0.3,
                **_lightgbm_options(bag + 1),
            },
            data,
            num_boost_round=plan.ranking_rounds,
        )
        made.append(export_trees(booster, TreeModel, 1))
    return join_models(made)


def name_logit(name: str, parts: list[Numbers]) -> Arrays:
    """Return the arrays of a logit, as HoleModels reads them."""
    names = (f"{name}_{part}" for part in ("mean", "spread", "weights"))
    return dict(zip(names, parts, strict=True))


def judge_lists(by_fold: Sequence[Arrays]) -> dict[str, list[float]]:
    """Return hit@1, @5, @20 in folds, of whole lists, by kind and irregular vertices inside; the
    first fill has flipped quads only where all have, and an own fill that the facts alone put
    behind those that the program places is missed."""
    ranks: list[tuple[CandidateList, float, bool]] = []
    models = [
        (
            RankingModel(*_read_logit(one, "facts")),
            *_read_logit(one, "whole"),
            TreeModel.from_arrays(one, "whole_tree_"),
        )
        for one in by_fold
    ]
    for one in _shared.lists:
        first_model, mean, spread, weights, trees = models[_shared.fold_of[one.mesh]]
        numbers = one.numbers.astype(np.float64)
        scores = ((numbers - mean) / spread) @ weights + one.offset[one.chosen]
        scores += trees.score(compare_numbers(numbers))[:, 0]
        flipped = ~one.sound
        order = np.argsort(-scores, kind="stable")
        first = order[np.argsort(flipped[order], kind="stable")[0]]
        order = np.r_[first, order[order != first]]
        rank = math.inf
        if one.at >= 0:
            known = first_model.score_facts(one.facts.astype(np.float64)) + one.offset
            if (known > known[one.own]).sum() < PLACED_BY_FACTS:
                rank = float(np.flatnonzero(order == one.at)[0])
        ranks.append((one, rank, bool(flipped[first])))
    found: dict[str, list[float]] = {}

    def add(title: str, test: Callable[[CandidateList], bool]) -> None:
        chosen = [(one.weight, rank, turned) for one, rank, turned in ranks if test(one)]
        total = sum(weight for weight, _, _ in chosen)
        if chosen:
            found[title] = [
                len(chosen),
                *(round(sum(w for w, r, _ in chosen if r < k) / total, 4) for k in (1, 5, 20, 1e9)),
                round(sum(w for w, _, turned in chosen if turned) / total, 4),
            ]

    add("everyday", lambda one: one.kind < 2)
    add("irregular", lambda one: one.kind == 2)
    for kind, title in enumerate(KINDS):
        add(title, lambda one, kind=kind: one.kind == kind)
    for low, high in ((0, 0), (1, 1), (2, 2), (3, 4), (5, 8), (9, 999)):
        for title, kinds in (("everyday", (0, 1)), ("irregular", (2,))):
            add(
                f"{title}, {low} to {high} inside" if low < high else f"{title}, {low} inside",
                lambda one, low=low, high=high, kinds=kinds: (
                    low <= one.inside <= high and one.kind in kinds
                ),
            )
    return found


def _read_logit(arrays: Arrays, name: str) -> list[Numbers]:
    return [arrays[f"{name}_{part}"] for part in ("mean", "spread", "weights")]


def make_databases(folder: Path, folds: Sequence[Sequence[Path]]) -> list[Path]:
    """Copy the starter database for each fold, without the meshes of the fold."""
    packed = Path(patterndb.__file__).parent / "data" / PACKED_NAME
    starter = unpack_starter(packed.read_bytes())
    made: list[Path] = []
    for number, fold in enumerate(folds):
        path = folder / f"fold{number}.db"
        path.unlink(missing_ok=True)
        shutil.copyfile(starter, path)
        path.chmod(0o644)
        names = {one.name for one in fold}
        with patterndb.open(path, "write") as database:
            database.remove([mesh.name for mesh in database.meshes() if mesh.name in names])
        made.append(path)
    return made


def main() -> None:
    # Sums by several threads of linear algebra differ in their last bits.
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    if any(os.environ.get(name) != "1" for name in one_thread):
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | one_thread)
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="meshes, with INDEX.csv")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--part", type=float, default=1.0, help="of all holes")
    parser.add_argument("--leave-out", type=Path, help="a file of names: meshes not to learn from")
    parser.add_argument("--folds-to", type=Path, help="write each fold's models and database here")
    parser.add_argument("--report", type=Path, help="write the figures as JSON here")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    import lightgbm

    plan = Plan().scale(given.part) if given.part != 1.0 else Plan()
    families = list_families(given.folder)
    folds = deal_folds(families, plan.folds, plan.fold_seed)
    paths = {path.name: path for family in families for path in family}
    left_out = set(given.leave_out.read_text().split()) if given.leave_out else set[str]()
    free = {row["file"] for row in read_index(given.folder) if row["licence"] in FREE}
    learned = frozenset((free & set(paths)) - left_out)
    fold_of = {path.name: number for number, fold in enumerate(folds) for path in fold}
    _shared.plan, _shared.paths, _shared.fold_of, _shared.learned = plan, paths, fold_of, learned
    names = sorted(paths)
    # The largest first, so that no process waits long for another.
    tasks = sorted(names, key=lambda name: (-paths[name].stat().st_size, name))
    measured = dict(zip(tasks, run_parallel(measure_mesh, tasks, given.processes), strict=True))
    by_mesh = {name: (everyday, irregular) for name, (_, everyday, irregular) in measured.items()}
    _shared.rows = {name: measured[name][0] for name in names}
    _shared.corners = run_parallel(fit_corners, range(plan.folds), given.processes)
    corners = judge_corners()
    report(f"corners, loss and all right: {corners}")
    _shared.assignments = fit_assignments()
    seen = [[path.name for path in one if path.name in learned] for one in families]
    by_fold = [
        gather_patterns([one for one in seen if one and fold_of[one[0]] != fold], by_mesh)
        for fold in range(plan.folds)
    ]
    _shared.patterns = [HolePatterns.from_arrays(arrays) for arrays in by_fold]
    _shared.rows.clear()
    del measured
    with tempfile.TemporaryDirectory() as work:
        folder = given.folds_to or Path(work)
        folder.mkdir(parents=True, exist_ok=True)
        _shared.databases = make_databases(folder, folds)
        listed = dict(zip(tasks, run_parallel(list_mesh, tasks, given.processes), strict=True))
    _shared.lists = [one for name in names for one in listed[name][0]]
    plain = [choice for name in names for choice in listed[name][1]]
    report(f"{len(_shared.lists)} lists, {len(plain)} of plain boundaries")
    *rankings, ranking = run_parallel(fit_ranking, [*range(plan.folds), -1], given.processes)
    together = _shared.assignments
    shared = name_logit("assignments", [together.mean, together.spread, together.weights])
    shared |= name_logit("plain", fit_logit(plain))
    made = {
        "plan": asdict(plan),
        "lightgbm": lightgbm.__version__,
        "numpy": np.__version__,
        "meshes": sorted(learned),
    }
    shared["training"] = np.frombuffer(json.dumps(made).encode(), np.uint8)
    judged = judge_lists(rankings)
    for title, values in judged.items():
        print(f"| {title} | " + " | ".join(f"{value:g}" for value in values) + " |")
    if given.folds_to:
        for fold, one in enumerate(rankings):
            arrays = shared | _shared.corners[fold].to_arrays() | by_fold[fold] | one
            np.savez_compressed(given.folds_to / f"fold{fold}.npz", **arrays)
            (given.folds_to / f"fold{fold}.txt").write_text(
                "".join(f"{name}\n" for name in names if fold_of[name] == fold)
            )
    if given.report:
        given.report.write_text(json.dumps(made | {"corners": corners, "lists": judged}, indent=1))
    arrays = shared | join_models(_shared.corners).to_arrays() | ranking
    arrays |= gather_patterns([one for one in seen if one], by_mesh)
    np.savez_compressed(given.output, **arrays)
    report(f"{given.output}: {given.output.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
