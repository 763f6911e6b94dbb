"""Holes cut from artists' meshes: how often is the artist's own fill proposed first?

    python scripts/train_holes.py ../shared/data/meshes -o holes.npz --folds-to folds
    python benchmarks/holes.py ../shared/data/meshes --folds folds --kind everyday --per-mesh 10
    python benchmarks/holes.py ../shared/data/meshes --folds folds --kind irregular --orders
    python benchmarks/holes.py ../shared/data/meshes --only NAMES.txt --db others.db --models m.npz
    python benchmarks/holes.py ../shared/data/meshes --folds folds --kind both --count 3000 \
        --limit 1
    options: --seed 11  --per-mesh 20  --twins

Everyday holes are cut as people delete faces: a face, a strip, those around a vertex, a block, a
face or vertex grown once or twice. Irregular ones have 6 to 120 quads and one irregular vertex or
more. With --folds each mesh is asked about with the models and the database of its fold, which have
not seen it; with none of --folds, --db and --models, with those that ship, which have seen most.
--count gives the number of holes of all meshes together instead of --per-mesh, half of each kind.

Each hole is asked for twenty fills (--limit), which are checked: each is a disk of quads on the
hole's loop, and welded, no old vertex has moved, faces that stay are those that were, and every
edge of the loop has two faces. First fills are checked for flipped and twisted quads, edges that
pierce them, and slivers. Milliseconds are those of the processor. --orders compares the order with
others: the same candidates with the fewest irregular vertices first, as patchgen has them, those
that artists made most first, and plain queries. Prints Markdown.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import patterndb
from patterndb._native.query.recognition import weld_quads
from patterndb.core.halfedge import Int32Array
from query import Boundary, fills
from query.boundary import CornerKind
from query.holes import HoleFill, fill_holes
from query.holes.models import HoleModels
from query.holes.neighbourhood import extract_neighbourhood, list_faces_near
from query.holes.topology import MeshTopology
from query.recognition import hash_quads

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
from cut_holes import Cut, cut_everyday, cut_holes, read_topology

TOP = (1, 5, 20)

#: A quad is a sliver where it is so many times as long as wide.
SLIVER = 20.0


def check_fill(fill: HoleFill) -> list[str]:
    """What is wrong with a fill; nothing should be."""
    found: list[str] = []
    n = len(fill.hole)
    _, fault = weld_quads(fill.local, n + len(fill.points), n)
    if fault:
        found.append(f"no disk ({fault})")
    old = fill.hole.topology.mesh
    new = fill.weld()
    if new.points[: len(old.points)].tobytes() != old.points.tobytes():
        found.append("an old vertex moved")
    stays = np.ones(old.n_faces, np.bool_)
    stays[fill.hole.removed] = False
    kept = old.corners[np.repeat(stays, old.arities())]
    if (new.corners[: len(kept)] != kept).any() or (new.arities()[stays.sum() :] != 4).any():
        found.append("a face that stays has changed, or a new one is no quad")
    topology = MeshTopology.of(new)
    if topology.crowded.any() and not fill.hole.topology.crowded.any():
        found.append("an edge has more than two faces")
    border = int((topology.twin < 0).sum())
    removed = fill.hole.removed
    before = int((fill.hole.topology.twin < 0).sum())
    if border != before - (0 if len(removed) else n):
        found.append("the hole is still open")
    return found


def key_of(fill: HoleFill) -> bytes:
    """What tells a fill from any other of its loop."""
    n = len(fill.hole)
    twin, _ = weld_quads(fill.local, n + len(fill.points), n)
    return hash_quads(fill.local, twin, False)


def measure_distance(fill: HoleFill, cut: Cut) -> float:
    """Mean distance of the new vertices from the artist's own quads, in mean edges of the loop."""
    from patterndb.geometry.surface import Surface

    if not len(fill.points):
        return 0.0
    points = np.concatenate([cut.hole.points, cut.hole.topology.mesh.points[cut.inner]])
    triangles = np.concatenate([cut.quads[:, :3], cut.quads[:, [0, 2, 3]]])
    feet = Surface.from_arrays(points, triangles).nearest(fill.points)
    edge = cut.hole.length / len(cut.hole)
    return float(np.linalg.norm(feet.points - fill.points, axis=1).mean()) / edge


def ask(cut: Cut, db: Any, models: Any, twins: bool, most: int | None) -> dict[str, Any]:
    """Ask about one hole: where the artist's fill stands in each order, and what the first is."""
    begin = time.process_time()
    source = fill_holes(db, cut.hole, limit=most, twins=twins, models=models)
    first = next(source, None)
    first_ms = 1e3 * (time.process_time() - begin)
    found = [] if first is None else [first]
    all_ms = first_ms
    for fill in source:
        found.append(fill)
        if len(found) <= TOP[-1]:
            all_ms = 1e3 * (time.process_time() - begin)
    keys = [key_of(fill) for fill in found]

    def rank(order: list[int]) -> int | None:
        listed = [keys[i] for i in order]
        return listed.index(cut.key) if cut.key in listed else None

    every = list(range(len(found)))
    own = [i for i in every if not found[i].twin]
    return {
        "rank": rank(every),
        "regular": rank(sorted(own, key=lambda i: (found[i].n_irregular, i))),
        "artist": rank(
            sorted(
                own, key=lambda i: (-(found[i].fill.pattern.frequency if found[i].fill else 0), i)
            )
        ),
        "first": first,
        "needless": bool(first and first.flipped and any(not fill.flipped for fill in found)),
        "listed": min(len(found), TOP[-1]),
        "faults": [fault for fill in found[: TOP[-1]] for fault in check_fill(fill)],
        "first_ms": first_ms,
        "all_ms": all_ms,
        "corners": any((fill.corners == cut.counts).all() for fill in found),
        "twin": bool(found and found[0].twin),
    }


def describe_shape(fill: HoleFill) -> dict[str, bool]:
    """Return what is wrong with how a fill lies: flipped or twisted quads, slivers, or quads that
    an edge of the fill, or of a face around it, pierces."""
    mesh = fill.hole.topology.mesh
    points = np.concatenate([mesh.points, fill.points])
    corner = points[fill.quads]
    ahead = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    at_corner = np.cross(ahead, -np.roll(ahead, 1, axis=1))
    outward = (at_corner * normal[:, None]).sum(axis=2)
    length = np.linalg.norm(ahead, axis=2)
    across = np.maximum(length[:, 0] + length[:, 2], 1e-300)
    ratio = across / np.maximum(length[:, 1] + length[:, 3], 1e-300)
    return {
        "flipped": fill.flipped > 0,
        "twisted": bool((outward.min(axis=1) < 0).any()),
        "slivers": bool((np.maximum(ratio, 1 / ratio) > SLIVER).any()),
        "pierced": is_pierced(points, fill),
    }


def list_oddities(fill: HoleFill) -> list[str]:
    """List what is wrong with how a fill lies, in a word each."""
    return [fault for fault, found in describe_shape(fill).items() if found]


def is_pierced(points: Any, fill: HoleFill) -> bool:
    """Does an edge of a fill, or of a face around it, pierce a quad of the fill?"""
    quads = fill.quads
    every = fill.hole.topology.mesh.faces()
    around = [list(every[f]) for f in list_faces_near(fill.hole, 2)]
    faces = [*quads.tolist(), *around]
    pairs = {(min(a, b), max(a, b)) for f in faces for a, b in zip(f, [*f[1:], f[0]], strict=True)}
    edges = np.array(sorted(pairs))
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    e, t = (grid.ravel() for grid in np.meshgrid(*map(np.arange, (len(edges), len(triangles)))))
    apart = (edges[e][:, :, None] != triangles[t][:, None, :]).all(axis=(1, 2))
    e, t = e[apart], t[apart]
    start, way = points[edges[e, 0]], points[edges[e, 1]] - points[edges[e, 0]]
    corner = points[triangles[t, 0]]
    one, two = points[triangles[t, 1]] - corner, points[triangles[t, 2]] - corner
    across = np.cross(way, two)
    size = (one * across).sum(axis=1)
    level = np.abs(size) <= 1e-9 * (np.linalg.norm(one, axis=1) * np.linalg.norm(across, axis=1))
    size = np.where(level, 1.0, size)
    off = start - corner
    u = (off * across).sum(axis=1) / size
    turned = np.cross(off, one)
    v = (way * turned).sum(axis=1) / size
    place = (two * turned).sum(axis=1) / size
    near = 1e-6
    return bool(
        (
            ~level
            & (u > near)
            & (v > near)
            & (u + v < 1 - near)
            & (place > near)
            & (place < 1 - near)
        ).any()
    )


def ask_plain(cut: Cut, db: Any, counts: Int32Array, order: str) -> int | None:
    """Where the artist's fill stands among twenty of a plain query, corners as given."""
    n = len(counts)
    if counts.max() > 3:
        return None  # plain queries know corners of one and of three quads
    corners = np.flatnonzero(counts != 2)
    start = int(corners[0]) if len(corners) else 0
    kinds: list[CornerKind] = ["convex" if counts[c] == 1 else "reflex" for c in corners]
    sides = np.diff(np.r_[corners, start + n]) if len(corners) else [n]
    boundary = Boundary(sides, kinds, points=np.roll(cut.hole.points, -start, axis=0))
    for rank, fill in enumerate(fills(db, boundary, order=order, limit=TOP[-1])):
        for turn in [start] if len(corners) else range(n):
            quads = np.where(fill.quads < n, (fill.quads + turn) % n, fill.quads).astype(np.int32)
            twin, fault = weld_quads(quads, fill.n_vertices, n)
            if not fault and hash_quads(quads, twin, False) == cut.key:
                return rank
    return None


def share(ranks: list[int | None], k: int) -> str:
    return f"{np.mean([r is not None and r < k for r in ranks]):.3f}" if ranks else "–"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", type=Path, help="a file of names")
    parser.add_argument("--folds", type=Path, help="what scripts/train_holes.py --folds-to wrote")
    parser.add_argument("--db", type=Path)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--kind", choices=("everyday", "irregular", "both"), default="irregular")
    parser.add_argument("--limit", type=int, default=TOP[-1], help="fills asked of each hole")
    parser.add_argument("--per-mesh", type=int, default=20)
    parser.add_argument("--count", type=int, help="holes of all meshes together")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--twins", action="store_true")
    parser.add_argument("--orders", action="store_true", help="compare with other orders; slow")
    given = parser.parse_args()
    names = {path.name for path in given.folder.glob("*.obj")}
    if given.only is not None:
        names &= set(given.only.read_text().split())
    if given.count is not None:
        kinds = 2 if given.kind == "both" else 1
        given.per_mesh = math.ceil(given.count / max(len(names), 1) / kinds)
    parts: list[tuple[Path | None, Path | None, set[str]]] = [(given.db, given.models, names)]
    if given.folds is not None:
        parts = [
            (
                path.with_suffix(".db"),
                path,
                names & set(path.with_suffix(".txt").read_text().split()),
            )
            for path in sorted(given.folds.glob("fold*.npz"))
        ]
    rows: list[tuple[Cut, dict[str, Any]]] = []
    for database, models, chosen in parts:
        loaded = None
        if models is not None:
            with models.open("rb") as file:
                loaded = HoleModels.load(file)
        with patterndb.open(database) as db:
            for name in sorted(chosen):
                rows += ask_mesh(given, given.folder / name, db, loaded)
                print(f"{name}: {len(rows)} holes", file=sys.stderr, flush=True)
    print_recall(rows)
    if given.orders:
        print_orders(rows)
    for title in ("everyday", "irregular"):
        print_first(
            title, [row for row in rows if (row[0].kind == "irregular") == (title == "irregular")]
        )


def ask_mesh(
    given: argparse.Namespace, path: Path, db: Any, models: HoleModels | None
) -> list[tuple[Cut, dict[str, Any]]]:
    """Cut holes into a mesh, and ask about them."""
    topology = read_topology(str(path))
    cuts: list[Cut] = []
    if given.kind != "irregular":
        cuts += cut_everyday(path.name, topology, given.per_mesh, given.seed, tries=20)
    if given.kind != "everyday":
        cuts += cut_holes(path.name, topology, given.per_mesh, given.seed, tries=20)
    rows: list[tuple[Cut, dict[str, Any]]] = []
    for hole in cuts:
        row = ask(hole, db, models, given.twins, None if given.orders else given.limit)
        rows.append((hole, row))
        odd = [] if row["first"] is None else list_oddities(row["first"])
        for fault in (*row["faults"], *(f"the first fill is {one}" for one in odd)):
            loop = ",".join(map(str, hole.hole.loop.tolist()))
            print(f"{path.name}, the hole {loop}: {fault}", file=sys.stderr, flush=True)
        if given.orders:
            asked = np.clip(extract_neighbourhood(hole.hole).regular_valence, 1, 3)
            row["today"] = ask_plain(hole, db, asked, "artist")
            for order in ("artist", "regular", "fit"):
                row[f"given {order}"] = ask_plain(hole, db, hole.counts, order)
    return rows


def print_recall(rows: list[tuple[Cut, dict[str, Any]]]) -> None:
    """Print hit@1, @5, @20 by kind, irregular vertices inside, quads, corners."""
    print("| | holes | hit@1 | @5 | @20 |\n|---|--:|--:|--:|--:|")
    kinds = sorted({cut.kind for cut, _ in rows})
    groups: list[tuple[str, Any]] = [
        ("all", lambda c: True),
        *((kind, lambda c, kind=kind: c.kind == kind) for kind in kinds if len(kinds) > 1),
        *((f"{a} to {b} irregular inside" if a < b else f"{a} irregular inside",
           lambda c, a=a, b=b: a <= c.inside <= b)
          for a, b in ((0, 0), (1, 1), (2, 2), (3, 4), (5, 8), (9, 999))),
        *((f"{a} to {b} edges", lambda c, a=a, b=b: a <= len(c.counts) <= b)
          for a, b in ((4, 4), (6, 8), (10, 14), (16, 24), (26, 999))),
        ("four quads at a loop vertex", lambda c: int(c.counts.max()) == 4),
    ]  # fmt: skip
    for title, test in groups:
        ranks = [one["rank"] for cut, one in rows if test(cut)]
        if ranks:
            print(f"| {title} | {len(ranks)} | " + " | ".join(share(ranks, k) for k in TOP) + " |")


def print_orders(rows: list[tuple[Cut, dict[str, Any]]]) -> None:
    """Print hit@1, @5, @20 of other orders, and why fills are missed."""
    print("\n| order | holes | hit@1 | @5 | @20 |\n|---|--:|--:|--:|--:|")
    for title, name in (
        ("as listed", "rank"),
        ("fewest irregular first", "regular"),
        ("most frequent first", "artist"),
        ("plain query, corners as the surroundings ask, order artist", "today"),
        ("plain query, the artist's corners, order artist", "given artist"),
        ("plain query, the artist's corners, order regular", "given regular"),
        ("plain query, the artist's corners, order fit", "given fit"),
    ):
        ranks = [one[name] for _, one in rows]
        print(f"| {title} | {len(rows)} | " + " | ".join(share(ranks, k) for k in TOP) + " |")
    missed = [(c, r) for c, r in rows if r["rank"] is None or r["rank"] >= TOP[-1]]
    why = Counter(
        "ranked later"
        if r["rank"] is not None
        else "corners"
        if not r["corners"]
        else "not a candidate"
        for _, r in missed
    )
    print(f"\nmissed among twenty: {dict(why)}")


def print_first(title: str, rows: list[tuple[Cut, dict[str, Any]]]) -> None:
    """Print how first fills of one kind of holes lie, faults, and milliseconds."""
    if not rows:
        return
    first = [r["first"] for _, r in rows if r["first"] is not None]
    distance = [measure_distance(r["first"], c) for c, r in rows if r["first"] is not None]
    poles = [r["first"].n_irregular - c.irregular for c, r in rows if r["first"] is not None]
    ms = np.array([(r["first_ms"], r["all_ms"]) for _, r in rows])
    shapes = Counter(fault for f in first for fault in list_oddities(f))
    print(
        f"\n{title}: {len(rows)} holes of {len({cut.mesh for cut, _ in rows})} meshes: "
        f"unanswered {len(rows) - len(first)}; twins {sum(r['twin'] for _, r in rows)}; "
        f"faults {sum(len(r['faults']) for _, r in rows)} "
        f"in {sum(r['listed'] for _, r in rows)} fills"
    )
    print(
        f"first fills: flipped quads in {shapes['flipped']}, where a listed fill has none in "
        f"{sum(r['needless'] for _, r in rows)}; twisted quads in {shapes['twisted']}; quads "
        f"pierced by an edge in {shapes['pierced']}; quads longer than {SLIVER:g} times their "
        f"width in {shapes['slivers']}; irregular vertices less the artist's "
        f"{np.mean(poles):+.2f}; "
        f"the artist's own {share([r['rank'] for _, r in rows], 1)}; "
        f"distance {np.mean(distance):.3f} edges in the mean, "
        f"{np.percentile(distance, 95):.3f} at 95 %"
    )
    print(
        "CPU milliseconds, median and 95 %: first "
        f"{np.median(ms[:, 0]):.0f}, {np.percentile(ms[:, 0], 95):.0f}; "
        f"twenty {np.median(ms[:, 1]):.0f}, {np.percentile(ms[:, 1], 95):.0f}"
    )


if __name__ == "__main__":
    main()
