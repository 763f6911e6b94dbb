"""Kill every way to write a database at random moments, and see that it is before or after.

    python benchmarks/kill_writes.py --kills 200 --seed 1

What benchmarks/kills.py does for ingest, for merge, remove, import of a table, the
recording of uses, and sessions. Each run copies a sound file, writes to it in a process of its own,
and ends that by SIGKILL at a random moment of the time that the write takes.

A database is then opened for reading, as ``stats`` does: what it holds must be the content before
or after the write, SQLite must find it whole, and verify() must find nothing. Of networks and
sessions of surfacing, features and retopology, saved again and again in turns until the kill, the
file must have the bytes of one save or the other and be readable; the autosave must leave the
session as it is and a recovery file that is found and whole, if any. What the kill left beside the
file must be gone after the next save.

Prints one JSON document; exits 1 if there were failures. Needs fork(): a run then costs no start of
the interpreter.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# The tests draw what is saved here.
sys.path.insert(0, str(ROOT))

import patterndb  # noqa: E402
from ingest import ingest  # noqa: E402
from patterndb.store import Database, LearningOptions, read_table  # noqa: E402
from patterndb.system.files import UNFINISHED  # noqa: E402

EXAMPLES = sorted((ROOT / "examples").glob("*.obj"))
OPTIONS = LearningOptions(basic=4, side=8, convex=12)

#: Uses that one run records.
USES = 20

#: Saves of a session, within as many of which the kill comes.
SAVES = 4


def merge(path: Path, folder: Path) -> None:
    with Database(path, "write") as db, Database(folder / "other.db") as other:
        db.merge(other)


def remove(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        db.remove([db.meshes()[0].name])


def import_table(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        db.import_ddq(read_table(folder / "table.db"))


def record_uses(path: Path, folder: Path) -> None:
    with Database(path, "write") as db:
        pattern = db.pattern_class(4).pattern(0)
        for _ in range(USES):
            db.record_use(pattern)


#: Ways to write databases, by name. One that commits several times may be between any two.
WAYS: dict[str, Callable[[Path, Path], None]] = {
    "merge": merge,
    "remove": remove,
    "import": import_table,
    "uses": record_uses,
}

#: Ways to save what is drawn; :func:`make_savings` makes them.
SAVINGS = ("surfacing", "features", "retopology", "autosave")

#: A process that is forked costs no start of the interpreter.
FORK = multiprocessing.get_context("fork")


def make_sound(folder: Path) -> None:
    """Write what the ways begin with: sound.db, other.db and table.db."""
    with Database(folder / "sound.db", "create") as db:
        ingest(db, EXAMPLES[:2], OPTIONS, jobs=1)
    with Database(folder / "other.db", "create") as db:
        ingest(db, EXAMPLES[2:4], OPTIONS, jobs=1)
        db.export_ddq(folder / "table.db")


def tell_content(path: Path) -> tuple[object, ...]:
    """What a database holds, as its content hash and its uses."""
    with Database(path) as db:
        return db.content_hash(), tuple(sorted(db.uses().items()))


def find_faults(path: Path, allowed: set[object]) -> list[str]:
    """What is wrong with a database after a kill."""
    try:
        held_content = tell_content(path)
        with Database(path) as db:
            found = db.verify()
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    if held_content not in allowed:
        found.append("the content is neither that before nor that after")
    return found


@dataclass(frozen=True, slots=True)
class Saving:
    """A way to save a file: what is saved in turns, and how it is read.

    save: writes the drawing of a number, 0 or 1, to a path. kept: the bytes of both. read: reads a
    file. autosaves: does it write to a recovery file beside the path, and not there?
    """

    save: Callable[[Path, int], None]
    read: Callable[[Path], object]
    kept: tuple[bytes, bytes]
    autosaves: bool = False


def make_savings(folder: Path) -> dict[str, Saving]:
    """The ways to save networks and sessions, by name."""
    from patterndb_sketch.features.files.networkjson import read_network
    from patterndb_sketch.features.session import FEATURE_SESSION, FeatureSession
    from patterndb_sketch.features.snap import SnapSettings
    from patterndb_sketch.recovery import Autosave
    from patterndb_sketch.retopo.editor import Call, State
    from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession, autosave_session
    from patterndb_sketch.surfacing import networkfile
    from tests.support.retopo.editors import drawn_grid, line

    drawing = networkfile.read_drawing(ROOT / "examples" / "networks" / "teacup.json")
    stages = ((), (list(range(len(drawing.network.curves))),))
    network = read_network(ROOT / "examples" / "features" / "q_car_cop.network.json")
    curves = [
        FeatureSession("car.obj", settings=SnapSettings(alpha=alpha), networks={"car": network})
        for alpha in (0.25, 0.5)
    ]
    with patterndb.open() as source:
        editor = drawn_grid(source)
        states = [editor.state]
        editor.fill()
        editor.do(Call("stroke", {"points": line((0.5, 0), (0.5, 3))}))
        states.append(editor.state)
    sheets = [RetopoSession(editor.surface, state, "sheet.obj") for state in states]

    def save_network(path: Path, number: int) -> None:
        networkfile.write_network(path, drawing.network, stages[number])

    def save_features(path: Path, number: int) -> None:
        FEATURE_SESSION.write(path, curves[number])

    def save_retopo(path: Path, number: int) -> None:
        RETOPO_SESSION.write(path, sheets[number])

    def autosave(path: Path, number: int) -> None:
        # A process has one, as a window has.
        if os.getpid() not in begun:
            begun[os.getpid()] = autosave_session(sheets[0], session=path, every=0.0)
        begun[os.getpid()].tick(states[number])

    begun: dict[int, Autosave[State]] = {}
    savings: dict[str, Saving] = {}
    for name, save, read in (
        ("surfacing", save_network, networkfile.read_network),
        ("features", save_features, FEATURE_SESSION.read),
        ("retopology", save_retopo, RETOPO_SESSION.read),
    ):
        kept: list[bytes] = []
        for number in (0, 1):
            save(folder / "kept", number)
            read(folder / "kept")
            kept.append((folder / "kept").read_bytes())
        assert kept[0] != kept[1]
        savings[name] = Saving(save, read, (kept[0], kept[1]))
    (folder / "kept").unlink()
    written = savings["retopology"]
    savings["autosave"] = Saving(autosave, written.read, written.kept, autosaves=True)
    return savings


def save_in_turns(saving: Saving, path: Path) -> None:
    """Save both drawings in turns, for as long as it takes to be killed."""
    number = 0
    while True:
        number = 1 - number
        saving.save(path, number)


def find_saving_faults(saving: Saving, path: Path) -> list[str]:
    """What is wrong with a saved file, or a recovery file, after a kill; removes the latter."""
    from patterndb_sketch.recovery import find_recoveries

    found: list[str] = []
    written = [path]
    if saving.autosaves:
        if path.read_bytes() != saving.kept[0]:
            found.append("the autosave changed the session itself")
        written = [one.path for one in find_recoveries(path)]
        beside = [one for one in path.parent.iterdir() if not one.name.startswith(UNFINISHED)]
        if len(written) > 1 or sorted([path, *written]) != sorted(beside):
            found.append(f"there are {sorted(one.name for one in beside)}")
    for one in written:
        try:
            saving.read(one)
        except Exception as error:
            found.append(f"{type(error).__name__}: {error}")
        if one.read_bytes() not in saving.kept:
            found.append("it is neither what was saved before nor after")
        if one != path:
            one.unlink()
    return found


class DatabaseKills:
    """Kills of what writes databases, in a folder of their own."""

    def __init__(self, folder: Path, ways: list[str]) -> None:
        self.folder = folder
        self.path = folder / "killed.db"
        self.seconds: dict[str, float] = {}
        self.allowed: dict[str, set[object]] = {}
        self.left = 0
        if ways:
            make_sound(folder)
        for way in ways:
            shutil.copy(self.folder / "sound.db", self.path)
            before = tell_content(folder / "sound.db")
            # The first time loads modules, which the forks then have.
            WAYS[way](self.path, folder)
            self.allowed[way] = {before, tell_content(self.path)}
            if way == "uses":
                with Database(self.path) as db:
                    (used,) = db.uses()
                self.allowed[way] |= {(before[0], ((used, n),)) for n in range(1, USES + 1)}
            begin = time.perf_counter()
            process = self.start(way)
            process.join()
            self.seconds[way] = time.perf_counter() - begin

    def start(self, way: str) -> BaseProcess:
        shutil.copy(self.folder / "sound.db", self.path)
        process = FORK.Process(target=WAYS[way], args=(self.path, self.folder))
        process.start()
        return process

    def judge(self, way: str) -> list[str]:
        journal = self.path.with_name(self.path.name + "-journal")
        self.left += journal.exists() and journal.stat().st_size > 0
        found = find_faults(self.path, self.allowed[way])
        for left in self.folder.glob("killed.db*"):
            left.unlink()
        return found


class SavingKills:
    """Kills of what saves files, in a folder of their own."""

    def __init__(self, folder: Path, ways: list[str]) -> None:
        self.folder = folder
        self.path = folder / "killed"
        self.seconds: dict[str, float] = {}
        self.left = 0
        self.savings = make_savings(folder) if ways else {}
        for way in ways:
            begin = time.perf_counter()
            for k in range(SAVES):
                self.savings[way].save(self.path, k % 2)
            self.seconds[way] = time.perf_counter() - begin
        for left in folder.iterdir():
            left.unlink()

    def start(self, way: str) -> BaseProcess:
        self.path.write_bytes(self.savings[way].kept[0])
        process = FORK.Process(target=save_in_turns, args=(self.savings[way], self.path))
        process.start()
        return process

    def judge(self, way: str) -> list[str]:
        self.left += any(one.name.startswith(UNFINISHED) for one in self.folder.iterdir())
        found = find_saving_faults(self.savings[way], self.path)
        by_hand = "retopology" if self.savings[way].autosaves else way
        self.savings[by_hand].save(self.path, 0)
        if [one.name for one in self.folder.iterdir()] != [self.path.name]:
            found.append("something is left after the next save")
        return found


def run(kills: int, seed: int, ways: list[str] | None = None) -> dict[str, object]:
    """Kill so many writes; the counts, and a line for each that went wrong."""
    chance = random.Random(seed)
    killed: Counter[str] = Counter()
    finished: Counter[str] = Counter()
    faults: list[str] = []
    names = ways or [*WAYS, *SAVINGS]
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
        databases = DatabaseKills(Path(one), [way for way in names if way in WAYS])
        savings = SavingKills(Path(other), [way for way in names if way in SAVINGS])
        while killed.total() < kills:
            way = names[killed.total() % len(names)]
            kind = databases if way in WAYS else savings
            process = kind.start(way)
            time.sleep(chance.uniform(0, kind.seconds[way]))
            if process.is_alive() and process.pid is not None:
                os.kill(process.pid, signal.SIGKILL)
            process.join()
            if process.exitcode == -signal.SIGKILL:
                killed[way] += 1
            elif process.exitcode == 0:
                finished[way] += 1
            else:
                faults.append(f"{way}: it ended by itself with exit code {process.exitcode}")
                break
            faults += [f"{way}: {fault}" for fault in kind.judge(way)]
    return {
        "seed": seed,
        "killed": dict(killed),
        "got_through": dict(finished),
        "left_a_journal": databases.left,
        "left_a_file_unfinished": savings.left,
        "faults": faults,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--way", choices=[*WAYS, *SAVINGS], action="append", help="all if not given"
    )
    given = parser.parse_args()
    result = run(given.kills, given.seed, given.way)
    print(json.dumps(result, indent=1))
    return int(bool(result["faults"]))


if __name__ == "__main__":
    sys.exit(main())
