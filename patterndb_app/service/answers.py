"""Answers as HTTP carries them: JSON or a file, compressed, with an ETag; and streams of lines."""

from __future__ import annotations

import asyncio
import gzip
import hashlib
from collections.abc import AsyncGenerator, Callable, Mapping

import msgspec
from fastapi import Request
from starlette.responses import Response
from starlette.types import Message, Receive, Scope, Send

from patterndb_app.service.refusals import find_status, format_refusal, tell_error
from patterndb_app.service.work import GONE, RequestWork

JSON = "application/json"
NDJSON = "application/x-ndjson"
EVENTS = "text/event-stream"

#: Answers from so many bytes on are compressed, where the client takes that.
COMPRESSED_FROM = 1_000

#: The fastest levels save most of what there is to save in lists of numbers.
COMPRESSION = 3


def encode_answer(
    request: Request,
    content: bytes | object,
    *,
    media_type: str = JSON,
    status: int = 200,
    headers: Mapping[str, str] | None = None,
    kept: bool = False,
) -> Response:
    """Make an answer of bytes, or of what JSON takes.

    kept: may the client keep it, and ask whether it is still so (ETag, If-None-Match)? It has to
    ask each time, for patterns come and go.
    """
    body = content if isinstance(content, bytes) else msgspec.json.encode(content)
    told = {"Cache-Control": "no-cache" if kept else "no-store", **(headers or {})}
    if kept:
        tag = f'W/"{hashlib.sha256(body).hexdigest()[:32]}"'
        told["ETag"] = tag
        if is_known(request.headers.get("if-none-match"), tag):
            return Response(status_code=304, headers={**told, "Vary": "Accept-Encoding"})
    if len(body) >= COMPRESSED_FROM and media_type != "image/png":
        told["Vary"] = "Accept-Encoding"
        if takes_gzip(request.headers.get("accept-encoding", "")):
            body = gzip.compress(body, COMPRESSION, mtime=0)
            told["Content-Encoding"] = "gzip"
    return Response(body, status, told, media_type)


def is_known(asked: str | None, tag: str) -> bool:
    """Does If-None-Match name this tag? Weak and strong ones are the same for it."""
    if asked is None:
        return False
    tags = [one.strip().removeprefix("W/") for one in asked.split(",")]
    return "*" in tags or tag.removeprefix("W/") in tags


def takes_gzip(accepted: str) -> bool:
    """Does Accept-Encoding allow gzip?"""
    for one in accepted.lower().split(","):
        name, _, quality = one.partition(";")
        if name.strip() in ("gzip", "*"):
            weight = quality.strip().removeprefix("q=")
            return weight == quality.strip() or weight.strip("0.") != ""
    return False


def refuse(error: BaseException, request_id: str) -> Response:
    """The answer to a request that cannot be answered."""
    status = find_status(error)
    more: tuple[str, ...] = getattr(error, "more", ())
    document = format_refusal([tell_error(error, request_id), *more], status)
    headers: dict[str, str] = getattr(error, "headers", {})
    return Response(
        msgspec.json.encode(document), status, {"Cache-Control": "no-store", **headers}, JSON
    )


async def watch_client(receive: Receive, work: RequestWork) -> None:
    """End the work when the client goes away; the body must have been read."""
    while (await receive())["type"] != "http.disconnect":
        pass
    work.end(GONE)


class LineStream(Response):
    """A stream of what a work hands over; an error after the first byte is a line, too.

    first: what there is already. note: is told of such an error.
    """

    def __init__(
        self,
        work: RequestWork,
        first: bytes | None,
        request_id: str,
        send_seconds: float,
        note: Callable[[BaseException], None],
    ) -> None:
        super().__init__(status_code=200, media_type=NDJSON)
        del self.headers["content-length"]
        self.headers["Cache-Control"] = "no-store"
        # A proxy before us shall not wait for the end either.
        self.headers["X-Accel-Buffering"] = "no"
        self._work = work
        self._first = first
        self._request_id = request_id
        self._send_seconds = send_seconds
        self._note = note

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it. A client that goes away, or takes nothing for too long, ends the work."""
        watching = asyncio.create_task(watch_client(receive, self._work))
        try:
            start: Message = {"type": "http.response.start", "status": 200}
            await send({**start, "headers": self.raw_headers})
            async for chunk in self._chunks():
                async with asyncio.timeout(self._send_seconds):
                    await send({"type": "http.response.body", "body": chunk, "more_body": True})
            if self._work.stopped != GONE:
                await send({"type": "http.response.body", "body": b""})
        finally:
            watching.cancel()
            self._work.end(GONE)

    async def _chunks(self) -> AsyncGenerator[bytes]:
        if self._first is not None:
            yield self._first
        try:
            while (chunk := await self._work.next_chunk()) is not None:
                yield chunk
        except Exception as error:
            self._note(error)
            told = [tell_error(error, self._request_id)]
            yield msgspec.json.encode(format_refusal(told, find_status(error))) + b"\n"
