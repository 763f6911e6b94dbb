"""Train the models that fill holes: quads at a loop's vertices, one by one and together, and the
ranking of fills.

    python scripts/train_holes.py MESHES --db ALL.db -o patterndb/data/holes.npz
    python scripts/train_holes.py MESHES --db ALL.db --leave-out NAMES.txt -o left_out.npz
    python scripts/train_holes.py MESHES --patterns-only left_out.npz -o patterndb/data/holes.npz

Needs scikit-learn, which the package itself does not. ALL.db is a database of the meshes. They are
dealt into folds, meshes of one family (INDEX.csv, shares_topology_with) into one; what is asked of
the holes of a fold is asked of a corner model and a database that have seen none of its meshes.
Meshes left out are seen by nothing, nor are those that INDEX.csv does not say to be free of all
rights: what is learned of them may not be shipped. The corner model is the mean of those of all
folds, and the patterns are of all meshes that are seen; with --patterns-only these alone are
gathered, and the other models of that file are kept.

The patterns of holes: what the holes that scripts/cut_holes.py cuts reduce to. The corner model:
gradient boosting of decision trees on such holes, every second one mirrored. All else: conditional
logits, fitted by L-BFGS; the last ranking, of placed fills, has trees on top, boosted by the same
loss over lists: all candidates of a hole, and those that there are when its first fill is told.
"""

from __future__ import annotations

import argparse
import csv
import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from build_starter import FREE
from cut_holes import Cut, cut_holes, read_topology
from numpy.typing import NDArray
from scipy.optimize import minimize

import patterndb
from patterndb.core.code import canonical_code
from patterndb.core.packing import pack
from patterndb.core.reduction import reduce_disk
from patterndb.errors import InvalidBoundaryError
from query import Boundary, fills
from query.boundary import CornerKind
from query.holes.assignments import AssignmentModel, measure_assignments, rank_listed
from query.holes.candidates import HoleSearch
from query.holes.context import measure_hole, mirror_hole
from query.holes.corners import CornerModel
from query.holes.filling import ASKED_FIRST, PLACED, PLACED_FIRST
from query.holes.patterns import HolePatterns
from query.holes.ranking import (
    HoleCandidate,
    compare_numbers,
    list_facts,
    measure_plain_fill,
    tame_numbers,
)
from query.holes.rim import HoleRim
from query.holes.shape import place_fill
from query.holes.surroundings import (
    Surroundings,
    look_around,
)
from query.holes.trees import TreeModel
from query.identity import hash_quads, weld_quads

#: Holes cut from each mesh for the corners; of these, so many are asked of the database.
PER_MESH, PER_MESH_ASKED = 150, 24

#: Holes cut from each mesh for their patterns, of so many tries each, drawn by this seed.
PER_MESH_REDUCED, TRIES, SEED_REDUCED = 1_500, 4, 77

#: Trees of each number of quads, and their leaves.
ROUNDS, LEAVES = 150, 16

FOLDS = 2

#: Trees of the last ranking, their leaves, candidates of a leaf at least; the part of the columns
#: that each split looks at, what a tree counts, and what a leaf's slope is damped by.
RANKING_TREES, RANKING_LEAVES, LEAST_OF_LEAF = 150, 16, 30
COLUMNS, RATE, DAMPING = 0.4, 0.1, 1.0

#: Fills of a plain boundary that its ranking is trained on.
PLAIN_FILLS = 60

#: Strength of the logits' ridge.
RIDGE = 3.0

#: Mirrors of loops count by a number of their own (query.holes.symmetry), on top of the models.
NO_MIRRORS = np.zeros(0, np.int32)

Arrays = dict[str, NDArray[Any]]


@dataclass(slots=True)
class Example:
    """A hole for training. features: (L, f). logs: (L, 4) of a model that has not seen it."""

    cut: Cut
    around: Surroundings
    features: NDArray[np.float64]
    logs: NDArray[np.float64] | None = None


def read_index(folder: Path) -> list[dict[str, str]]:
    """The rows of a folder's INDEX.csv."""
    with (folder / "INDEX.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def list_families(folder: Path) -> list[list[Path]]:
    """The meshes of a folder in families of shared topology, as its INDEX.csv tells."""
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


def gather_examples(paths: list[Path], per_mesh: int, seed: int) -> list[Example]:
    """Cut holes from meshes, and measure what is around them."""
    found: list[Example] = []
    for path in paths:
        for cut in cut_holes(path.name, read_topology(str(path)), per_mesh, seed):
            around = look_around(cut.hole)
            found.append(Example(cut, around, measure_hole(cut.hole, around)))
        print(f"{path.name}: {len(found)} holes so far", file=sys.stderr, flush=True)
    return found


def fit_corners(examples: list[Example]) -> CornerModel:
    """Fit the trees to holes, every second one mirrored, and turn them into arrays."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    features = [
        (mirror_hole(one.features) if at % 2 else one.features).astype(np.float32)
        for at, one in enumerate(examples)
    ]
    counts = [one.cut.counts for one in examples]
    model = HistGradientBoostingClassifier(
        max_iter=ROUNDS,
        learning_rate=0.1,
        max_leaf_nodes=LEAVES,
        min_samples_leaf=40,
        l2_regularization=1.0,
        early_stopping=False,
        random_state=1,
    )
    model.fit(np.vstack(features), np.concatenate(counts))
    return export_trees(model)


def reduce_holes(path: Path) -> Counter[bytes]:
    """How many of a mesh's holes reduce to each pattern, by its code, packed."""
    found: Counter[bytes] = Counter()
    topology = read_topology(str(path))
    for cut in cut_holes(path.name, topology, PER_MESH_REDUCED, SEED_REDUCED, tries=TRIES):
        n = len(cut.counts)
        twin, _ = weld_quads(cut.quads, n + len(cut.inner), n)
        found[pack(canonical_code(reduce_disk(twin))[0])] += 1
    print(f"{path.name}: {len(found)} patterns of holes", file=sys.stderr, flush=True)
    return found


def gather_patterns(families: list[list[Path]], by_mesh: Mapping[str, Counter[bytes]]) -> Arrays:
    """The arrays of HolePatterns, most frequent first; families without holes do not count."""
    share: Counter[bytes] = Counter()
    kinds: Counter[bytes] = Counter()
    together = [sum((by_mesh[path.name] for path in one), Counter[bytes]()) for one in families]
    together = [one for one in together if one]
    for found in together:
        total = found.total() * len(together)
        for code, count in found.items():
            share[code] += count / total  # pyright: ignore[reportArgumentType]
            kinds[code] += 1
    codes = sorted(share, key=lambda code: (-share[code], code))
    return {
        "pattern_codes": np.frombuffer(b"".join(codes), np.uint8),
        "pattern_ends": np.cumsum([0, *map(len, codes)]).astype(np.int32),
        "pattern_meshes": np.array([kinds[code] for code in codes], np.int32),
        "pattern_share": np.array([share[code] for code in codes], np.float32),
    }


def export_trees(model: Any) -> CornerModel:
    """The arrays of a fitted model of scikit-learn, for the classes 1 to 4."""
    assert list(model.classes_) == [1, 2, 3, 4], "holes with one to four quads at a vertex"
    starts, features, thresholds, children, values = [0], [], [], [], []
    for round_ in model._predictors:
        for tree in round_:
            nodes = tree.nodes
            order = _breadth_first(nodes)
            place = {old: new for new, old in enumerate(order)}
            for old in order:
                node = nodes[old]
                leaf = bool(node["is_leaf"])
                features.append(-1 if leaf else int(node["feature_idx"]))
                thresholds.append(0.0 if leaf else float(node["num_threshold"]))
                children.append(0 if leaf else place[int(node["left"])])
                values.append(float(node["value"]) if leaf else 0.0)
                if not leaf:
                    assert place[int(node["right"])] == place[int(node["left"])] + 1
            starts.append(len(features))
    return CornerModel(
        np.array(starts, np.int32),
        np.array(features, np.int16),
        np.nextafter(np.array(thresholds, np.float32), np.float32(np.inf)),
        np.array(children, np.int16),
        np.array(values, np.float32),
        model._baseline_prediction.ravel().astype(np.float64),
    )


def join_models(models: list[CornerModel]) -> CornerModel:
    """The mean of models, as one: the scores of all their trees, each a part."""
    firsts = np.cumsum([0, *(len(one.feature) for one in models)])
    starts = [one.start[:-1] + first for one, first in zip(models, firsts, strict=False)]
    return CornerModel(
        np.concatenate([*starts, firsts[-1:]]).astype(np.int32),
        np.concatenate([one.feature for one in models]),
        np.concatenate([one.threshold for one in models]),
        np.concatenate([one.child for one in models]),
        np.concatenate([one.value for one in models]) / np.float32(len(models)),
        np.mean([one.base for one in models], axis=0),
    )


def _breadth_first(nodes: Any) -> list[int]:
    order = [0]
    for old in order:
        if not nodes[old]["is_leaf"]:
            order += [int(nodes[old]["left"]), int(nodes[old]["right"])]
    return order


def fit_logit(lists: list[tuple[NDArray[Any], int]]) -> list[NDArray[np.float64]]:
    """Fit mean, spread and weights of a conditional logit on (numbers (c, f), the chosen one)."""
    stacked = np.vstack([numbers for numbers, _ in lists])
    mean, spread = stacked.mean(axis=0), stacked.std(axis=0)
    spread[spread < 1e-9] = 1.0
    scaled = [((numbers - mean) / spread, own) for numbers, own in lists]

    def loss(weights: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        total, slope = RIDGE * float(weights @ weights) / 2, RIDGE * weights
        for numbers, own in scaled:
            scores = numbers @ weights
            top = scores.max()
            chance = np.exp(scores - top)
            chance /= chance.sum()
            total -= float(np.log(max(chance[own], 1e-300)))
            slope = slope + numbers.T @ chance - numbers[own]
        return total, slope

    found = minimize(loss, np.zeros(stacked.shape[1]), jac=True, method="L-BFGS-B")
    return [mean, spread, found.x]


def fit_assignments(examples: list[Example]) -> AssignmentModel:
    """Fit what tells the artist's quads at all vertices from those likely one by one."""
    lists: list[tuple[NDArray[Any], int]] = []
    for one in examples:
        assert one.logs is not None
        listed = rank_listed(one.logs, NO_MIRRORS)
        own = np.flatnonzero((listed == one.cut.counts).all(axis=1))
        if len(own):
            lists.append((measure_assignments(one.logs, one.around.due, listed), int(own[0])))
    print(f"assignments: {len(lists)} of {len(examples)} holes", file=sys.stderr)
    return AssignmentModel(*fit_logit(lists))


@dataclass(slots=True)
class Listed:
    """The candidates of a hole among which the artist's own is.

    facts: (c, FACTS). n_early: how many of them, the first ones, there are when the first fill is
    told. own: the place of the artist's.
    """

    around: Surroundings
    candidates: list[HoleCandidate]
    facts: NDArray[np.float64]
    n_early: int
    own: int


def ask_lists(
    examples: list[Example], database: Any, model: AssignmentModel, patterns: HolePatterns
) -> list[Listed]:
    """Ask for the candidates of holes; those whose own fill is not among them are left out."""
    lists: list[Listed] = []
    begin = time.perf_counter()
    for number, one in enumerate(examples, 1):
        assert one.logs is not None
        rim = HoleRim.of(one.cut.hole)
        due = one.around.due
        search = HoleSearch.begin(database, one.logs, due, model, patterns, rim, NO_MIRRORS)
        candidates: list[HoleCandidate] = []
        n_early = 0
        for candidate in search.all():
            candidates.append(candidate)
            if not n_early and search.assignments > ASKED_FIRST:
                n_early = len(candidates)
        keys = [candidate.key for candidate in candidates]
        if one.cut.key in keys:
            facts = tame_numbers(list_facts(candidates, one.around))
            own = keys.index(one.cut.key)
            lists.append(Listed(one.around, candidates, facts, n_early or len(candidates), own))
        if number % 40 == 0 or number == len(examples):
            seconds = time.perf_counter() - begin
            known = len(lists) / number
            print(f"{number} holes, {seconds:.0f} s, recall {known:.3f}", file=sys.stderr)
    return lists


def ask_plainly(examples: list[Example], database: Any) -> list[tuple[NDArray[Any], int]]:
    """For every hole that a plain query knows: numbers of its fills with the artist's corners, as
    if no mesh were around, and the artist's own place among them."""
    lists: list[tuple[NDArray[Any], int]] = []
    for one in examples:
        counts, n = one.cut.counts, len(one.cut.counts)
        corners = np.flatnonzero(counts != 2)
        if counts.max() > 3 or not len(corners):
            continue
        start = int(corners[0])
        points = np.roll(one.cut.hole.points, -start, axis=0)
        kinds: list[CornerKind] = ["convex" if counts[c] == 1 else "reflex" for c in corners]
        try:
            boundary = Boundary(np.diff(np.r_[corners, start + n]).tolist(), kinds, points=points)
        except InvalidBoundaryError:
            continue  # two vertices of the mesh lie in one place
        own, rows = None, []
        for place, fill in enumerate(fills(database, boundary, order="artist", limit=PLAIN_FILLS)):
            quads = np.where(fill.quads < n, (fill.quads + start) % n, fill.quads).astype(np.int32)
            twin, fault = weld_quads(quads, fill.n_vertices, n)
            if not fault and hash_quads(quads, twin, False) == one.cut.key:
                own = place
            rows.append(measure_plain_fill(fill, points))
        if own is not None:
            lists.append((tame_numbers(np.array(rows)), own))
    print(f"plain boundaries: {len(lists)} of {len(examples)} holes", file=sys.stderr)
    return lists


def fit_ranking(known: list[Listed]) -> Arrays:
    """Fit both stages: by facts alone, then by all numbers of those that the first puts first."""
    facts_model = fit_logit([(one.facts, one.own) for one in known])
    mean, spread, weights = facts_model
    whole: list[tuple[NDArray[Any], int]] = []
    early: list[tuple[NDArray[Any], int]] = []
    for one in known:
        order = np.argsort(-((one.facts - mean) / spread) @ weights, kind="stable")
        for chosen, lists in (
            (order[:PLACED], whole),
            (order[order < one.n_early][:PLACED_FIRST], early),
        ):
            if one.own in chosen:
                numbers = measure_placed(one, chosen)
                lists.append((numbers, int(np.flatnonzero(chosen == one.own)[0])))
    print(f"ranking: {len(known)} and {len(whole)} holes in its two stages", file=sys.stderr)
    linear = fit_logit(whole)
    trees = fit_trees([*whole, *early], linear)
    return (
        name_logit("facts", facts_model)
        | name_logit("whole", linear)
        | trees.to_arrays("whole_tree_")
    )


def measure_placed(one: Listed, chosen: NDArray[np.int64]) -> NDArray[np.float64]:
    """All numbers of some candidates."""
    placed = [
        place_fill(one.around, one.candidates[i].quads, one.candidates[i].n_vertices)
        for i in chosen.tolist()
    ]
    return tame_numbers(
        np.hstack([one.facts[chosen], np.array([lies.measures for lies in placed])])
    )


def fit_trees(
    lists: list[tuple[NDArray[Any], int]], linear: list[NDArray[np.float64]]
) -> TreeModel:
    """Boost trees on top of a logit: each a Newton step of its loss over all lists."""
    from sklearn.tree import DecisionTreeRegressor

    mean, spread, weights = linear
    size = np.array([len(numbers) for numbers, _ in lists])
    first = np.cumsum([0, *size])[:-1]
    of_list = np.repeat(np.arange(len(lists)), size)
    chosen = np.zeros(len(of_list))
    chosen[first + np.array([own for _, own in lists], np.int64)] = 1.0
    rows = np.vstack([compare_numbers(numbers) for numbers, _ in lists]).astype(np.float32)
    scores = ((np.vstack([numbers for numbers, _ in lists]) - mean) / spread) @ weights
    made: list[tuple[Any, NDArray[np.float64]]] = []
    for number in range(RANKING_TREES):
        chance = np.exp(scores - np.maximum.reduceat(scores, first)[of_list])
        chance /= np.add.reduceat(chance, first)[of_list]
        slope, bend = chance - chosen, np.maximum(chance * (1.0 - chance), 1e-6)
        tree = DecisionTreeRegressor(
            max_leaf_nodes=RANKING_LEAVES,
            min_samples_leaf=LEAST_OF_LEAF,
            max_features=COLUMNS,
            random_state=number,
        ).fit(rows, -slope / bend, sample_weight=bend)
        leaf, nodes = tree.apply(rows), tree.tree_.node_count
        total = np.bincount(leaf, slope, nodes), np.bincount(leaf, bend, nodes)
        steps = -RATE * total[0] / (total[1] + DAMPING)
        scores += steps[leaf]
        made.append((tree.tree_, steps))
    return join_trees(made)


def join_trees(made: list[tuple[Any, NDArray[np.float64]]]) -> TreeModel:
    """Trees of scikit-learn, each with what its leaves add, as arrays."""
    starts, features, thresholds, children, values = [0], [], [], [], []
    for tree, steps in made:
        order = [0]
        for old in order:
            if tree.children_left[old] >= 0:
                order += [int(tree.children_left[old]), int(tree.children_right[old])]
        place = {old: new for new, old in enumerate(order)}
        for old in order:
            leaf = tree.children_left[old] < 0
            features.append(-1 if leaf else int(tree.feature[old]))
            thresholds.append(0.0 if leaf else float(tree.threshold[old]))
            children.append(0 if leaf else place[int(tree.children_left[old])])
            values.append(float(steps[old]) if leaf else 0.0)
        starts.append(len(features))
    return TreeModel(
        np.array(starts, np.int32),
        np.array(features, np.int16),
        np.array(thresholds, np.float32),
        np.array(children, np.int16),
        np.array(values, np.float32),
        np.zeros(1),
    )


def name_logit(name: str, parts: list[NDArray[np.float64]]) -> Arrays:
    """The arrays of a logit, as HoleModels reads them."""
    names = (f"{name}_{part}" for part in ("mean", "spread", "weights"))
    return dict(zip(names, parts, strict=True))


def thin_out(examples: list[Example], per_mesh: int) -> list[Example]:
    """The first ``per_mesh`` holes of each mesh."""
    count: dict[str, int] = {}
    kept: list[Example] = []
    for one in examples:
        count[one.cut.mesh] = count.get(one.cut.mesh, 0) + 1
        if count[one.cut.mesh] <= per_mesh:
            kept.append(one)
    return kept


def train_all(
    given: argparse.Namespace,
    families: list[list[Path]],
    left_out: set[str],
    by_mesh: Mapping[str, Counter[bytes]],
) -> Arrays:
    """Train everything but the patterns, fold by fold."""
    folds = deal_folds(families, given.folds, given.seed)
    by_fold = [gather_examples(fold, given.per_mesh, given.seed) for fold in folds]
    models: list[CornerModel] = []
    for i, held in enumerate(by_fold):
        others = [one for j, fold in enumerate(by_fold) if j != i for one in fold]
        model = fit_corners(others)
        models.append(model)
        loss, right = 0.0, 0
        for one in held:
            one.logs = model.log_probabilities(one.features)
            loss -= float(one.logs[np.arange(len(one.logs)), one.cut.counts - 1].mean())
            right += bool((one.logs.argmax(axis=1) + 1 == one.cut.counts).all())
        print(
            f"fold {i + 1}: {len(others)} holes for training, {len(held)} held back: loss "
            f"{loss / len(held):.4f}, all right {right / len(held):.3f}",
            file=sys.stderr,
        )
    together = fit_assignments([one for fold in by_fold for one in fold])
    lists: list[Listed] = []
    plain: list[tuple[NDArray[Any], int]] = []
    with tempfile.TemporaryDirectory(dir=given.output.parent) as work:
        for fold, examples in zip(folds, by_fold, strict=True):
            path = Path(work) / "without.db"
            path.unlink(missing_ok=True)
            shutil.copyfile(given.db, path)
            unseen = left_out | {mesh.name for mesh in fold}
            with patterndb.open(path, "write") as database:
                database.remove([m.name for m in database.meshes() if m.name in unseen])
            with patterndb.open(path) as database:
                asked = thin_out(examples, given.per_mesh_asked)
                others = [family for family in families if family[0] not in fold]
                patterns = HolePatterns.from_arrays(gather_patterns(others, by_mesh))
                lists += ask_lists(asked, database, together, patterns)
                plain += ask_plainly(asked, database)
    arrays = name_logit("assignments", [together.mean, together.spread, together.weights])
    arrays |= join_models(models).to_arrays()
    return arrays | fit_ranking(lists) | name_logit("plain", fit_logit(plain))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--db", type=Path, help="a database of all the meshes")
    parser.add_argument("--leave-out", type=Path, help="a file of names: further meshes not to see")
    parser.add_argument("--patterns-only", type=Path, metavar="FILE")
    parser.add_argument("--per-mesh", type=int, default=PER_MESH)
    parser.add_argument("--per-mesh-asked", type=int, default=PER_MESH_ASKED)
    parser.add_argument("--folds", type=int, default=FOLDS)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("-o", "--output", type=Path, required=True)
    given = parser.parse_args()
    if (given.db is None) == (given.patterns_only is None):
        parser.error("give --db to train all models, or --patterns-only to keep those of a file")
    left_out = set(given.leave_out.read_text().split()) if given.leave_out else set[str]()
    left_out |= {row["file"] for row in read_index(given.folder) if row["licence"] not in FREE}
    families = [
        kept
        for family in list_families(given.folder)
        if (kept := [path for path in family if path.name not in left_out])
    ]
    paths = [path for family in families for path in family]
    by_mesh = {path.name: reduce_holes(path) for path in paths}
    if given.patterns_only is None:
        arrays = train_all(given, families, left_out, by_mesh)
    else:
        with np.load(given.patterns_only, allow_pickle=False) as old:
            arrays = {name: old[name] for name in old.files}
    arrays |= gather_patterns(families, by_mesh)
    np.savez_compressed(given.output, **arrays)
    print(f"{given.output}: {given.output.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
