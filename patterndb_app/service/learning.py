"""Routes that change a database, for who shows the token: accepted fills, and meshes to learn."""

from __future__ import annotations

import asyncio
import hmac
from collections.abc import AsyncGenerator
from typing import Annotated, Any, cast

import msgspec
from fastapi import APIRouter, Path, Query, Request
from msgspec import Meta
from starlette.responses import Response, StreamingResponse

import patterndb
from patterndb.core.pattern import Pattern
from patterndb.core.patternclass import ORIGINS
from patterndb.store import LearningOptions, Provenance
from patterndb.system.documents import JsonModel
from patterndb.system.requests import Positive, Text
from patterndb_app.service.answers import EVENTS, encode_answer
from patterndb_app.service.asking import read_mesh_body
from patterndb_app.service.catalogue import ServedDatabase
from patterndb_app.service.context import answer_in_thread, get_service
from patterndb_app.service.jobs import ENDED, Job
from patterndb_app.service.looking import Db
from patterndb_app.service.questions import read_body
from patterndb_app.service.refusals import (
    MalformedRequestError,
    ReadOnlyServiceError,
    TokenError,
)
from patterndb_app.service.work import RequestWork
from query.boundary import Boundary
from query.recognition import read_fill

ROUTER = APIRouter()

JobId = Annotated[str, Path(pattern="^[0-9a-f]{32}$", description="What posting the mesh gave.")]
MaybeText = Annotated[str | None, Query(max_length=500)]

#: Quads of the largest patches that a job may take of a mesh, by mode. Larger ones take hours, and
#: of basic ones, which grow fastest in number, cannot be broken off at once.
MOST_BASIC, MOST_SIDE, MOST_CONVEX = 8, 16, 80

Basic = Annotated[int | None, Query(ge=0, le=MOST_BASIC, description="Quads of basic patches.")]
Side = Annotated[int | None, Query(ge=0, le=MOST_SIDE, description="Quads of patches on sides.")]
Convex = Annotated[int | None, Query(ge=0, le=MOST_CONVEX, description="Quads of convex ones.")]

#: Seconds between two looks at a job whose progress is streamed.
LOOK_SECONDS = 0.2

#: Looks without news after which a stream says that it is alive.
QUIET_LOOKS = 50


class UseEntries(JsonModel):
    """An accepted fill: the name of its pattern, or the fill as it was answered."""

    db: Text | None = None
    pattern: Annotated[str, Meta(pattern="^[0-9a-fA-F]{2,16}$")] | None = None
    fill: dict[str, Any] | None = None
    count: Positive = 1


def refuse_without_token(request: Request) -> None:
    """Raise what a request is refused for that may change nothing."""
    token = get_service(request).settings.token
    if token is None:
        raise ReadOnlyServiceError(
            "nothing can be changed here: the service was started without --write-token-file"
        )
    scheme, _, shown = request.headers.get("authorization", "").partition(" ")
    if scheme.lower() != "bearer" or not hmac.compare_digest(
        shown.strip().encode("latin-1", "replace"), token.encode()
    ):
        raise TokenError(
            "this changes a database, and needs the token: Authorization: Bearer TOKEN",
            headers={"WWW-Authenticate": 'Bearer realm="patterndb"'},
        )


def find_changeable(request: Request, name: str | None) -> ServedDatabase:
    """The database of a name, or the first, if it may be changed."""
    database = get_service(request).catalogue.find(name)
    if database.path is None:
        raise ReadOnlyServiceError("the starter database is never changed; name another as db")
    return database


@ROUTER.post("/v1/uses", name="uses")
async def record_use(request: Request) -> Response:
    """Record that a fill was accepted: with use_counts it counts like a patch that was seen."""
    refuse_without_token(request)
    data = await request.body()

    def make(_: RequestWork) -> object:
        entries = read_body(data, get_service(request).limits, "a use").read(UseEntries)
        database = find_changeable(request, entries.db)
        pattern = find_used(entries, database)
        with patterndb.open(database.path, "write") as opened:
            uses = opened.record_use(pattern, entries.count)
        return {"pattern": pattern.name, "uses": uses}

    return await answer_in_thread(request, make)


def find_used(entries: UseEntries, database: ServedDatabase) -> Pattern:
    """The pattern that was used: one that the database holds, or that of the fill's quads."""
    if (entries.pattern is None) == (entries.fill is None):
        raise MalformedRequestError("give the name of a pattern, or a fill as it was answered")
    if entries.pattern is not None:
        name = entries.pattern
        return database.opened.pattern(name)
    fill = cast("dict[str, Any]", entries.fill)
    origin = fill.get("origin")
    if origin not in ORIGINS:
        raise MalformedRequestError(f"fill.origin: give one of {', '.join(ORIGINS)}")
    try:
        sides = msgspec.convert(fill.get("sides"), list[list[int]])
        quads = msgspec.convert(fill.get("quads"), list[tuple[int, int, int, int]])
    except msgspec.ValidationError as error:
        raise MalformedRequestError(
            f"fill: sides and quads as they were answered ({error})"
        ) from None
    closed = len(sides) == 1 and len(sides[0]) > 1 and sides[0][0] == sides[0][-1]
    boundary = Boundary([len(side) - 1 for side in sides], () if closed else None)
    pattern = read_fill(quads, boundary, origin).pattern
    named = fill.get("pattern", pattern.name)
    if named != pattern.name:
        raise MalformedRequestError(
            f"fill.pattern: the quads are of pattern {pattern.name}, not {str(named)[:16]!r}"
        )
    return pattern


@ROUTER.post("/v1/meshes", name="learn_mesh", status_code=202)
async def learn_mesh(
    request: Request,
    name: Annotated[str | None, Query(max_length=100, description="What it is called.")] = None,
    author: MaybeText = None,
    source: MaybeText = None,
    licence: MaybeText = None,
    basic: Basic = None,
    side: Side = None,
    convex: Convex = None,
    db: Db = None,
) -> Response:
    """Learn a mesh: the answer is a job, whose progress /v1/jobs/{id} tells."""
    refuse_without_token(request)
    service = get_service(request)
    database = find_changeable(request, db)
    data, suffix, sent = await read_mesh_body(request)
    default = LearningOptions()
    try:
        options = LearningOptions(
            basic=default.basic if basic is None else basic,
            side=default.side if side is None else side,
            convex=default.convex if convex is None else convex,
        )
    except ValueError as error:
        raise MalformedRequestError(str(error)) from None
    called = name or sent or "mesh"
    if not called.lower().endswith(suffix):
        called += suffix
    job = await asyncio.to_thread(
        service.jobs.add, database.name, data, called, options, Provenance(author, source, licence)
    )
    headers = {"Location": f"/v1/jobs/{job.id}"}
    return encode_answer(request, job.to_json(), status=202, headers=headers)


@ROUTER.get("/v1/jobs", name="jobs")
async def list_jobs(request: Request) -> Response:
    """List the jobs, the newest first; needs the token."""
    refuse_without_token(request)
    jobs = [job.to_json() for job in get_service(request).jobs.list_all()]
    return encode_answer(request, {"jobs": jobs})


@ROUTER.get("/v1/jobs/{id}", name="job")
async def tell_job(request: Request, id: JobId) -> Response:
    """Tell how far a job is; with Accept: text/event-stream, each time that it gets on."""
    jobs = get_service(request).jobs
    job = jobs.find(id)
    if EVENTS not in request.headers.get("accept", ""):
        return encode_answer(request, job.to_json())

    async def tell() -> AsyncGenerator[bytes]:
        told: Job | None = None
        quiet = 0
        while True:
            now = jobs.find(id)
            if now != told:
                told, quiet = now, 0
                yield b"event: %b\ndata: %b\n\n" % (
                    now.state.encode(),
                    msgspec.json.encode(now.to_json()),
                )
            if now.state in ENDED or get_service(request).workers.stopping:
                return
            quiet += 1
            if quiet % QUIET_LOOKS == 0:
                yield b": still there\n\n"
            await asyncio.sleep(LOOK_SECONDS)

    return StreamingResponse(tell(), media_type=EVENTS, headers={"Cache-Control": "no-store"})


@ROUTER.delete("/v1/jobs/{id}", name="cancel_job")
async def cancel_job(request: Request, id: JobId) -> Response:
    """Cancel a job; what it learned so far is given up."""
    refuse_without_token(request)
    job = await asyncio.to_thread(get_service(request).jobs.cancel, id)
    return encode_answer(request, job.to_json())
