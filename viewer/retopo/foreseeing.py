"""Foreseeing: what would come of what the pointer does, shown before it is done."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from patterndb_sketch.retopo.editor import Call
from patterndb_sketch.retopo.errors import RefusedError
from patterndb_sketch.retopo.tool import ToolWork
from viewer.retopo.aiming import Aiming
from viewer.retopo.previews import (
    Preview,
    preview_call,
    preview_completion,
    preview_cut,
    preview_inserted_loop,
    preview_pull,
    preview_spine_outline,
)

#: Seconds that a move of the pointer waits for its preview.
LIVE = 0.03


class Foreseeing(Aiming):
    """Tools aimed, with previews of what they would make."""

    def _seek(self) -> None:
        """Have the preview made that the pointer asks for, and show it if it is there soon; have
        the list found of the patch that it is on."""
        patch = self.patch_under() if self.mode.target == "patch" and not self.waiting else None
        if patch is not None and patch in self.network.patches:
            self._work.lists.want(self.network, self.network.patches[patch], self.shown.work.source)
        wanted = self._wanted()
        if wanted is None:
            self._latest.drop()
            self.preview = None
            return
        self._latest.want(*wanted)
        self._latest.wait(LIVE)
        self._take_preview()

    def _wanted(self) -> tuple[object, Callable[[], Preview]] | None:
        """What preview there is to be made, and a key that tells it from others."""
        shown, foot = self.shown.work, self._foot
        # Tools reach as far as they will be told to.
        sizes = replace(shown.state.sizes, snap=self.reach)
        work = replace(shown, state=replace(shown.state, sizes=sizes))
        tool, held = self.mode.tool, self._held
        if tool == "autocomplete" and held in (None, "click") and foot is not None:
            radius, number = self.brush, self.choice
            key = (tool, shown, self.reach, foot.points.tobytes(), radius, number)
            return key, lambda: preview_completion(work, foot, radius, number)
        if tool == "preview_spine_outline" and held == "line" and len(self.line) > 2:
            line, width = np.stack(self.line), 2.0 * self.brush
            key = (tool, shown, self.reach, len(line), line[-1].tobytes(), width)
            return key, lambda: preview_spine_outline(work, line, width)
        if tool == "pull" and held == "drag" and self._strayed and foot is not None:
            begun, point = self.line[0], foot.points[0]
            key = (tool, shown, self.reach, begun.tobytes(), point.tobytes())
            return key, lambda: preview_pull(work, begun, point)
        if held == "plane" and self._pressed is not None and self.pointer is not None:
            try:
                found = self._plane(self._pressed, self.pointer)
            except RefusedError:
                return None
            if found is not None:
                at, normal, limit = found
                key = (tool, shown, self.reach, at.tobytes(), normal.tobytes())
                return key, lambda: preview_cut(work, at, normal, limit)
        return self._wanted_quads(work)

    def _wanted_quads(self, work: ToolWork) -> tuple[object, Callable[[], Preview]] | None:
        """The same of tools that change quads."""
        shown, foot = self.shown, self._foot
        # While fills are made there is nothing to be seen anew, and the database is at work.
        if foot is None or not shown.fresh:
            return None
        mesh, tool, point = shown.body.mesh, self.mode.tool, foot.points[0]
        if tool == "insertloop" and self._held in (None, "click"):
            return (tool, shown, self.reach, point.tobytes()), lambda: preview_inserted_loop(
                work, mesh, foot
            )
        if self.mode.gesture == "drag" and self._held == "drag" and self._strayed:
            given = self._given() | self._ends(self.line[0], foot)
            return (tool, shown, str(given)), lambda: preview_call(
                work, mesh, Call(tool, given), point
            )
        return None

    def _take_preview(self) -> None:
        """Show the preview that was found; one of another network is never shown."""
        found = self._latest.found()
        if found is not None:
            self.preview = found
        if self.preview is not None and self.preview.network is not self.network:
            self.preview = None
