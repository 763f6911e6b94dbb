"""What the routes of one service share, and how they get at it."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import msgspec
from fastapi import Request
from starlette.responses import Response

from patterndb_app.service.answers import JSON, encode_answer, watch_client
from patterndb_app.service.catalogue import Catalogue
from patterndb_app.service.guard import LOOPBACK, find_client
from patterndb_app.service.jobs import JobBook
from patterndb_app.service.limits import DEFAULT_LIMITS, Limits
from patterndb_app.service.metrics import Metrics
from patterndb_app.service.refusals import ClientGoneError, StoppingError
from patterndb_app.service.surfaces import SurfaceCache
from patterndb_app.service.work import GONE, STOPPING, RequestWork, Workers

T = TypeVar("T")

#: Where the page's files are, once they are built.
BUNDLE = Path(__file__).resolve().parents[1] / "web" / "bundle"


@dataclass(frozen=True, slots=True)
class ServiceSettings:
    """How a service is started.

    databases: files, None for the starter database; the first is asked where none is named. hosts:
    names that requests may be for, beside those of this machine for itself. token: what whoever
    changes a database must show; None: nothing can be changed. page: the folder of the page. warm:
    is what questions need loaded at the start?
    """

    databases: tuple[Path | None, ...] = (None,)
    hosts: tuple[str, ...] = ()
    token: str | None = field(default=None, repr=False)
    limits: Limits = DEFAULT_LIMITS
    page: Path = BUNDLE
    warm: bool = True

    @property
    def all_hosts(self) -> tuple[str, ...]:
        """All names that requests may be for."""
        return (*LOOPBACK, *self.hosts)


class Service:
    """The parts of a running service."""

    def __init__(self, settings: ServiceSettings) -> None:
        """Open its databases; raises DatabaseError where one cannot be."""
        limits = settings.limits
        self.settings = settings
        self.limits = limits
        self.metrics = Metrics()
        self.workers = Workers(
            limits, lambda why: self.metrics.count("patterndb_ended_total", why=why)
        )
        self.surfaces = SurfaceCache(limits.surfaces_bytes, limits.surface_seconds)
        self.catalogue = Catalogue(settings.databases)
        changeable = {
            database.name: database.path
            for database in self.catalogue
            if database.path is not None and settings.token is not None
        }
        # Half of the processors go on answering.
        self.jobs = JobBook(changeable, limits.jobs, max(1, (os.cpu_count() or 1) // 2))
        self.warm = not settings.warm

    def close(self) -> None:
        """End what is at work, and close the databases."""
        self.workers.stop()
        self.jobs.stop()
        self.workers.close()
        self.catalogue.close()


def get_service(request: Request) -> Service:
    """The service that a request is for."""
    return request.app.state.service


def get_request_id(request: Request) -> str:
    """The id that stands in the answer's headers and in the log."""
    return request.state.request_id


def note(request: Request, **entries: object) -> None:
    """Have the request's line of log say more."""
    request.scope["state"].setdefault("noted", {}).update(entries)


async def make_in_thread(request: Request, make: Callable[[RequestWork], bytes]) -> bytes:
    """Make an answer in a thread, and wait for all of it.

    Raises ClientGoneError where the client goes away meanwhile, which ends the work.
    """
    service = get_service(request)
    work = await service.workers.begin(
        find_client(request.scope), lambda work: work.put(make(work))
    )
    watching = asyncio.create_task(watch_client(request.receive, work))
    chunks: list[bytes] = []
    try:
        while (chunk := await work.next_chunk()) is not None:
            chunks.append(chunk)
    finally:
        watching.cancel()
        work.end(GONE)
    if not chunks:
        if work.stopped == STOPPING:
            raise StoppingError("the service is being stopped", headers={"Retry-After": "10"})
        raise ClientGoneError("the client went away before its answer was there")
    return b"".join(chunks)


async def answer_in_thread(
    request: Request,
    make: Callable[[RequestWork], object],
    *,
    media_type: str = JSON,
    headers: Mapping[str, str] | None = None,
    kept: bool = False,
) -> Response:
    """Make an answer in a thread: bytes, or what JSON takes; see :func:`encode_answer`."""

    def encode(work: RequestWork) -> bytes:
        made = make(work)
        return made if isinstance(made, bytes) else msgspec.json.encode(made)

    body = await make_in_thread(request, encode)
    return encode_answer(request, body, media_type=media_type, headers=headers, kept=kept)
