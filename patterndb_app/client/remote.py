"""A database that a service answers for: the same questions, fills and errors as the library's."""

from __future__ import annotations

import contextlib
import json
import socket
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from patterndb.errors import NotFoundError, PatternDBError
from patterndb.system.extras import require_extra
from patterndb.system.requests import list_changed, make_request
from query.boundary import Boundary
from query.errors import InvalidQueryError
from query.fill import Fill
from query.recognition import read_fill
from query.request import FillRequest

if TYPE_CHECKING:
    import httpx

    from patterndb.core.pattern import Pattern
    from patterndb.geometry.points import Points
    from query.stroke import Stroke

#: Seconds to wait for a connection, and for the next of an answer: longer than any search of a
#: service with the limits that it comes with.
CONNECT_SECONDS = 10.0
READ_SECONDS = 60.0

#: The status of an answer that answers.
OK = 200


class ServiceError(PatternDBError, RuntimeError):
    """A service could not be reached, or refused a request for a reason of its own.

    status: that of HTTP; None where there was no answer.
    """

    def __init__(self, message: str, status: int | None = None) -> None:
        super().__init__(message)
        self.status = status


def connect(url: str, *, db: str | None = None, token: str | None = None) -> RemoteDatabase:
    """Connect to a service that ``patterndb serve`` started, to ask it as a database.

    url: its address, such as "http://127.0.0.1:8017". db: the name of one of its databases, the
    first if not given. token: what it wants of who changes something. Raises ServiceError where
    nothing answers there, NotFoundError where it has no such database, MissingExtraError where
    httpx is not installed.

    Example: ``patterndb.connect("http://127.0.0.1:8017").fills((3, 5, 4, 6), limit=3)``
    """
    require_extra("client", "asking a service")
    remote = RemoteDatabase(url, db, token)
    names = remote.ask("GET", "/v1/health").get("databases", [])
    if db is not None and db not in names:
        remote.close()
        raise NotFoundError(f"{url} has no database {db!r}; it has {', '.join(names)}")
    return remote


class RemoteDatabase:
    """A database that a service answers for; a context manager that closes the connection.

    Several threads may use it.
    """

    def __init__(self, url: str, db: str | None = None, token: str | None = None) -> None:
        """As :func:`connect`, which makes sure that something answers."""
        import httpx

        self.url = url.rstrip("/")
        self.db = db
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        try:
            self._client = httpx.Client(
                base_url=self.url,
                headers=headers,
                timeout=httpx.Timeout(READ_SECONDS, connect=CONNECT_SECONDS),
                # A proxy of the environment is for the world, not for a service nearby.
                trust_env=False,
            )
        except (httpx.InvalidURL, ValueError) as error:
            raise ServiceError(f"{url!r} is no address of a service: {error}") from None

    def __enter__(self) -> RemoteDatabase:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<RemoteDatabase {self.db or 'the first'} of {self.url}>"

    def close(self) -> None:
        """Close the connection; the object is of no use afterwards."""
        self._client.close()

    def fills(
        self,
        boundary: Boundary | Iterable[int],
        request: FillRequest | None = None,
        *,
        surface: str | None = None,
        place: bool = False,
        **options: Any,
    ) -> RemoteFills:
        """Find the fills of a boundary, best first, as :func:`query.fills` with these options.

        surface: the id of one that :meth:`keep_surface` sent, that the fills are placed on. place:
        are they placed by the service, as :attr:`RemoteFills.placed` has them? The service
        chooses the number of threads itself.

        Nothing is asked until the first fill is. Raises what :func:`query.fills` does, ServiceError
        where the service cannot be reached or has too much to do.
        """
        if not isinstance(boundary, Boundary):
            boundary = Boundary(boundary)
        question = make_question(boundary, make_request(FillRequest, request, options))
        if self.db is not None:
            question["db"] = self.db
        if surface is not None:
            question["surface"] = surface
        question["place"] = place or surface is not None
        return RemoteFills(self._client, boundary, question)

    def best(self, boundary: Boundary | Iterable[int], **options: Any) -> Fill | None:
        """Return the first of :meth:`fills`, or None; the options are the same."""
        wanted: dict[str, Any] = {"limit": 1, **options}
        return next(self.fills(boundary, **wanted), None)

    def keep_surface(self, path: Path | str) -> str:
        """Send the mesh in a file, OBJ, PLY or OFF; return its id, for fills to be placed on it."""
        path = Path(path)
        document = self.ask(
            "POST", "/v1/surfaces", content=path.read_bytes(), params={"name": path.name}
        )
        return str(document["id"])

    def record_use(self, pattern: Pattern | Fill, count: int = 1) -> int:
        """Record that ``count`` fills were accepted, which needs the token; return how many in all.

        pattern: the fill itself, or a pattern that the database holds.
        """
        body: dict[str, Any] = {"count": count}
        if isinstance(pattern, Fill):
            body["fill"] = pattern.to_json()
        else:
            body["pattern"] = pattern.name
        if self.db is not None:
            body["db"] = self.db
        return int(self.ask("POST", "/v1/uses", json=body)["uses"])

    def ask(self, method: str, path: str, **request: Any) -> dict[str, Any]:
        """Ask for a document of the interface, such as "/v1/stats"."""
        import httpx

        if self.db is not None and method == "GET":
            request["params"] = {"db": self.db, **request.get("params", {})}
        try:
            response = self._client.request(method, path, **request)
        except httpx.HTTPError as error:
            raise ServiceError(f"{self.url} does not answer: {error}") from error
        document = read_document(response.content)
        refuse(document, response.status_code)
        return document


class RemoteFills(Iterator[Fill]):
    """An iterator over fills that a service finds, best first, as :class:`query.Fills` is.

    boundary, truncated, stopped, complete, seconds, reason: as there; known once the iterator has
    ended. placed: of every fill so far, in their order, (v, 3) places of its vertices, where the
    service was to place them.

    Another thread may call :meth:`cancel` at any time.
    """

    def __init__(self, client: httpx.Client, boundary: Boundary, question: dict[str, Any]) -> None:
        self.boundary = boundary
        self.truncated = False
        self.stopped: str | None = None
        self.seconds = 0.0
        self.reason: str | None = None
        self.placed: list[Points] = []
        self._client = client
        self._question = question
        self._response: httpx.Response | None = None
        self._cancelled = False
        self._source = self._ask()

    def __iter__(self) -> RemoteFills:
        return self

    def __next__(self) -> Fill:
        return next(self._source)

    @property
    def complete(self) -> bool:
        return self.stopped is None

    def cancel(self, why: str = "cancelled") -> None:
        """End the list as soon as may be, from whichever thread; the service ends its search.

        why: what ``stopped`` will be.
        """
        self.stopped = why
        self._cancelled = True
        if self._response is not None:
            stream = self._response.extensions.get("network_stream")
            end = None if stream is None else stream.get_extra_info("socket")
            if end is not None:
                # Closing alone would not wake the thread that reads.
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)

    def _ask(self) -> Iterator[Fill]:
        import httpx

        headers = {"Accept": "application/x-ndjson"}
        try:
            with self._client.stream(
                "POST", "/v1/fills", json=self._question, headers=headers
            ) as response:
                self._response = response
                if response.status_code != OK:
                    refuse(read_document(response.read()), response.status_code)
                for line in response.iter_lines():
                    if self._cancelled:
                        return
                    document = read_document(line.encode())
                    refuse(document, int(document.get("status", 200)))
                    if document.get("done"):
                        self._end(document)
                        return
                    if "placed" in document:
                        self.placed.append(np.array(document["placed"], np.float64).reshape(-1, 3))
                    yield make_fill(document, self.boundary)
            if self.stopped is None:
                raise ServiceError("the service closed the connection before the list was whole")
        except httpx.HTTPError as error:
            if not self._cancelled:
                raise ServiceError(f"the service does not answer: {error}") from error
        finally:
            self._response = None
            self.truncated = self.truncated or self.stopped is not None

    def _end(self, document: Mapping[str, Any]) -> None:
        self.truncated = bool(document["truncated"])
        self.stopped = document["stopped"]
        self.seconds = float(document["seconds"])
        self.reason = document["reason"]


def make_question(boundary: Boundary, request: FillRequest) -> dict[str, Any]:
    """Return the body that asks the same as :func:`query.fills` with a request.

    Raises InvalidQueryError where the list is to have no limit.
    """
    if request.limit is None:
        raise InvalidQueryError("a service lists no fills without a limit; give one")
    question = list_changed(request)
    question.pop("threads", None)
    strokes: tuple[Stroke, ...] = question.pop("strokes", ())
    question["corners"] = list(boundary.corners)
    if boundary.points is None:
        question["sides"] = list(boundary.lengths)
        question["strokes"] = [[s.start, s.end] for s in strokes if not s.is_loop]
        question["loops"] = sum(stroke.is_loop for stroke in strokes)
        return question
    ring = np.concatenate([boundary.points, boundary.points[:1]]).tolist()
    question["sides"] = [ring[first : last + 1] for first, last in pairwise(boundary.side_starts)]
    question["vertices"] = True
    drawn: list[dict[str, Any]] = []
    for stroke in strokes:
        entries: dict[str, Any] = {"loop": True} if stroke.is_loop else {}
        if not stroke.is_loop:
            entries["ends"] = [stroke.start, stroke.end]
        if stroke.points is not None:
            entries["points"] = stroke.points.tolist()
        drawn.append(entries)
    question["strokes"] = drawn
    return question


def make_fill(document: Mapping[str, Any], boundary: Boundary) -> Fill:
    """The fill that a line of an answer is.

    Raises ServiceError where the quads are not of the pattern that they are said to be.
    """
    quads = np.array(document["quads"], np.int32).reshape(-1, 4)
    found = read_fill(quads, boundary, document["origin"])
    if found.pattern.name != document["pattern"]:
        raise ServiceError(
            f"the service says pattern {document['pattern']}, but the quads are of "
            f"{found.pattern.name}; the two are of different versions"
        )
    return replace(
        found,
        n_vertices=document["n_vertices"],
        pattern=replace(found.pattern, frequency=document["frequency"]),
        widths=tuple(document["widths"]),
        rotation=document["rotation"],
        mirrored=document["mirrored"],
        n_irregular=document["n_irregular"],
        n_irregular_boundary=document["n_irregular_boundary"],
        flow_distance=document["flow_distance"],
    )


def read_document(data: bytes) -> dict[str, Any]:
    """The JSON object of an answer; ServiceError where it is none."""
    try:
        document = json.loads(data)
    except ValueError:
        document = None
    if not isinstance(document, dict):
        raise ServiceError("what answers there is no service of patterndb")
    return cast("dict[str, Any]", document)


def refuse(document: Mapping[str, Any], status: int) -> None:
    """Raise the error that an answer tells, as the library would; nothing where it tells none."""
    if document.get("ok", True) and status < 400:
        return
    message = str(document.get("error", f"status {status}"))
    if status == 404:
        raise NotFoundError(message)
    if status in (400, 413, 422):
        raise InvalidQueryError(message)
    raise ServiceError(message, status)
