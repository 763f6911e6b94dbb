"""Routes that only look: how the service is, what its databases hold, patterns and pictures."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Path, Query, Request
from starlette.responses import Response

import patterndb
from patterndb.store.connection import SCHEMA_VERSION
from patterndb_app.service.answers import encode_answer
from patterndb_app.service.context import answer_in_thread, get_service
from patterndb_app.service.patternpages import (
    PARAMETERS,
    PATTERN_ORDERS,
    PatternPageRequest,
    describe_pattern,
    draw_pattern,
    list_page,
)
from patterndb_app.service.questions import read_parameters
from query.holes.options import LEAST_TENSION, MOST_TENSION, SHAPES
from query.listing.orders import ORDERS, default_order

ROUTER = APIRouter()

Db = Annotated[str | None, Query(max_length=256, description="The name of a database.")]
PatternName = Annotated[
    str,
    Path(pattern="^[0-9a-fA-F]{2,16}$", description="A pattern, by the first digits of its id."),
]


@ROUTER.get("/v1/health", name="health")
async def tell_health(request: Request) -> Response:
    """Tell whether questions are answered."""
    service = get_service(request)
    status = "stopping" if service.workers.stopping else "ok" if service.warm else "warming"
    document = {
        "ok": True,
        "status": status,
        "databases": service.catalogue.names,
        "at_work": service.workers.at_work,
        "waiting": service.workers.waiting,
    }
    return encode_answer(request, document)


@ROUTER.get("/v1/version", name="version")
async def tell_version(request: Request) -> Response:
    """Tell the versions of the program, of this interface, and of the databases' schema."""
    document = {"patterndb": patterndb.__version__, "api": 1, "schema": SCHEMA_VERSION}
    return encode_answer(request, document)


@ROUTER.get("/v1/limits", name="limits")
async def tell_limits(request: Request) -> Response:
    """Tell all limits: value, unit, and what each limits."""
    return encode_answer(request, {"limits": get_service(request).limits.to_json()})


@ROUTER.get("/v1/metrics", name="metrics")
async def tell_metrics(request: Request) -> Response:
    """Tell what was counted, as Prometheus reads it."""
    service = get_service(request)
    gauges = {
        "patterndb_at_work": ("Requests at work.", float(service.workers.at_work)),
        "patterndb_waiting": ("Requests waiting for a place.", float(service.workers.waiting)),
        "patterndb_surfaces": ("Surfaces kept in memory.", float(len(service.surfaces))),
        "patterndb_surface_bytes": ("Memory that they take.", float(service.surfaces.size)),
    }
    for state, count in service.jobs.count().items():
        gauges[f"patterndb_jobs_{state}"] = (f"Jobs that are {state}.", float(count))
    text = service.metrics.format(gauges)
    return encode_answer(request, text.encode(), media_type="text/plain; version=0.0.4")


@ROUTER.get("/v1/orders", name="orders")
async def list_orders(request: Request) -> Response:
    """List the orders that fills can be listed in, and patterns."""
    document = {
        "orders": [
            {
                "name": order.name,
                "first": order.first,
                "needs_points": order.needs_points,
                "needs_strokes": order.needs_strokes,
            }
            for order in ORDERS.values()
        ],
        "default": default_order(points=False, drawn=False),
        "default_with_points": default_order(points=True, drawn=False),
        "default_with_strokes": default_order(points=True, drawn=True),
        "pattern_orders": list(PATTERN_ORDERS),
    }
    return encode_answer(request, document, kept=True)


@ROUTER.get("/v1/shapes", name="shapes")
async def list_shapes(request: Request) -> Response:
    """List the shapes that fills of holes can have, the default first, and the range of tension."""
    document = {
        "shapes": [{"name": name, "what": what} for name, what in SHAPES.items()],
        "tension": [LEAST_TENSION, MOST_TENSION],
    }
    return encode_answer(request, document, kept=True)


@ROUTER.get("/v1/stats", name="stats")
async def tell_statistics(request: Request, db: Db = None) -> Response:
    """Tell the counts over a whole database."""
    database = get_service(request).catalogue.find(db)
    return await answer_in_thread(
        request,
        lambda _: {
            "db": database.name,
            **asdict(database.slow.statistics()),
        },
        kept=True,
    )


@ROUTER.get("/v1/meshes", name="meshes")
async def list_meshes(request: Request, db: Db = None) -> Response:
    """List the meshes that a database was learned from, with provenance and licence."""
    database = get_service(request).catalogue.find(db)

    def make(_: object) -> object:
        meshes = [
            {
                "mesh": mesh.name,
                "sha256": mesh.sha256,
                "origin": mesh.origin,
                "author": mesh.provenance.author,
                "source": mesh.provenance.source,
                "licence": mesh.provenance.licence,
                "quads": mesh.quads_read,
                "patches": mesh.distinct,
                "patterns": mesh.patterns,
            }
            for mesh in database.opened.meshes()
        ]
        return {"db": database.name, "meshes": meshes}

    return await answer_in_thread(request, make, kept=True)


@ROUTER.get("/v1/patterns", name="patterns")
async def list_patterns(request: Request) -> Response:
    """List the patterns of a database in pages."""
    service = get_service(request)
    asked = read_parameters(request.query_params, PatternPageRequest, PARAMETERS)
    database = service.catalogue.find(asked.db)
    choice = asked.having(limit=min(asked.limit, service.limits.page))
    return await answer_in_thread(request, lambda _: list_page(database, choice), kept=True)


@ROUTER.get("/v1/patterns/{name}.svg", name="pattern_svg")
async def draw_pattern_svg(request: Request, name: PatternName, db: Db = None) -> Response:
    """Draw a pattern, as SVG."""
    database = get_service(request).catalogue.find(db)
    return await answer_in_thread(
        request,
        lambda _: draw_pattern(database, name, ".svg"),
        media_type="image/svg+xml",
        kept=True,
    )


@ROUTER.get("/v1/patterns/{name}.png", name="pattern_png")
async def draw_pattern_png(request: Request, name: PatternName, db: Db = None) -> Response:
    """Draw a pattern, as PNG."""
    database = get_service(request).catalogue.find(db)
    return await answer_in_thread(
        request, lambda _: draw_pattern(database, name, ".png"), media_type="image/png", kept=True
    )


@ROUTER.get("/v1/patterns/{name}", name="pattern")
async def show_pattern(request: Request, name: PatternName, db: Db = None) -> Response:
    """Tell all that is known of a pattern: quads, places in the plane, where it was seen."""
    database = get_service(request).catalogue.find(db)
    return await answer_in_thread(request, lambda _: describe_pattern(database, name), kept=True)
