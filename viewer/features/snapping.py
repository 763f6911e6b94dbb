"""Snaps curves in a thread, so that whoever draws them need not wait; and the colours of curves."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for

from patterndb.errors import PatternDBError
from patterndb_sketch.features.edits import DrawnCurve
from patterndb_sketch.features.snap import Snap

#: After Okabe and Ito, as colour-blind readers can tell them apart, darker than theirs: lines
#: are thin. In the order of being drawn.
CURVES = (
    "#0b63b5",
    "#d1570c",
    "#08855f",
    "#b1478a",
    "#a87b00",
    "#6a48c8",
    "#2a93c4",
    "#a33238",
)


def choose_curve_colour(key: int) -> str:
    """Choose the colour of a curve by its key: it keeps it while others come and go."""
    return CURVES[key % len(CURVES)]


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
