"""Random calls of all tools of retopology, with undo and redo between, and what must hold.

    python benchmarks/retopo_editing.py --calls 10000 --seed 1 --surface plane
    python benchmarks/retopo_editing.py --calls 1000 --surface spot.obj --verbose

Calls are made from the table of tools: plausible strokes and places, mostly near what is there, and
now and then absurd values, unknown names and missing arguments. After each call the network's
invariants hold, and it goes round no more handles than the surface has (Euler's formula); a refused
call, or one of bad arguments, leaves the state as it was; undo and redo give earlier states bit
for bit; now and then patches are filled, and the session is written and read back. Nothing but
InvalidRetopoError, for bad arguments, is raised. A new drawing is begun every so many calls.

Prints one JSON document, the slowest calls by the processor's seconds, with what is then checked;
exits 1 if there were failures, each with the script that leads there. How far it is goes to
stderr, every half minute. Ctrl-C, or the signal TERM, ends it after the call that is under way:
the document is then of the calls so far, and the exit code is 130.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import resource
import signal
import sys
import time
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import trimesh

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.arguments import (
    REQUIRED,
    Argument,
    Flag,
    Number,
    PointList,
    Vector,
    Word,
    WordOrNumber,
)
from patterndb_sketch.retopo.editor import DEPTH, TOOLS, Call, Retopology, State
from patterndb_sketch.retopo.errors import InvalidRetopoError
from patterndb_sketch.retopo.network import check_network, count_genus, count_handles
from patterndb_sketch.retopo.script import line_of
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession
from query.engine import PatternSource

#: Calls after which a new drawing is begun, and chains that are enough for one.
CALLS_A_DRAWING = 200
MANY_CHAINS = 80

#: Chains with which there is still room for what needs it.
FEW_CHAINS = 8

#: How often: a value is absurd, an argument that may be left out is given, patches are filled,
#: and the session is written and read.
ABSURD, OPTIONAL, FILLED, SAVED = 0.03, 0.3, 0.15, 0.03

#: Seconds by the clock after which it is told how far calls are.
TOLD_AFTER = 30.0

#: How often each call is made beside those of the table, which have 1.
OFTEN = {"stroke": 6.0, "spine": 2.0, "loop": 2.0, "autocomplete": 2.0, "undo": 3.0, "redo": 2.0}
OFTEN |= {"sizes": 0.3, "recount": 0.5}

#: Arguments that go together, where most others make no call.
TOGETHER: dict[str, tuple[tuple[str, ...], ...]] = {
    "erase": (("points",), ("at",), ("open",)),
    "subdivide": (("at", "count"), ("at", "by"), ("at", "by", "strip"), ("at", "free")),
    "flow": (("points",), ("clear",)),
    "choose": (("at", "by"), ("at", "number")),
    "density": (("points",), ("at",), ("at", "how", "times"), ("anew",)),
}

NUMBER = r"-?\d[\d.,e+-]*"

ABSURDITIES: tuple[object, ...] = (
    None, True, -1, 0, 1e300, -1e300, 1e-300, float("nan"), float("inf"), "left", [], [0, 0, 0],
    [1e300, 0, 0], [[0, 0, 0]], [[0, 0, 0], [0, 0, 0]], [[1e200, 0, 0], [0, 1e200, 0]], {}, 10**30,
    [[0, 0, 0], [0, float("nan"), 0]], [[5, 5, 5], [6, 6, 6], [7, 7, 7]],
)  # fmt: skip


def surface_of(name: str) -> Surface:
    """The surface of a name, or in a file."""
    if name == "plane":
        steps = np.linspace(-1.0, 1.0, 41)
        x, y = np.meshgrid(steps, steps, indexing="ij")
        at = np.arange(x.size).reshape(x.shape)
        a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
        triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
        return Surface.from_arrays(
            np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1), triangles
        ).orient()
    if name == "ball":
        return Surface.of(trimesh.creation.icosphere(subdivisions=3)).orient()
    return Surface.from_polygons(read_mesh(Path(name))).orient()


class Caller:
    """Makes random calls for what an editor has now."""

    def __init__(self, editor: Retopology, rng: np.random.Generator) -> None:
        self.editor = editor
        self.rng = rng

    def call(self) -> Call:
        names = [*TOOLS, "undo", "redo"]
        weights = np.array([OFTEN.get(name, 1.0) for name in names])
        if len(self.editor.network.chains) < FEW_CHAINS:
            weights += [4.0 * (name in ("spine", "cylinder")) for name in names]
        if len(self.editor.network.chains) > MANY_CHAINS:
            weights = np.array([float(name in ("erase", "undo")) for name in names])
        name = str(self.rng.choice(names, p=weights / weights.sum()))
        known = TOOLS[name].arguments if name in TOOLS else {}
        given: dict[str, object] = {}
        ways = TOGETHER.get(name)
        chosen = ways[self.rng.integers(len(ways))] if ways and self.rng.random() < 0.8 else None
        for one, argument in known.items():
            wanted = one in chosen if chosen else self.rng.random() < OPTIONAL
            if argument.default is REQUIRED or wanted:
                given[one] = self.value(name, argument)
            if self.rng.random() < ABSURD:
                given[one] = ABSURDITIES[self.rng.integers(len(ABSURDITIES))]
        if given and self.rng.random() < ABSURD / 3:
            given.pop(next(iter(given)))
        if self.rng.random() < ABSURD / 3:
            given["colour"] = "red"
        return Call(name if self.rng.random() > ABSURD / 3 else name + "s", given)

    def value(self, tool: str, argument: Argument) -> object:
        rng, kind = self.rng, argument.kind
        if isinstance(kind, Flag):
            return bool(rng.random() < 0.5)
        if isinstance(kind, Word):
            return str(rng.choice(kind.words))
        if isinstance(kind, WordOrNumber):
            if rng.random() < 0.8:
                return str(rng.choice(kind.words))
            kind = kind.number
        if isinstance(kind, PointList):
            return self.stroke(tool).tolist()
        if isinstance(kind, Vector):
            return (rng.normal(size=3) if kind.direction else self.place()).tolist()
        assert isinstance(kind, Number)
        if kind.whole:
            low = int(max(kind.low, -3))
            return int(rng.integers(low, int(min(kind.high, low + 15)) + 1))
        if np.isfinite([kind.low, kind.high]).all():
            return float(rng.uniform(kind.low, kind.high))
        return float(self.editor.surface.diagonal * np.exp(rng.uniform(np.log(0.005), np.log(0.3))))

    def anywhere(self) -> np.ndarray:
        """A point of the surface."""
        surface = self.editor.surface
        triangle = int(self.rng.integers(len(surface.triangles)))
        weights = self.rng.dirichlet(np.ones(3))
        return weights @ surface.vertices[surface.triangles[triangle]]

    def place(self) -> np.ndarray:
        """A point of the surface, mostly near a chain, or in the middle of a patch."""
        chains = self.editor.network.chains
        if not chains or self.rng.random() < 0.2:
            return self.anywhere()
        patches = self.editor.network.patches
        if patches and self.rng.random() < 0.4:
            patch = patches[int(self.rng.choice(sorted(patches)))]
            points = [chains[half >> 1].points.mean(axis=0) for half in patch.loop]
            return np.mean(points, axis=0)
        points = chains[int(self.rng.choice(sorted(chains)))].points
        at = points[(0, int(self.rng.integers(len(points))), -1)[self.rng.integers(3)]]
        return at + self.rng.normal(0.0, 0.005 * self.editor.surface.diagonal, 3)

    def stroke(self, tool: str) -> np.ndarray:
        """A stroke: between places, round one, or wild; mostly as the tool wants it."""
        rng, surface = self.rng, self.editor.surface
        loops = [chain for chain in self.editor.network.chains.values() if chain.is_closed_loop]
        if tool == "cylinder" and len(loops) > 1 and rng.random() < 0.8:
            one, two = rng.permutation(len(loops))[:2]
            return np.stack([loops[k].points[rng.integers(3)] for k in (one, two)])
        if tool == "spine" and rng.random() < 0.6:
            begin, along = self.anywhere(), rng.normal(size=3)
            length = surface.diagonal * rng.uniform(0.05, 0.25) / np.linalg.norm(along)
            line = begin + np.linspace(0.0, length, 12)[:, None] * along
            return surface.nearest(line).points
        if tool == "stroke" and len(self.editor.network.chains) < FEW_CHAINS and rng.random() < 0.4:
            # A ring, or another round one that is there, for cylinders.
            middle = loops[0].points.mean(axis=0) if loops else self.anywhere()
            foot = surface.nearest(middle[None])
            across = np.linalg.svd(foot.normals)[2][1:]
            turn = np.linspace(0.0, 2.0 * np.pi, 40)
            size = surface.diagonal * (0.08 + 0.05 * len(loops))
            ring = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
            return surface.nearest(foot.points[0] + size * ring).points
        begin = self.place()
        kind = rng.random()
        if kind < 0.15:
            size = surface.diagonal * np.exp(rng.uniform(np.log(0.02), np.log(0.25)))
            axes = rng.normal(size=(2, 3))
            turn = np.linspace(0.0, 2.0 * np.pi, 24)
            axes /= np.linalg.norm(axes, axis=1)[:, None]
            return begin + size * (
                np.cos(turn)[:, None] * axes[0] + np.sin(turn)[:, None] * axes[1]
            )
        if kind < 0.7:
            end = self.place()
            line = begin + np.linspace(0.0, 1.0, 12)[:, None] * (end - begin)
            return line + rng.normal(0.0, 0.002 * surface.diagonal, line.shape)
        steps = rng.normal(0.0, 0.04 * surface.diagonal, (int(rng.integers(1, 15)), 3))
        return begin + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


@dataclass
class Watch:
    """A drawing: its editor, what its states were, and the calls so far."""

    editor: Retopology
    handles: int
    past: list[str] = field(default_factory=list)
    future: list[str] = field(default_factory=list)
    script: list[str] = field(default_factory=list)
    now: str = ""
    why: Counter[str] = field(default_factory=Counter)

    def digest(self, state: State) -> str:
        """Tells states apart; written out, so that arrays changed in place would show."""
        data = RETOPO_SESSION.encode(RetopoSession(self.editor.surface, state))
        return hashlib.sha256(data).hexdigest()

    def step(self, call: Call, rng: np.random.Generator) -> str:
        """Do a call, see that all is as it must be, and say what came of it."""
        editor = self.editor
        try:
            outcome = editor.do(call)
        except InvalidRetopoError:
            self.check_now("after a call that is not allowed")
            return "invalid"
        self.script.append(line_of(call))
        if not outcome.changed:
            self.check_now("after a call that changed nothing")
            if outcome.refused is None:
                return "unchanged"
            # Without the numbers: as many reasons as there are sentences in the program.
            self.why[f"{call.tool}: {re.sub(NUMBER, 'N', outcome.refused)}"] += 1
            return "refused"
        after = self.digest(editor.state)
        if call.tool == "undo":
            assert after == self.past[-1], "undo gave another state"
            self.future.append(self.now)
            self.past.pop()
        elif call.tool == "redo":
            assert after == self.future[-1], "redo gave another state"
            self.past.append(self.now)
            self.future.pop()
        else:
            assert after != self.now, "a step that changed nothing"
            self.past = [*self.past, self.now][-DEPTH:]
            self.future = []
        self.now = after
        assert (editor.undoable, editor.redoable) == (len(self.past), len(self.future))
        check_network(editor.network, patches=False)
        genus = count_genus(editor.network.nodes, editor.network.chains)
        assert genus <= self.handles, f"the network goes round {genus} of {self.handles} handles"
        if rng.random() < FILLED:
            self.fill()
        if rng.random() < SAVED:
            self.save()
        return "done"

    def check_now(self, when: str) -> None:
        assert self.digest(self.editor.state) == self.now, f"another state {when}"

    def fill(self) -> None:
        found = self.editor.fill()
        self.script.append("# filled")
        assert self.editor.network is found.network
        assert set(found.placed) <= set(found.network.patches)
        check_network(found.network, patches=False)
        mesh = self.editor.mesh(found)
        assert np.isfinite(mesh.vertices).all() and np.isfinite(mesh.normals).all()
        self.now = self.digest(self.editor.state)

    def save(self) -> None:
        session = RetopoSession(self.editor.surface, self.editor.state, "a.obj")
        data = RETOPO_SESSION.encode(session)
        again = RETOPO_SESSION.decode(data)
        assert again.state.same(session.state), "the session reads as another"
        assert RETOPO_SESSION.encode(again) == data, "the session is written differently again"


def begun(surface: Surface, source: PatternSource, why: Counter[str]) -> Watch:
    watch = Watch(Retopology(surface, source), count_handles(surface), why=why)
    watch.now = watch.digest(watch.editor.state)
    return watch


@dataclass
class Tally:
    """What came of all calls so far. why: they were refused, and how often. slowest: by tool, in
    seconds of the processor, and the number of the call."""

    outcomes: Counter[str] = field(default_factory=Counter)
    why: Counter[str] = field(default_factory=Counter)
    slowest: dict[str, tuple[float, int]] = field(default_factory=dict)
    failures: list[dict[str, object]] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)
    told: float = field(default_factory=time.perf_counter)

    @property
    def calls(self) -> int:
        return sum(self.outcomes.values()) + len(self.failures)

    def add_failure(self, number: int, call: Call, error: Exception, watch: Watch) -> None:
        text = "".join(traceback.format_exception(error)[-4:])
        print(f"call {number}: {call.tool}: {text}", file=sys.stderr)
        self.failures.append(
            {
                "call": number,
                "error": f"{type(error).__name__}: {error}",
                "made": repr(call),
                "script": list(watch.script),
            }
        )

    def add_time(self, number: int, tool: str, seconds: float) -> None:
        self.slowest[tool] = max(self.slowest.get(tool, (0.0, 0)), (seconds, number))

    def tell_progress(self, number: int, total: int) -> None:
        """Say how far calls are, if that was not said for a while."""
        now = time.perf_counter()
        if number and now - self.told < TOLD_AFTER:
            return
        self.told = now
        # Kilobytes, on Linux.
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        done = sum(n for name, n in self.outcomes.items() if name.endswith(": done"))
        slow = sorted(self.slowest.items(), key=lambda item: -item[1][0])[:3]
        print(
            f"{number:,} of {total:,} calls, {done:,} changed something, "
            f"{len(self.failures)} failures, {now - self.started:.0f} s "
            f"({time.process_time():.0f} of the processor), {memory:.0f} MB at most; slowest: "
            + ", ".join(f"{name} {seconds:.1f} s (call {n})" for name, (seconds, n) in slow),
            file=sys.stderr,
            flush=True,
        )

    def describe(self) -> dict[str, object]:
        """The figures of the document."""
        return {
            "seconds": round(time.perf_counter() - self.started, 1),
            "seconds of the processor": round(time.process_time(), 1),
            "outcomes": dict(sorted(self.outcomes.items())),
            "refused": dict(self.why.most_common()),
            "slowest": {
                name: {"seconds": round(seconds, 2), "call": number}
                for name, (seconds, number) in sorted(self.slowest.items())
            },
            "failures": self.failures,
        }


def main() -> int:
    parser = argparse.ArgumentParser(description="Random calls of all tools of retopology.")
    parser.add_argument("--calls", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="go on with this call of a longer run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--surface", default="plane", help="plane, ball, or a mesh file")
    parser.add_argument("--verbose", action="store_true", help="say every call before it is made")
    parser.add_argument("--failures", type=int, default=20, help="failures that are enough")
    options = parser.parse_args()
    if options.first % CALLS_A_DRAWING:
        parser.error(f"--first {options.first}: drawings begin at multiples of {CALLS_A_DRAWING}")
    surface = surface_of(options.surface)
    tally = Tally()
    stopped: list[int] = []
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, lambda number, _: stopped.append(number))
    with patterndb.open() as source:
        watch = begun(surface, source, tally.why)
        for number in range(options.first, options.first + options.calls):
            if stopped or len(tally.failures) >= options.failures:
                break
            tally.tell_progress(number - options.first, options.calls)
            # Of the number alone, so that a drawing is the same however many there are.
            rng = np.random.default_rng([options.seed, number])
            if number % CALLS_A_DRAWING == 0:
                watch = begun(surface, source, tally.why)
            call = Caller(watch.editor, rng).call()
            if options.verbose:
                print(number, call.tool, str(dict(call.arguments))[:100], file=sys.stderr)
            before = time.process_time()
            try:
                tally.outcomes[f"{call.tool}: {watch.step(call, rng)}"] += 1
            except Exception as error:
                tally.add_failure(number, call, error, watch)
                watch = begun(surface, source, tally.why)
            tally.add_time(number, call.tool, time.process_time() - before)
    tally.told = -TOLD_AFTER
    tally.tell_progress(tally.calls, options.calls)
    document = {
        "surface": options.surface,
        "seed": options.seed,
        "first": options.first,
        "calls": tally.calls,
        "of": options.calls,
        **tally.describe(),
    }
    print(json.dumps(document, indent=1))
    if stopped:
        print(f"stopped after {tally.calls} of {options.calls} calls", file=sys.stderr)
        return 130
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
