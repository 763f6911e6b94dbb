"""Answers to questions for fills: whole, or a line for every fill as it is found."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter
from typing import Any

import msgspec

from patterndb_app.service.catalogue import ServedDatabase
from patterndb_app.service.limits import Limits
from patterndb_app.service.questions import FillQuestion
from patterndb_app.service.work import GONE, LATE, STOPPING, RequestWork
from query import Fill, Fills, fills
from query.placing import Region, Surface, enclose_region, place

#: Why a list ends that would be larger than the service allows.
TOO_LARGE = "answer size"


class FillAnswer:
    """The fills of a question, one after another, with what is said at their end."""

    def __init__(
        self,
        question: FillQuestion,
        database: ServedDatabase,
        surface: Surface | None,
        limits: Limits,
        work: RequestWork,
    ) -> None:
        self._question = question
        self._limits = limits
        self._work = work
        self._began = perf_counter()
        self._stopped: str | None = None
        # Before the search: a boundary that is nowhere near its surface is refused.
        points = question.boundary.points
        self._region: Region | None = None
        if surface is not None and points is not None and question.request.place:
            self._region = enclose_region(surface, points)
        self._found: Fills = fills(database.opened, question.boundary, question.request)
        work.on_end(lambda: self._found.cancel(work.stopped or GONE))

    @property
    def head(self) -> dict[str, object]:
        """What an answer begins with."""
        boundary = self._question.boundary
        return {"sides": list(boundary.lengths), "corners": list(boundary.corners)}

    def lines(self) -> Iterator[bytes]:
        """The fills as JSON, each as soon as it is found, and placed where there are points."""
        size = 0
        for fill in self._found:
            if self._work.stopped is not None:
                return
            line = msgspec.json.encode(self._describe(fill))
            size += len(line)
            if size > self._limits.answer_bytes:
                self._stopped = TOO_LARGE
                self._found.cancel(TOO_LARGE)
                return
            yield line

    def end(self) -> dict[str, object]:
        """What is said at the end; ask for it when the lines have ended."""
        # The reason may take a search of its own, which the time limit ends as well.
        reason = self._found.reason
        stopped = self._stopped or self._found.stopped
        if self._work.stopped in (LATE, STOPPING):
            stopped = self._work.stopped
        return {
            "truncated": self._found.truncated or stopped is not None,
            "stopped": stopped,
            "complete": stopped is None,
            "reason": reason,
            "seconds": round(perf_counter() - self._began, 4),
        }

    def _describe(self, fill: Fill) -> dict[str, Any]:
        question = self._question
        document: dict[str, Any] = {**fill.to_json()}
        points = question.boundary.points
        asked = question.request
        if points is None or not asked.place:
            return document
        placement = place(fill, points, self._region, asked.strokes, tolerance=asked.tolerance)
        return {**document, "placed": placement.vertices.tolist(), **placement.to_json()}


def make_whole(answer: FillAnswer) -> bytes:
    """Make the whole answer: one document, the fills last but for what is known at their end."""
    listed = b",".join(answer.lines())
    head, end = msgspec.json.encode(answer.head), msgspec.json.encode(answer.end())
    return b'%b,"fills":[%b],%b' % (head[:-1], listed, end[1:])


def make_lines(answer: FillAnswer, work: RequestWork) -> None:
    """Hand over a line for every fill, and the last."""
    for line in answer.lines():
        work.put(line + b"\n")
    work.put(msgspec.json.encode({"done": True, **answer.head, **answer.end()}) + b"\n")
