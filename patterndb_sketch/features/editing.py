"""The editing of feature curves: what they snap to, what keys choose, and the way back."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from dataclasses import replace
from functools import partial
from weakref import WeakKeyDictionary, WeakSet

import numpy as np

from patterndb.errors import PatternDBError
from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface
from patterndb_sketch.features.edits import (
    CurveLook,
    DrawnCurve,
    FeatureEdits,
    collect_session,
    open_session_curves,
    snap_curve,
)
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.files.curvefiles import FeatureFiles
from patterndb_sketch.features.initial import SAME_CLICK, find_initial_curve
from patterndb_sketch.features.registration import FeatureCurves
from patterndb_sketch.features.session import FeatureSession
from patterndb_sketch.features.snap import Snap, SnapSettings
from patterndb_sketch.features.splines.spline import LEAST_CLOSED, MAX_DEGREE
from patterndb_sketch.history import History

#: Seconds that a change waits for what it asks for: what is made at once is shown at once.
AT_ONCE = 0.05

#: Snaps that are kept to go on from: each has some megabytes of ribs. Others are made anew.
KEPT = 24


class SnapMaker:
    """Snaps curves in a thread, one after another; what was not begun when the same curve is
    wanted otherwise is dropped."""

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


class FeatureEditing:
    """The curves on a model, the settings of the next one, and a curve while it is drawn.

    steps: of the curves. selected: the key of the one that sliders and keys change. settings: of
    the next curve, which are those that were chosen last. message: what went wrong last.
    ribs_shown: of the selected curve. files: for keys that save.
    """

    def __init__(
        self,
        model: Surface,
        session: FeatureSession,
        settings: SnapSettings,
        files: FeatureFiles | None,
    ) -> None:
        self.model = model
        self.message = ""
        self.ribs_shown = False
        self.files = files
        self._session = session
        found, self.settings = open_session_curves(session, settings)
        self.steps = History(FeatureEdits(tuple(curve for curve, _ in found)))
        self.selected: int | None = None
        self._saved = self.edits
        self._next = 1 + max((curve.key for curve in self.edits.curves), default=-1)
        self._looks: WeakKeyDictionary[DrawnCurve, CurveLook] = WeakKeyDictionary(found)
        self._failures: WeakKeyDictionary[DrawnCurve, PatternDBError] = WeakKeyDictionary()
        self._last: dict[int, CurveLook] = {curve.key: look for curve, look in found}
        self._snaps: OrderedDict[DrawnCurve, Snap] = OrderedDict()
        self._parents: WeakKeyDictionary[DrawnCurve, DrawnCurve] = WeakKeyDictionary()
        self._bases: WeakSet[DrawnCurve] = WeakSet()
        self._maker = SnapMaker()
        #: The points clicked so far while a curve is drawn, None if none is.
        self.clicks: tuple[Points, ...] | None = None
        self._preview: DrawnCurve | None = None

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
    def edits(self) -> FeatureEdits:
        """The curves."""
        return self.steps.now

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

    def session(self, edits: FeatureEdits | None = None) -> FeatureSession:
        """The session with these curves, by default as they are now; those that could not be made
        are left out."""
        curves = (self.edits if edits is None else edits).curves
        looks = [(curve, self._looks.get(curve)) for curve in curves]
        made = [(curve, look) for curve, look in looks if look is not None]
        return collect_session(self._session, made, self.settings)

    def made(self) -> dict[str, CurveLook]:
        """The curves that are what was asked for, by name."""
        looks = [(curve.name, self._looks.get(curve)) for curve in self.edits.curves]
        return {name: look for name, look in looks if look is not None}

    @property
    def shown_settings(self) -> SnapSettings:
        """What the sliders show: the settings of the curve that is drawn or selected, else of
        the next one."""
        curve = self.curve if self.clicks is None else None
        return self.settings if curve is None else curve.settings

    # Curves selected, named, deleted, changed, and saved

    def toggle(self, name: str) -> None:
        """Turn one of the switches, such as ribs_shown."""
        setattr(self, name, not getattr(self, name))
        self.ask_snap(self.curve)

    def select(self, key: int | None) -> None:
        """Select a curve; none while one is drawn."""
        if self.clicks is None:
            self.selected = key
            self.ask_snap(self.curve)

    def select_next(self, by: int) -> None:
        """The next curve, or the one before; from the last on to the first."""
        keys = [curve.key for curve in self.edits.curves]
        if not keys:
            self.message = "there is no curve yet"
            return
        if self.selected in keys:
            self.select(keys[(keys.index(self.selected) + by) % len(keys)])
        else:
            self.select(keys[0 if by > 0 else -1])

    def delete(self) -> None:
        """Delete the selected curve, or forget the one that is drawn."""
        curve = self.curve
        if self.clicks is not None:
            self._drop()
        elif curve is None:
            self.message = "select a curve first: click on it"
        else:
            self.steps.step(self.edits.without(curve.key))
            self.selected = None

    def rename(self, name: str) -> None:
        """Give the selected curve another name."""
        curve = self.curve
        if curve is None or name == curve.name:
            return
        if not name:
            self.message = "a curve needs a name"
        elif any(one.name == name for one in self.edits.curves):
            self.message = f"there is another curve {name!r}"
        else:
            self.revise(replace(curve, name=name))

    def turn_closed(self) -> None:
        """Close the curve that is drawn or selected, or open it again."""
        curve = self._preview if self.clicks is not None else self.curve
        if curve is None:
            self.message = (
                "select a curve first: click on it"
                if self.clicks is None
                else "click three points of the model at least"
            )
            return
        try:
            turned = curve.turned(self.model)
        except InvalidFeatureError as error:
            self.message = str(error)
            return
        if self.clicks is None:
            self.revise(turned)
        else:
            self._show_preview(turned)

    def snap_again(self) -> None:
        """One more round: ribs about the selected curve as it is now."""
        curve = self.curve
        if curve is None:
            self.message = "select a curve first: click on it"
        else:
            self.revise(replace(curve, again=curve.again + 1))

    def change_degree(self, by: int) -> None:
        """A higher or a lower degree of the spline."""
        self.choose_degree(self.shown_settings.degree + by)

    def choose_degree(self, degree: int) -> None:
        """Another degree of the spline."""
        if 1 <= degree <= MAX_DEGREE:
            self.change(replace(self.shown_settings, degree=degree))
        else:
            self.message = f"the degree is from 1 to {MAX_DEGREE}"

    def choose_axis(self, axis: tuple[float, float, float]) -> None:
        """The direction (3,) that normals are measured from."""
        settings = self.shown_settings
        if settings.alpha == 1.0:
            self.message = "alpha is 1, so that angles do not count; make it less"
        self.change(replace(settings, axis=axis))

    def change(self, settings: SnapSettings) -> None:
        """Other settings for the curve that is drawn or selected, and for the next one."""
        self.settings = settings
        preview = self._preview
        if self.clicks is not None:
            if preview is not None and settings != preview.settings:
                self._show_preview(replace(preview, settings=settings))
            return
        curve = self.curve
        if curve is not None and settings != curve.settings:
            self.revise(replace(curve, settings=settings))

    def undo(self) -> None:
        """Take the last step back."""
        self._turn(self.steps.undo, "there is nothing to take back")

    def redo(self) -> None:
        """Do again what was taken back last; a curve being drawn is not affected."""
        if self.clicks is None:
            self._turn(self.steps.redo, "there is nothing to do again")
        else:
            self.message = "finish the curve first: Enter, or Escape to drop it"

    def watch(self, mesh: str) -> None:
        """Keep the curves from now on in case of a crash, and report what one left.

        mesh: the name of the model's file.
        """
        if self.files is not None:
            self.message = self.files.watch(self.edits, self.session, mesh)

    def save_session(self) -> bool:
        """Save all curves, once they are what was asked for; False if that cannot be."""
        done = self._saved_by(lambda files: files.save_session(self.session(), self.edits))
        if done:
            self._saved = self.edits
        return done

    def save_network(self) -> None:
        """Save the curves as a network, which templates are laid on."""
        self._saved_by(
            lambda files: files.save_network(
                FeatureCurves({name: look.spline for name, look in self.made().items()})
            )
        )

    def save_lines(self) -> None:
        """Save the curves as lines, for other programs."""
        self._saved_by(
            lambda files: files.save_lines({name: one.line for name, one in self.made().items()})
        )

    def recover(self) -> None:
        """Take what a crash left in place of the curves that there are, as one step."""
        found = None if self.files is None else self.files.lost
        if self.files is None or found is None:
            self.message = "there is nothing that a crash left"
            return
        self._replace(found)
        self.files.lost = None
        self.message = "this is what the crash left; s saves it, and its file goes then"

    def reload(self) -> None:
        """Take what the session's file holds by now in place of the curves that there are, as one
        step; PatternDBError or OSError if it cannot be read."""
        if self.files is None:
            self.message = "sessions cannot be read here"
            return
        self._replace(self.files.read_again())
        self._saved = self.edits
        self.message = "this is what the file holds; undo brings back what was drawn here"

    def _replace(self, session: FeatureSession) -> None:
        """Take the curves of a session, as one step."""
        self._drop()
        self._session = session
        made, self.settings = open_session_curves(session, self.settings, self._next)
        self._next += len(made)
        self._looks.update(made)
        self._last.update((curve.key, look) for curve, look in made)
        self.steps.step(FeatureEdits(tuple(curve for curve, _ in made)))
        self.selected = None

    def _saved_by(self, save: Callable[[FeatureFiles], str]) -> bool:
        self.settle()
        if self.files is None:
            self.message = "nothing can be saved here: no way to write files was given"
            return False
        try:
            self.message = save(self.files)
        except OSError as error:
            self.message = f"not saved: {error}"
            return False
        made = self.made()
        lost = [curve.name for curve in self.edits.curves if curve.name not in made]
        if lost:
            self.message += f", without what could not be made: {', '.join(lost)}"
        return True

    # A curve while it is drawn with clicks

    @property
    def preview(self) -> DrawnCurve | None:
        """The curve that would be made of the clicks so far."""
        return self._preview

    def sketched(self) -> Points | None:
        """(k, 3) the line through the clicks, laid on the model, while it has not snapped."""
        preview = self._preview
        if preview is None or self.look(preview) is not None:
            return None
        samples = find_initial_curve(self.model, preview.clicked, closed=preview.closed).samples
        return np.concatenate([samples, samples[:1]]) if preview.closed else samples

    def begin_curve(self) -> None:
        """Draw a curve with clicks, or begin it anew."""
        self._drop()
        self.clicks = ()

    def finish_curve(self) -> None:
        """Make a curve of the clicks."""
        preview = self._preview
        if self.clicks is None:
            self.message = "press c to draw a curve, and click points on the model"
        elif preview is None:
            self.message = "click two points of the model at least"
        elif self.trouble(preview):
            self.message = self.trouble(preview)
        else:
            # The curve is the preview itself: what it snapped to is known, or will be.
            self.steps.step(self.edits.with_curve(preview))
            self.clicks = self._preview = None
            self.select(preview.key)

    def take_back(self) -> None:
        """Take the last click back, or the last step if no curve is drawn."""
        if self.clicks is None:
            self.undo()
        elif not self.clicks:
            self.message = "there is no click to take back; Escape leaves"
        else:
            self._click(self.clicks[:-1])

    def leave(self) -> bool:
        """Leave drawing or the selection; False if there is nothing to leave."""
        if self.clicks is not None:
            self._drop()
        elif self.selected is not None:
            self.select(None)
        else:
            return False
        return True

    def click(self, point: Points | None) -> None:
        """A point (3,) of the model was clicked, or a place beside it."""
        if self.clicks is None:
            self.select(None)
            return
        if point is None:
            self.message = "there is no model under the pointer"
            return
        near = SAME_CLICK * self.model.diagonal
        if self.clicks and np.linalg.norm(point - self.clicks[-1]) <= near:
            self.message = "that point has been clicked already"
            return
        self._click((*self.clicks, point))

    @property
    def may_close(self) -> bool:
        """Has the curve that is drawn clicks enough to be closed by one more, on the first?"""
        return self.clicks is not None and len(self.clicks) >= LEAST_CLOSED

    def close_curve(self) -> None:
        """The first of the clicks was clicked again: the curve is closed, and finished."""
        preview = self._preview
        if preview is not None and not preview.closed:
            self.turn_closed()
        self.finish_curve()

    def _click(self, clicks: tuple[Points, ...]) -> None:
        """The curve is drawn through these points."""
        self.clicks = clicks
        if len(clicks) < 2:
            if self._preview is not None:
                self._maker.forget(self._preview.key)
                self._last.pop(self._preview.key, None)
            self._preview = None
            return
        if self._preview is None:
            key, self._next = self._next, self._next + 1
            curve = DrawnCurve(key, self.edits.free_name(), np.stack(clicks), self.settings)
        else:
            # Closed stays closed while clicks are enough.
            closed = self._preview.closed and len(clicks) >= LEAST_CLOSED
            curve = replace(self._preview, clicked=np.stack(clicks), closed=closed)
        self._show_preview(curve)

    def _show_preview(self, curve: DrawnCurve) -> None:
        before, self._preview = self._preview, curve
        self.make(curve, before)

    def _drop(self) -> None:
        """Forget the curve that is drawn."""
        if self._preview is not None:
            self._maker.forget(self._preview.key)
        self.clicks = self._preview = None

    # The clock

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        new = self._take()
        # A curve that is being made would be left out.
        said = "" if self.files is None or self.making else self.files.tick(self.edits)
        self.message = said or self.message
        return new or bool(said)

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

    def revise(self, curve: DrawnCurve) -> None:
        """An edited curve in place of that of its key, as one step."""
        before = self.edits.find(curve.key)
        self.steps.step(self.edits.with_curve(curve))
        self.make(curve, before)

    def make(self, curve: DrawnCurve, before: DrawnCurve | None, patience: float = AT_ONCE) -> None:
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

    def _turn(self, turn: Callable[[], bool], otherwise: str) -> None:
        before = self.edits
        if not turn():
            self.message = otherwise
            return
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
        and curve.closed == other.closed
        and curve.constraints is other.constraints
        and (curve.settings, curve.again) == (other.settings, other.again)
    )
