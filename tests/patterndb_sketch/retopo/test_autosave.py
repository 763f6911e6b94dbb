"""Autosave: what is written when, what a crash leaves, and what a clean end does not."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import pytest

from patterndb_sketch import recovery
from patterndb_sketch.recovery import EVERY, find_recoveries
from patterndb_sketch.retopo.editor import Call, Retopology
from patterndb_sketch.retopo.session import RETOPO_SESSION, RetopoSession, autosave_session
from query.engine import PatternSource
from tests.support.retopo.editors import SIZES, do, line
from tests.support.retopo.networks import plane


@pytest.fixture
def editor(source: PatternSource) -> Retopology:
    return Retopology(plane(), source, SIZES)


@dataclass
class Clock:
    now: float = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def left(session: Path | None, folder: Path | None = None) -> list[Path]:
    """What would be found had this process been killed, and another begun."""
    own = set(recovery._OWN)
    recovery._OWN.clear()
    try:
        return [one.path for one in find_recoveries(session, folder)]
    finally:
        recovery._OWN.update(own)


def drawn(editor: Retopology, k: int) -> None:
    do(editor, "stroke", points=line((0, 0.2 * k), (1, 0.2 * k)))


def test_changes_are_written_every_half_minute(
    editor: Retopology, clock: Clock, tmp_path: Path
) -> None:
    session = tmp_path / "a.retopo"
    kept = autosave_session(
        RetopoSession(editor.surface, editor.state, "a.obj"), session=session, clock=clock
    )
    path = kept.path
    assert path is not None
    assert path.parent == tmp_path
    assert path.name.startswith("a.retopo.")
    clock.now += 100.0
    assert not kept.tick(editor.state), "nothing changed"
    drawn(editor, 0)
    assert kept.tick(editor.state), "time has passed"
    assert RETOPO_SESSION.read(path).state.same(editor.state)
    assert RETOPO_SESSION.read(path).name == "a.obj"
    written = path.read_bytes()
    drawn(editor, 1)
    clock.now += EVERY - 0.1
    assert not kept.tick(editor.state)
    assert path.read_bytes() == written
    clock.now += 0.1
    assert kept.tick(editor.state)
    assert path.read_bytes() == RETOPO_SESSION.encode(
        RetopoSession(editor.surface, editor.state, "a.obj")
    )
    clock.now += EVERY
    assert not kept.tick(editor.state), "nothing changed since"
    editor.do(Call("undo"))
    assert kept.tick(editor.state)
    assert RETOPO_SESSION.read(path).state.same(editor.state)
    assert left(session) == [path]
    assert not session.exists(), "the session itself is written by hand alone"


def test_saving_and_a_clean_end_leave_no_recovery_file(
    editor: Retopology, clock: Clock, tmp_path: Path
) -> None:
    kept = autosave_session(
        RetopoSession(editor.surface, editor.state), folder=tmp_path, clock=clock
    )
    first = kept.path
    assert first is not None
    assert first.name.startswith("unnamed.")
    drawn(editor, 0)
    clock.now += EVERY
    assert kept.tick(editor.state)
    assert left(None, tmp_path) == [first]
    session = tmp_path / "b.retopo"
    RETOPO_SESSION.write(session, RetopoSession(editor.surface, editor.state))
    kept.saved(editor.state, session)
    assert not first.exists()
    clock.now += EVERY
    assert not kept.tick(editor.state), "it is saved"
    drawn(editor, 1)
    clock.now += EVERY
    assert kept.tick(editor.state)
    assert left(session) == [kept.path]
    kept.close()
    assert sorted(tmp_path.iterdir()) == [session]
    drawn(editor, 2)
    clock.now += EVERY
    assert not kept.tick(editor.state), "it has ended"
    kept.close()


def test_without_a_file_or_folder_nothing_is_written(editor: Retopology, clock: Clock) -> None:
    kept = autosave_session(RetopoSession(editor.surface, editor.state), clock=clock)
    drawn(editor, 0)
    clock.now += EVERY
    assert kept.path is None
    assert not kept.tick(editor.state)


def test_a_write_that_fails_is_tried_again(
    editor: Retopology, clock: Clock, tmp_path: Path
) -> None:
    folder = tmp_path / "gone"
    kept = autosave_session(RetopoSession(editor.surface, editor.state), folder=folder, clock=clock)
    drawn(editor, 0)
    clock.now += EVERY
    with pytest.raises(FileNotFoundError):
        kept.tick(editor.state)
    assert not kept.tick(editor.state), "not at once"
    folder.mkdir()
    clock.now += EVERY
    assert kept.tick(editor.state)
    assert len(left(None, folder)) == 1


def test_two_windows_do_not_take_each_others_files(
    editor: Retopology, clock: Clock, tmp_path: Path
) -> None:
    session = tmp_path / "a.retopo"
    both = [
        autosave_session(RetopoSession(editor.surface, editor.state), session=session, clock=clock)
        for _ in range(2)
    ]
    drawn(editor, 0)
    clock.now += EVERY
    assert all(one.tick(editor.state) for one in both)
    assert both[0].path != both[1].path
    assert find_recoveries(session) == [], "both are still worked on"
    assert sorted(left(session)) == sorted(one.path for one in both if one.path is not None)
    both[0].close()
    assert len(list(tmp_path.iterdir())) == 1


def test_recoveries_are_those_of_programs_that_are_gone(tmp_path: Path) -> None:
    session = tmp_path / "a.retopo"
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    running = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    try:
        names = (
            f"a.retopo.{ended.pid}-00.recovery",
            f"a.retopo.{os.getpid()}-11.recovery",
            f"a.retopo.{running.pid}-22.recovery",
            f"unnamed.{ended.pid}-33.recovery",
            f"aa.retopo.{ended.pid}-44.recovery",
            "a.retopo.recovery",
            "a.retopo.x-1.recovery",
            f"a.retopo.{10**30}-55.recovery",
        )
        for k, name in enumerate(names):
            (tmp_path / name).touch()
            os.utime(tmp_path / name, (1e9 + k, 1e9 + k))
        found = find_recoveries(session)
        # This process's number with a mark that is not its own: it was another's before.
        assert [one.path.name for one in found] == [names[7], names[1], names[0]]
        assert [one.written for one in found] == [1e9 + 7, 1e9 + 1, 1e9]
        assert [one.path.name for one in find_recoveries(None, tmp_path)] == [names[3]]
    finally:
        running.communicate(b"\n")
    assert find_recoveries(tmp_path / "none" / "a.retopo") == []
    assert find_recoveries() == []


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="has no /proc")
def test_a_program_that_has_ended_and_is_not_asked_for_is_gone(tmp_path: Path) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    try:
        # Ended, and not waited for: as a launcher leaves a window that crashed.
        os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)
        path = tmp_path / f"unnamed.{ended.pid}-00.recovery"
        path.touch()
        assert [one.path for one in find_recoveries(None, tmp_path)] == [path]
    finally:
        ended.wait()


CHILD = """
    import sys, time
    from tests.support.retopo.editors import SIZES, do, line
    from dataclasses import replace
    from pathlib import Path
    from tests.support.retopo.networks import plane
    import patterndb
    from patterndb_sketch.retopo.editor import Retopology
    from patterndb_sketch.retopo.session import RetopoSession, autosave_session

    now = 0.0
    with patterndb.open() as source:
        editor = Retopology(plane(), source, replace(SIZES, snap=0.05))
        begun = RetopoSession(editor.surface, editor.state)
        kept = autosave_session(begun, session=Path(sys.argv[1]), clock=lambda: now)
        states = [editor.state]
        # An edit every 10 seconds, a tick every second, for five minutes and 25 seconds.
        for second in range(1, 326):
            now = float(second)
            if second % 10 == 0:
                k = second // 10
                do(editor, "stroke", points=line((0, 0.1 * k), (1, 0.1 * k)))
                states.append(editor.state)
            kept.tick(editor.state)
    for state in states:
        print(len(state.network.chains), flush=True)
    print("ready", flush=True)
    time.sleep(600)
"""


def test_a_kill_loses_half_a_minute_at_most(tmp_path: Path) -> None:
    session = tmp_path / "a.retopo"
    checkout = Path(__file__).parents[3]
    child = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(CHILD), str(session)],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(checkout)},
        text=True,
    )
    assert child.stdout is not None
    states: list[int] = []
    for answer in child.stdout:
        if answer == "ready\n":
            break
        states.append(int(answer))
    assert len(states) == 33, "the child did not get there"
    assert find_recoveries(session) == [], "the child still runs"
    child.send_signal(signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    child.stdout.close()
    (found,) = find_recoveries(session)
    kept = len(RETOPO_SESSION.read(found.path).state.network.chains)
    # An edit every ten seconds: the three before the kill may be lost, and no more.
    assert kept in states[-4:]
    assert [one.name for one in tmp_path.iterdir()] == [found.path.name], "nothing half written"
