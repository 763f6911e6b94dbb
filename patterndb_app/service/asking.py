"""Routes that ask: fills of a boundary, surfaces to place them on, holes of a mesh."""

from __future__ import annotations

import asyncio
import time

from fastapi import APIRouter, Request
from starlette.datastructures import UploadFile
from starlette.responses import Response

from ingest.formats import ReadLimits
from patterndb_app.service.answers import NDJSON, LineStream, encode_answer, watch_client
from patterndb_app.service.context import (
    answer_in_thread,
    get_request_id,
    get_service,
    make_in_thread,
    note,
)
from patterndb_app.service.fillanswers import FillAnswer, make_lines, make_whole
from patterndb_app.service.guard import find_client
from patterndb_app.service.holeanswers import answer_holes, read_hole_question
from patterndb_app.service.questions import read_fill_question
from patterndb_app.service.refusals import MalformedRequestError
from patterndb_app.service.surfaces import find_suffix
from patterndb_app.service.work import RequestWork

ROUTER = APIRouter()


@ROUTER.post("/v1/fills", name="fills")
async def find_fills(request: Request) -> Response:
    """Find the fills of a boundary: whole, or with Accept: application/x-ndjson line by line."""
    service = get_service(request)
    data = await request.body()

    def ask(work: RequestWork) -> FillAnswer:
        question = read_fill_question(data, service.limits)
        database = service.catalogue.find(question.request.db)
        surface = None
        if question.request.surface is not None:
            surface = service.surfaces.find(question.request.surface).surface
        return FillAnswer(question, database, surface, service.limits, work)

    if NDJSON not in request.headers.get("accept", ""):
        body = await make_in_thread(request, lambda work: make_whole(ask(work)))
        return encode_answer(request, body)

    began = time.perf_counter()
    work = await service.workers.begin(
        find_client(request.scope), lambda work: make_lines(ask(work), work)
    )
    # What is wrong with the question is told by the status: so the first line is waited for.
    first = await first_chunk(request, work)
    service.metrics.measure("patterndb_first_line_seconds", time.perf_counter() - began)

    def fail(error: BaseException) -> None:
        request.scope["state"]["failure"] = error

    return LineStream(work, first, get_request_id(request), service.limits.send_seconds, fail)


async def first_chunk(request: Request, work: RequestWork) -> bytes | None:
    """Wait for the first of what a work hands over; a client that goes away ends it."""
    watching = asyncio.create_task(watch_client(request.receive, work))
    try:
        return await work.next_chunk()
    finally:
        watching.cancel()


@ROUTER.post("/v1/surfaces", name="surfaces")
async def keep_surface(request: Request) -> Response:
    """Keep a surface in memory, so that fills are placed on it: OBJ, PLY or OFF."""
    service = get_service(request)
    data, suffix, _ = await read_mesh_body(request)
    limits = ReadLimits(max_bytes=service.limits.mesh_bytes)

    def make(_: RequestWork) -> object:
        kept = service.surfaces.add(data, suffix, limits)
        return {
            "id": kept.id,
            "n_vertices": kept.n_vertices,
            "n_faces": kept.n_faces,
            "expires_in": round(service.surfaces.remaining(kept)),
        }

    return await answer_in_thread(request, make)


async def read_mesh_body(request: Request) -> tuple[bytes, str, str | None]:
    """The bytes of the mesh file in a body, raw or the file of a form, its suffix, and its name if
    it has one."""
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    name = request.query_params.get("name")
    if media_type != "multipart/form-data":
        data = await request.body()
    else:
        async with request.form(max_files=1, max_fields=8) as form:
            files = [one for one in form.values() if isinstance(one, UploadFile)]
            if len(files) != 1:
                raise MalformedRequestError("the form has no file; send one mesh file")
            data, name = await files[0].read(), files[0].filename
            media_type = (files[0].content_type or "").partition(";")[0].lower()
    if not data:
        raise MalformedRequestError("the body is empty; send a mesh file")
    note(request, mesh_bytes=len(data))
    return data, find_suffix(media_type, name, data), name


@ROUTER.post("/v1/holes", name="holes")
async def fill_mesh_holes(request: Request) -> Response:
    """Tell the loops of a mesh, or fill one of its holes."""
    service = get_service(request)
    data = await request.body()

    def make(work: RequestWork) -> object:
        asked, mesh = read_hole_question(data, service.limits)
        database = service.catalogue.find(asked.db)
        return answer_holes(asked, mesh, database, service.limits, work)

    return await answer_in_thread(request, make)
