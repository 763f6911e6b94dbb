"""What every request passes before it is looked at: who may ask, how much, and how slowly.

Hosts: a page of another site could have its name point to this machine, and ask as if it were the
service's own page; so a request must name a host that the service answers for. Origins: what
changes something, or costs work, is refused where a page of another site asks.
"""

from __future__ import annotations

import asyncio
import re
import time
import traceback
import uuid
from collections.abc import Collection, Mapping
from urllib.parse import urlsplit

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from patterndb_app.service.answers import refuse
from patterndb_app.service.limits import Limits
from patterndb_app.service.metrics import Metrics, log_request
from patterndb_app.service.refusals import (
    ClientGoneError,
    ForeignOriginError,
    LargeRequestError,
    LongHeadersError,
    MalformedRequestError,
    RefusedRequestError,
    SlowClientError,
    UnknownHostError,
    find_status,
)

#: Names of this machine for itself.
LOOPBACK = ("127.0.0.1", "localhost", "::1")

#: Methods that change nothing and cost little.
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")

#: What a request may call itself, to be found again in the logs of several programs.
REQUEST_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")

#: Bytes of a request's headers.
HEADER_BYTES = 16_384

#: Headers that every answer has, unless it has its own.
HEADERS = {
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
}


class Guard:
    """The outermost layer: it refuses, counts, and writes the log."""

    def __init__(
        self,
        app: ASGIApp,
        limits: Limits,
        hosts: Collection[str],
        large: Collection[str],
        metrics: Metrics,
    ) -> None:
        """hosts: names that requests may be for. large: paths whose bodies hold meshes."""
        self._app = app
        self._limits = limits
        self._hosts = frozenset(host.lower().strip("[]") for host in hosts)
        self._large = frozenset(large)
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = {
            name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]
        }
        asked = headers.get("x-request-id", "")
        request_id = asked if REQUEST_ID.fullmatch(asked) else uuid.uuid4().hex
        scope.setdefault("state", {})["request_id"] = request_id
        # HEAD is answered as GET is, without the body.
        asked_head = scope["method"] == "HEAD"
        answer = _Watched(send, request_id, without_body=asked_head)
        inner = {**scope, "method": "GET"} if asked_head else scope
        body = _LimitedBody(receive, self._limits, self._limit_of(scope["path"]))
        began = time.perf_counter()
        failure: BaseException | None = None
        try:
            self._check(scope, headers, body.most)
            await self._app(inner, body.receive, answer.send)
        except asyncio.CancelledError:
            raise
        except Exception as error:
            failure = error
            if not answer.status:
                await refuse(error, request_id)(scope, receive, answer.send)
        finally:
            self._note(scope, inner, answer, request_id, time.perf_counter() - began, failure)
        if failure is not None and not answer.ended and not isinstance(failure, ClientGoneError):
            # Only so does the server close the connection: the answer must not look whole.
            raise failure

    def _limit_of(self, path: str) -> int:
        limits = self._limits
        return limits.mesh_bytes if path in self._large else limits.question_bytes

    def _check(self, scope: Scope, headers: Mapping[str, str], most: int) -> None:
        """Raise what the headers alone are refused for."""
        if sum(map(len, headers)) + sum(map(len, headers.values())) > HEADER_BYTES:
            raise LongHeadersError(
                f"the headers have more than {HEADER_BYTES:,} bytes",
                headers={"Connection": "close"},
            )
        host = headers.get("host", "")
        if split_host(host) not in self._hosts:
            raise UnknownHostError(
                f"this service does not answer for {host[:64]!r}; it is started with --allow-host "
                "NAME for other names than those of this machine"
            )
        if scope["method"] not in SAFE_METHODS:
            origin = headers.get("origin")
            if origin is not None and find_host(origin) != host.lower():
                raise ForeignOriginError(
                    f"a page of {origin[:64]!r} may not ask here; pages of the service itself may"
                )
        length = headers.get("content-length", "0")
        if not length.isdecimal():
            raise MalformedRequestError("Content-Length is no number")
        if int(length) > most:
            raise _too_large(most)

    def _note(
        self,
        scope: Scope,
        inner: Scope,
        answer: _Watched,
        request_id: str,
        seconds: float,
        failure: BaseException | None,
    ) -> None:
        route = getattr(inner.get("route"), "path", "none")
        status = answer.status or 499
        if failure is not None and not isinstance(failure, RefusedRequestError):
            status = find_status(failure)
        self._metrics.count(
            "patterndb_requests_total", method=scope["method"], route=route, status=str(status)
        )
        self._metrics.measure("patterndb_request_seconds", seconds, route=route)
        entries: dict[str, object] = {
            "id": request_id,
            "client": find_client(scope),
            "method": scope["method"],
            "path": scope["path"],
            "route": route,
            "status": status,
            "bytes": answer.bytes,
            "seconds": round(seconds, 5),
            **scope["state"].get("noted", {}),
        }
        error = failure or scope["state"].get("failure")
        if error is not None:
            entries["error"] = str(error)
            if find_status(error) >= 500:
                self._metrics.count("patterndb_errors_total")
                entries["traceback"] = "".join(traceback.format_exception(error))
        log_request(**entries)


def find_client(scope: Scope) -> str:
    """The address of who asks."""
    client = scope.get("client")
    return client[0] if client else "local"


def split_host(host: str) -> str:
    """The name in a Host header, without its port and the brackets of IPv6."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.partition(":")[0].lower()


def find_host(origin: str) -> str | None:
    """The host and port of an Origin header; None for what is none."""
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return None


def _too_large(most: int) -> LargeRequestError:
    # What was not read of the body is not waited for.
    return LargeRequestError(
        f"the body has more than {most:,} bytes, the most that is read here",
        headers={"Connection": "close"},
    )


class _LimitedBody:
    """The body of a request as it arrives: refused when it is too long, or too slow."""

    def __init__(self, receive: Receive, limits: Limits, most: int) -> None:
        self.most = most
        self._receive = receive
        self._seconds = limits.body_seconds
        self._deadline = asyncio.get_running_loop().time() + limits.body_seconds
        self._read = 0
        self._whole = False

    async def receive(self) -> Message:
        """As ASGI's; what comes after the body, that the client goes, may come at any time."""
        if self._whole:
            return await self._receive()
        try:
            async with asyncio.timeout_at(self._deadline):
                message = await self._receive()
        except TimeoutError:
            raise SlowClientError(
                f"the body did not arrive within {self._seconds:g} s",
                headers={"Connection": "close"},
            ) from None
        if message["type"] == "http.disconnect":
            self._whole = True
            return message
        self._read += len(message.get("body", b""))
        self._whole = not message.get("more_body", False)
        if self._read > self.most:
            raise _too_large(self.most)
        return message


class _Watched:
    """What is sent: its status and size, with the headers that every answer has."""

    def __init__(self, send: Send, request_id: str, *, without_body: bool) -> None:
        self.status = 0
        self._without_body = without_body
        self.bytes = 0
        self.ended = False
        self._send = send
        self._request_id = request_id

    async def send(self, message: Message) -> None:
        """As ASGI's."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = list(message.get("headers", []))
            there = {name.lower() for name, _ in headers}
            for name, value in {**HEADERS, "x-request-id": self._request_id}.items():
                if name.encode() not in there:
                    headers.append((name.encode(), value.encode()))
            message = {**message, "headers": headers}
        elif message["type"] == "http.response.body":
            if self._without_body:
                message = {**message, "body": b""}
            self.bytes += len(message.get("body", b""))
            self.ended = not message.get("more_body", False)
        await self._send(message)
