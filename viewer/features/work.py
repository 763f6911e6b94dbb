"""Curves, what they snap to, and the way back: the half of the viewer that asks."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from functools import partial
from typing import Protocol
from weakref import WeakKeyDictionary, WeakSet

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb_sketch.features.model import Model
from patterndb_sketch.features.registration import DrawnNetwork
from patterndb_sketch.features.sessionfile import FeatureSession
from patterndb_sketch.features.snap import Snap, SnapSettings
from viewer.features.edits import (
    CurveLook,
    DrawnCurve,
    FeatureEdits,
    collect_session,
    open_session_curves,
    snap_curve,
)

# == Snaps curves in a thread, so that whoever looks at them need not wait.


class SnapMaker:
    """Makes one after another; what was not begun when the same curve is wanted otherwise is
    dropped."""

    def __init__(self) -> None:
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="snapping")
        self._asked: list[tuple[DrawnCurve, Future[Snap]]] = []

    def want(self, curve: DrawnCurve, make: Callable[[], Snap]) -> None:
        """Have a curve made, instead of what was wanted of the curve with its key."""
        self.forget(curve.key)
        self._asked.append((curve, self._worker.submit(make)))

    def forget(self, key: int) -> None:
        """Drop what is not begun of a curve."""
        self._asked = [one for one in self._asked if one[0].key != key or not one[1].cancel()]

    def wants(self, curve: DrawnCurve) -> bool:
        """Is this curve still to be made?"""
        return any(one is curve for one, _ in self._asked)

    @property
    def busy(self) -> bool:
        """Is something still to be made?"""
        return bool(self._asked)

    def wait(self, seconds: float | None = None) -> bool:
        """Until all is made; False if time ran out before."""
        return not wait_for([future for _, future in self._asked], seconds).not_done

    def made(self) -> list[tuple[DrawnCurve, Snap | PatternDBError]]:
        """What has been made since this was asked last, and why some could not be; what else
        went wrong is raised."""
        ready = [one for one in self._asked if one[1].done()]
        self._asked = [one for one in self._asked if not one[1].done()]
        result: list[tuple[DrawnCurve, Snap | PatternDBError]] = []
        for curve, future in ready:
            try:
                result.append((curve, future.result()))
            except PatternDBError as error:
                result.append((curve, error))
        return result

    def close(self) -> None:
        """Wait for what was begun."""
        self._worker.shutdown(wait=True, cancel_futures=True)


#: Seconds that a change waits for what it asks for: what is made at once is shown at once.
AT_ONCE = 0.05

#: Snaps that are kept to go on from: each has some megabytes of ribs. Others are made anew.
KEPT = 24


class FeatureFiles(Protocol):
    """Writes what is worked on, and says where it is. OSError as writing does."""

    def save_session(self, session: FeatureSession) -> str: ...
    def save_network(self, network: DrawnNetwork) -> str: ...
    def save_lines(self, lines: Mapping[str, Points]) -> str: ...


class Work:
    """The curves on a model, and the settings of the next one.

    edits: the curves. selected: the key of the one that sliders and keys change. settings: of
    the next curve, which are those that were chosen last. message: what went wrong last.
    ribs_shown: of the selected curve. files: for keys that save.
    """

    def __init__(
        self,
        model: Model,
        session: FeatureSession,
        settings: SnapSettings,
        files: FeatureFiles | None,
    ) -> None:
        self.model = model
        self.message = ""
        self.ribs_shown = False
        self._files = files
        self._session = session
        found, self.settings = open_session_curves(session, settings)
        self.edits = FeatureEdits(tuple(curve for curve, _ in found))
        self.selected: int | None = None
        self._saved = self.edits
        self._past: list[FeatureEdits] = []
        self._future: list[FeatureEdits] = []
        self._next = 1 + max((curve.key for curve in self.edits.curves), default=-1)
        self._looks: WeakKeyDictionary[DrawnCurve, CurveLook] = WeakKeyDictionary(found)
        self._failures: WeakKeyDictionary[DrawnCurve, PatternDBError] = WeakKeyDictionary()
        self._last: dict[int, CurveLook] = {curve.key: look for curve, look in found}
        self._snaps: OrderedDict[DrawnCurve, Snap] = OrderedDict()
        self._parents: WeakKeyDictionary[DrawnCurve, DrawnCurve] = WeakKeyDictionary()
        self._bases: WeakSet[DrawnCurve] = WeakSet()
        self._maker = SnapMaker()

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self._maker.close()

    @property
    def curve(self) -> DrawnCurve | None:
        """The selected curve."""
        return self.edits.find(self.selected)

    @property
    def making(self) -> bool:
        """Is a curve still shown as it was before?"""
        return self._maker.busy

    @property
    def unsaved(self) -> bool:
        """Has anything changed since the session was saved?"""
        return self.edits is not self._saved

    def look(self, curve: DrawnCurve) -> CurveLook | None:
        """What a curve looks like, or what it looked like last while it is being made."""
        return self._looks.get(curve) or self._last.get(curve.key)

    def snap_of(self, curve: DrawnCurve) -> Snap | None:
        """What a curve was found by, if that is known."""
        return self._snaps.get(curve)

    def trouble(self, curve: DrawnCurve) -> str:
        """Why a curve is not what was asked for, "" if it is."""
        failure = self._failures.get(curve)
        return "" if failure is None else str(failure)

    def session(self) -> FeatureSession:
        """The session as it is now; curves that could not be made are left out."""
        looks = self.made()
        made = [(one, looks[one.name]) for one in self.edits.curves if one.name in looks]
        return collect_session(self._session, made, self.settings)

    def made(self) -> dict[str, CurveLook]:
        """The curves that are what was asked for, by name."""
        looks = [(curve.name, self._looks.get(curve)) for curve in self.edits.curves]
        return {name: look for name, look in looks if look is not None}

    @property
    def shown_settings(self) -> SnapSettings:
        """What the sliders show: the selected curve's settings, or the next one's."""
        curve = self.curve
        return self.settings if curve is None else curve.settings

    # The clock

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        return self._take()

    def settle(self) -> None:
        """Wait for all that was asked for."""
        self._maker.wait()
        self._take()

    # How it is done

    def ask_snap(self, curve: DrawnCurve | None) -> None:
        """Have a curve snapped, if its ribs are not known: it will be changed. It is not shown."""
        if curve is None or curve in self._snaps:
            return
        if curve not in self._failures and not self._maker.wants(curve):
            self._bases.add(curve)
            self._want(curve, None)

    def _revise(self, curve: DrawnCurve) -> None:
        """An edited curve in place of that of its key, as one step."""
        before = self.edits.find(curve.key)
        self._step(self.edits.with_curve(curve))
        self._make(curve, before)

    def _make(
        self, curve: DrawnCurve, before: DrawnCurve | None, patience: float = AT_ONCE
    ) -> None:
        """Have an edited curve made, unless that would give the same again."""
        look = None if before is None else self._looks.get(before)
        if before is not None and look is not None and _same(curve, before):
            self._looks[curve] = look
            if before in self._snaps:
                self._keep(curve, self._snaps[before])
            return
        self._want(curve, before)
        self._maker.wait(patience)
        self._take()

    def _step(self, after: FeatureEdits) -> None:
        """Another step that can be taken back."""
        self._past.append(self.edits)
        self._future.clear()
        self.edits = after

    def _turn(self, source: list[FeatureEdits], target: list[FeatureEdits], otherwise: str) -> None:
        if not source:
            self.message = otherwise
            return
        target.append(self.edits)
        before, self.edits = self.edits, source.pop()
        for curve in self.edits.curves:
            if curve not in self._looks and not self._maker.wants(curve):
                self._want(curve, None)
        changed = [one.key for one in self.edits.curves if before.find(one.key) is not one]
        if changed:
            self.selected = changed[-1]
        elif self.curve is None:
            self.selected = None
        curve = self.curve
        if curve is not None:
            self.settings = curve.settings
        self.ask_snap(self.curve)

    def _want(self, curve: DrawnCurve, before: DrawnCurve | None) -> None:
        # Edits may come faster than curves: all are made of the last that is known.
        while before is not None and before not in self._snaps and before in self._parents:
            before = self._parents[before]
        if before is not None:
            self._parents[curve] = before
        known = None if before is None else self._snaps.get(before)
        self._maker.want(curve, partial(snap_curve, self.model, curve, before, known))

    def _keep(self, curve: DrawnCurve, snap: Snap) -> None:
        self._snaps[curve] = snap
        self._snaps.move_to_end(curve)
        while len(self._snaps) > KEPT:
            self._snaps.popitem(last=False)

    def _take(self) -> bool:
        """Show what has been made; False if there is nothing new."""
        made = self._maker.made()
        for curve, result in made:
            if isinstance(result, Snap):
                self._keep(curve, result)
                found = result.curve
                # What was read from a file, or made before, stays as it was.
                look = self._looks.setdefault(
                    curve, CurveLook.of(found.spline, found.samples, found)
                )
                if curve not in self._bases:
                    self._last[curve.key] = look
            else:
                self._failures[curve] = result
        return bool(made)


def _same(curve: DrawnCurve, other: DrawnCurve) -> bool:
    """Do two curves snap alike? Names are no matter."""
    return (
        curve.clicked is other.clicked
        and curve.constraints is other.constraints
        and (curve.settings, curve.again) == (other.settings, other.again)
    )
