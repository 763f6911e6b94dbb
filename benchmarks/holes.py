"""Holes cut from artists' meshes: how often is the artist's own fill proposed first?

    python benchmarks/holes.py ../shared/data/meshes --only benchmarks/holes_left_out_random.txt \\
        --db others.db --models left_out.npz
    options: --per-mesh 20  --seed 11  --no-twins
    python benchmarks/holes.py ../shared/data/meshes --listed --per-mesh 125

The database and the models must not have learned the meshes that are asked: scripts/train_holes.py
--leave-out trains such models, and ``patterndb remove`` takes meshes out of a database. Side by
side: the ranking of the program; the same candidates with the fewest irregular vertices first, as
patchgen has them; and those that artists made most first. The first twenty fills are checked: each
is a disk of quads on the hole's loop, and welded, no old vertex has moved, faces that stay are
those that were, and every edge of the loop has two faces. Prints Markdown.

With --listed each hole is asked for twenty fills and nothing else, for many holes: what is
unanswered, what is wrong with a fill, what the first ones are like.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import patterndb
from patterndb.core.halfedge import Int32Array
from query import Boundary, fills
from query.boundary import CornerKind
from query.holes import HoleFill, fill_holes
from query.holes.loops import MeshTopology
from query.holes.models import HoleModels
from query.holes.surroundings import look_around
from query.identity import hash_quads, weld_quads

sys.path.insert(0, str(Path(__file__).parents[1] / "scripts"))
from cut_holes import Cut, cut_holes, read_topology

TOP = (1, 5, 20)


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
    """Ask one hole: where the artist's fill stands in each order, and what the first is like."""
    begin = time.perf_counter()
    source = fill_holes(db, cut.hole, limit=most, twins=twins, models=models)
    first = next(source, None)
    first_ms = 1e3 * (time.perf_counter() - begin)
    found = [] if first is None else [first]
    for fill in source:
        found.append(fill)
        if len(found) == TOP[-1]:
            all_ms = 1e3 * (time.perf_counter() - begin)
    if len(found) < TOP[-1]:
        all_ms = 1e3 * (time.perf_counter() - begin)
    keys = [key_of(fill) for fill in found]

    def rank(order: list[int]) -> int | None:
        listed = [keys[i] for i in order]
        return listed.index(cut.key) if cut.key in listed else None

    every = list(range(len(found)))
    own = [i for i in every if not found[i].twin]
    return {
        "rank": rank(every),
        "sound": rank(sorted(every, key=lambda i: (found[i].flipped > 0, i))),
        "regular": rank(sorted(own, key=lambda i: (found[i].n_irregular, i))),
        "artist": rank(
            sorted(
                own, key=lambda i: (-(found[i].fill.pattern.frequency if found[i].fill else 0), i)
            )
        ),
        "first": first,
        "listed": min(len(found), TOP[-1]),
        "faults": [fault for fill in found[: TOP[-1]] for fault in check_fill(fill)],
        "first_ms": first_ms,
        "all_ms": all_ms,
        "corners": any((fill.corners == cut.counts).all() for fill in found),
        "twin": bool(found and found[0].twin),
    }


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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", type=Path)
    parser.add_argument("--db", type=Path)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--per-mesh", type=int, default=20)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--no-twins", action="store_true")
    parser.add_argument("--listed", action="store_true")
    given = parser.parse_args()
    models = None
    if given.models is not None:
        with given.models.open("rb") as file:
            models = HoleModels.load(file)
    names = None if given.only is None else set(given.only.read_text().split())
    rows: list[tuple[Cut, dict[str, Any]]] = []
    with patterndb.open(given.db) as db:
        for path in sorted(given.folder.glob("*.obj")):
            if names is not None and path.name not in names:
                continue
            for cut in cut_holes(path.name, read_topology(str(path)), given.per_mesh, given.seed):
                most = TOP[-1] if given.listed else None
                row = ask(cut, db, models, not given.no_twins, most)
                rows.append((cut, row))
                for fault in row["faults"]:
                    loop = ",".join(map(str, cut.hole.loop.tolist()))
                    print(f"{path.name}, the hole {loop}: {fault}", file=sys.stderr, flush=True)
                if given.listed:
                    continue
                asked = np.clip(look_around(cut.hole).due, 1, 3)
                row["today"] = ask_plain(cut, db, asked, "artist")
                for order in ("artist", "regular", "fit"):
                    row[f"given {order}"] = ask_plain(cut, db, cut.counts, order)
            print(f"{path.name}: {len(rows)} holes", file=sys.stderr, flush=True)
    if not given.listed:
        print_orders(rows)
    print_first(rows)


def print_orders(rows: list[tuple[Cut, dict[str, Any]]]) -> None:
    print("| | holes | hit@1 | @5 | @20 |\n|---|--:|--:|--:|--:|")
    for title, name in (
        ("as listed", "rank"),
        ("as listed, those with flipped quads last", "sound"),
        ("fewest irregular first", "regular"),
        ("most frequent first", "artist"),
        ("plain query, corners as the surroundings ask, order artist", "today"),
        ("plain query, the artist's corners, order artist", "given artist"),
        ("plain query, the artist's corners, order regular", "given regular"),
        ("plain query, the artist's corners, order fit", "given fit"),
    ):
        ranks = [one[name] for _, one in rows]
        print(f"| {title} | {len(rows)} | " + " | ".join(share(ranks, k) for k in TOP) + " |")
    groups: list[tuple[str, Any]] = [
        *((f"N = {n}", lambda c, n=n: int((c.counts != 2).sum()) == n) for n in range(9)),
        ("N > 8", lambda c: int((c.counts != 2).sum()) > 8),
        *((f"{a}..{b} quads", lambda c, a=a, b=b: a <= len(c.quads) <= b)
          for a, b in ((6, 8), (9, 12), (13, 20), (21, 40), (41, 120))),
        *((f"{a}..{b} irregular" if a < b else f"{a} irregular",
           lambda c, a=a, b=b: a <= c.irregular <= b)
          for a, b in ((1, 1), (2, 2), (3, 4), (5, 8), (9, 99))),
        ("four quads at a loop vertex", lambda c: int(c.counts.max()) == 4),
    ]  # fmt: skip
    for title, test in groups:
        ranks = [one["rank"] for cut, one in rows if test(cut)]
        print(f"| {title} | {len(ranks)} | " + " | ".join(share(ranks, k) for k in TOP) + " |")
    missed = [(c, r) for c, r in rows if r["rank"] is None or r["rank"] >= TOP[-1]]
    why = Counter(
        "ranked later"
        if r["rank"] is not None
        else "corners"
        if not r["corners"]
        else "no such fill"
        for _, r in missed
    )
    print(f"\nmissed among twenty: {dict(why)}")


def print_first(rows: list[tuple[Cut, dict[str, Any]]]) -> None:
    first = [r["first"] for _, r in rows if r["first"] is not None]
    distance = [measure_distance(r["first"], c) for c, r in rows if r["first"] is not None]
    poles = [r["first"].n_irregular - c.irregular for c, r in rows if r["first"] is not None]
    ms = np.array([(r["first_ms"], r["all_ms"]) for _, r in rows])
    print(
        f"\n{len(rows)} holes of {len({cut.mesh for cut, _ in rows})} meshes: "
        f"unanswered {len(rows) - len(first)}; twins {sum(r['twin'] for _, r in rows)}; "
        f"faults {sum(len(r['faults']) for _, r in rows)} "
        f"in {sum(r['listed'] for _, r in rows)} fills; the artist's own first, among five and "
        f"twenty {' '.join(share([r['rank'] for _, r in rows], k) for k in TOP)}"
    )
    print(
        f"first fills: flipped quads in {sum(f.flipped > 0 for f in first)}; irregular vertices "
        f"less the artist's {np.mean(poles):+.2f}; "
        f"distance {np.mean(distance):.3f} edges in the mean, "
        f"{np.percentile(distance, 95):.3f} at 95 %"
    )
    print(
        f"milliseconds: first {np.median(ms[:, 0]):.0f} (95 %: {np.percentile(ms[:, 0], 95):.0f}), "
        f"twenty {np.median(ms[:, 1]):.0f} (95 %: {np.percentile(ms[:, 1], 95):.0f})"
    )


if __name__ == "__main__":
    main()
