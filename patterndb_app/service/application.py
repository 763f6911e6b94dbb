"""The application: routes, what guards them, and what happens at its start and end."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncGenerator
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

import patterndb
from patterndb.errors import PatternDBError
from patterndb_app.service import asking, learning, looking, page
from patterndb_app.service.answers import encode_answer, refuse
from patterndb_app.service.context import Service, ServiceSettings, get_request_id
from patterndb_app.service.guard import Guard
from patterndb_app.service.metrics import LOG
from patterndb_app.service.openapi import describe_interface
from patterndb_app.service.refusals import format_refusal

#: Paths whose bodies hold meshes.
LARGE = ("/v1/surfaces", "/v1/holes", "/v1/meshes")


def make_application(settings: ServiceSettings | None = None) -> FastAPI:
    """Make the application of a service; its databases are opened here.

    Raises DatabaseError where one cannot be.
    """
    service = Service(settings or ServiceSettings())

    @contextlib.asynccontextmanager
    async def live(_: FastAPI) -> AsyncGenerator[None]:
        service.jobs.start()
        warming = asyncio.create_task(asyncio.to_thread(warm, service))
        try:
            yield
        finally:
            service.workers.stop()
            await warming
            await asyncio.to_thread(service.close)

    application = FastAPI(
        title="patterndb",
        version=patterndb.__version__,
        docs_url=None,  # the pages of FastAPI load scripts from elsewhere
        redoc_url=None,
        openapi_url="/openapi.json",
        lifespan=live,
    )
    application.state.service = service
    application.openapi = lambda: application.openapi_schema or remember_interface(application)
    for router in (looking.ROUTER, asking.ROUTER, learning.ROUTER, page.ROUTER):
        application.include_router(router)
    application.add_exception_handler(PatternDBError, answer_error)
    application.add_exception_handler(RequestValidationError, answer_wrong_parameters)
    application.add_exception_handler(HTTPException, answer_http_error)
    application.add_middleware(
        Guard,
        limits=service.limits,
        hosts=service.settings.all_hosts,
        large=LARGE,
        metrics=service.metrics,
    )
    return application


def remember_interface(application: FastAPI) -> dict[str, Any]:
    """Describe the interface, once."""
    application.openapi_schema = describe_interface(application)
    return application.openapi_schema


def warm(service: Service) -> None:
    """Load what nearly every question needs; a database that fails says so when it is asked."""
    try:
        if service.settings.warm:
            service.catalogue.warm(lambda: service.workers.stopping)
    except PatternDBError as error:
        LOG.warning("a database could not be read at the start: %s", error)
    service.warm = True


async def answer_error(request: Request, error: Exception) -> Response:
    """Answer a request that was refused, or that the library refuses."""
    request.scope["state"]["failure"] = error
    return refuse(error, get_request_id(request))


async def answer_wrong_parameters(request: Request, error: Exception) -> Response:
    """Answer a request whose parameters are not what they must be, naming all that are wrong."""
    assert isinstance(error, RequestValidationError)
    messages = [
        f"{'.'.join(str(step) for step in one['loc'][1:])}: {one['msg']}" for one in error.errors()
    ]
    return encode_answer(request, format_refusal(messages, 400), status=400)


async def answer_http_error(request: Request, error: Exception) -> Response:
    """Answer a request for what there is not: another path, or another method."""
    assert isinstance(error, HTTPException)
    told = {
        404: f"there is nothing at {request.url.path[:100]}; /openapi.json lists what there is",
        405: f"{request.method} is not answered at {request.url.path[:100]}",
    }.get(error.status_code, str(error.detail))
    document = format_refusal([told], error.status_code)
    return encode_answer(request, document, status=error.status_code, headers=error.headers)
