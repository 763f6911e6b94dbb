"""The description of the interface, /openapi.json: schemas of what is read and answered, examples.

Bodies are declared once, as the types that read them; their schemas are made of these. Every
example is asked by a test, and what is answered is held against the schema of the answer.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
from fastapi import FastAPI

from patterndb.system.requests import Request, list_options
from patterndb_app.service.answers import NDJSON
from patterndb_app.service.holeanswers import HoleEntries
from patterndb_app.service.learning import UseEntries
from patterndb_app.service.patternpages import (
    PARAMETERS,
    PatternDetailJson,
    PatternPageJson,
    PatternPageRequest,
)
from patterndb_app.service.questions import OPTIONS, FillOptions
from patterndb_app.service.refusals import RefusalJson
from query.fill import FillJson

REF = "#/components/schemas/{name}"

#: Bodies by the paths that take them, each an example by what it shows.
EXAMPLES: dict[str, dict[str, dict[str, Any]]] = {
    "/v1/fills": {
        "four sides": {"sides": [3, 5, 4, 6], "limit": 2},
        "a strand and a reflex corner": {
            "sides": [6, 2, 4, 4, 2, 4],
            "corners": ["c", "c", "c", "r", "c", "c"],
            "strokes": [[[0, 1], [4, 1]]],
            "limit": 2,
        },
        "points": {
            "sides": [[[0, 0], [4, 0]], [[4, 0], [4, 3]], [[4, 3], [0, 0]]],
            "lengths": [4, 3, 5],
            "order": "quality",
            "limit": 1,
        },
    },
    "/v1/holes": {
        "the loops of a mesh": {
            "mesh": {
                "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
                "faces": [[0, 1, 2, 3]],
            },
            "list": True,
        },
    },
    "/v1/uses": {"a pattern by its name": {"pattern": "04b2cf5dffb2e5cf"}},
}

#: Errors that any request may be answered by.
REFUSALS = {
    "400": "The body or a parameter is not what it must be.",
    "404": "There is no such pattern, surface, job or database.",
    "413": "More than a limit allows.",
    "421": "The service does not answer for this host name.",
    "429": "Too much is at work; Retry-After says when to ask again.",
    "503": "The service stops, or its database cannot be read.",
}

#: Errors of single routes, beside those.
OWN_REFUSALS = {
    "fills": {"408": "The body came too slowly.", "422": "No quads can fill this."},
    "surfaces": {"408": "The body came too slowly.", "422": "This is no mesh."},
    "holes": {"408": "The body came too slowly.", "422": "No quads can fill this."},
    "uses": {"401": "No token.", "403": "Nothing can be changed.", "422": "This is no fill."},
    "learn_mesh": {"401": "No token.", "403": "Nothing can be changed.", "422": "No mesh."},
    "jobs": {"401": "No token.", "403": "Nothing can be changed."},
    "patterns": {"422": "A range runs backwards."},
    "cancel_job": {"401": "No token.", "403": "Nothing can be changed.", "409": "It has ended."},
}

_STRING = {"type": "string"}
_MESH_BODY = {
    "content": {
        "model/obj": {"schema": _STRING},
        "application/ply": {"schema": {"type": "string", "format": "binary"}},
        "multipart/form-data": {
            "schema": {
                "type": "object",
                "properties": {"file": {"type": "string", "format": "binary"}},
                "required": ["file"],
            }
        },
    },
    "required": True,
}

#: Media types of answers that are no JSON, by the names of their routes.
FILES = {
    "pattern_svg": "image/svg+xml",
    "pattern_png": "image/png",
    "metrics": "text/plain",
}


def describe_interface(application: FastAPI) -> dict[str, Any]:
    """Describe the interface of an application, as OpenAPI has it."""
    from fastapi.openapi.utils import get_openapi

    document = get_openapi(
        title="patterndb",
        version=application.version,
        description="Fills for boundaries, streamed from a database of quad-mesh patterns; "
        "docs/service.md has a call of each kind.",
        routes=application.routes,
    )
    schemas = _make_schemas()
    document["components"] = {
        "schemas": schemas,
        "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
    }
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            _describe_operation(path, method, operation)
    return document


def _describe_operation(path: str, method: str, operation: dict[str, Any]) -> None:
    name = operation["operationId"].partition("_v1_")[0]
    operation["operationId"] = f"{name}_{method}"
    status = "202" if name == "learn_mesh" else "200"
    content: dict[str, Any] = {"application/json": {"schema": _answer_schema(name)}}
    if name in FILES:
        content = {FILES[name]: {"schema": _STRING}}
    if name == "fills":
        content[NDJSON] = {"schema": _STRING}
    if name == "job":
        content["text/event-stream"] = {"schema": _STRING}
    good = {"description": operation["summary"], "content": content}
    responses: dict[str, Any] = {status: good}
    if method == "get" and path not in ("/v1/health", "/v1/version"):
        responses["304"] = {"description": "It is still as If-None-Match says."}
    refusal = {"application/json": {"schema": {"$ref": REF.format(name="RefusalJson")}}}
    for code, told in {**REFUSALS, **OWN_REFUSALS.get(name, {})}.items():
        responses[code] = {"description": told, "content": refusal}
    operation["responses"] = dict(sorted(responses.items()))
    if name in ("surfaces", "learn_mesh"):
        operation["requestBody"] = _MESH_BODY
    elif path in EXAMPLES:
        examples = {title: {"value": body} for title, body in EXAMPLES[path].items()}
        schema = {"$ref": REF.format(name=BODIES[path])}
        operation["requestBody"] = {
            "required": True,
            "content": {"application/json": {"schema": schema, "examples": examples}},
        }
    if name == "patterns":
        operation["parameters"] = _describe_parameters(PatternPageRequest, PARAMETERS)
    if "401" in responses:
        operation["security"] = [{"token": []}]


def _describe_parameters(kind: type[Request], names: Mapping[str, str]) -> list[dict[str, Any]]:
    """Describe the options of a request as parameters of an address."""
    schema = msgspec.json.schema_components([kind], ref_template=REF)[1][kind.__name__]
    described: dict[str, Any] = schema["properties"]
    return [
        {
            "name": names.get(name, name),
            "in": "query",
            "required": False,
            "schema": described[name],
            "description": one.text.help,
        }
        for name, one in list_options(kind).items()
    ]


#: The schemas of bodies by their paths.
BODIES = {"/v1/fills": "FillQuestion", "/v1/holes": "HoleEntries", "/v1/uses": "UseEntries"}

#: Schemas of answers by the names of their routes; others are objects.
_ANSWERS = {
    "patterns": "PatternPageJson",
    "pattern": "PatternDetailJson",
    "fills": "FillAnswer",
}


def _answer_schema(name: str) -> dict[str, Any]:
    return {"$ref": REF.format(name=_ANSWERS[name])} if name in _ANSWERS else {"type": "object"}


def _make_schemas() -> dict[str, Any]:
    kinds = [
        FillOptions,
        HoleEntries,
        UseEntries,
        RefusalJson,
        PatternPageJson,
        PatternDetailJson,
        FillJson,
    ]
    _, schemas = msgspec.json.schema_components(kinds, ref_template=REF)
    schemas["FillQuestion"] = _describe_question(schemas.pop("FillOptions"))
    fill = schemas["FillJson"]
    fill["properties"]["placed"] = {
        "type": "array",
        "items": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
    }
    schemas["FillAnswer"] = {
        "type": "object",
        "properties": {
            "sides": {"type": "array", "items": {"type": "integer"}},
            "corners": {"type": "array", "items": _STRING},
            "fills": {"type": "array", "items": {"$ref": REF.format(name="FillJson")}},
            "truncated": {"type": "boolean"},
            "complete": {"type": "boolean"},
            "stopped": {"type": ["string", "null"]},
            "reason": {"type": ["string", "null"]},
            "seconds": {"type": "number"},
        },
        "required": [
            "sides",
            "corners",
            "fills",
            "truncated",
            "stopped",
            "complete",
            "reason",
            "seconds",
        ],
    }
    return schemas


def _describe_question(options: dict[str, Any]) -> dict[str, Any]:
    """The schema of a question for fills: a boundary, counted or with points, and the options."""
    point = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3}
    line = {"type": "array", "items": point, "minItems": 2}
    counted = {"type": "array", "items": {"type": "integer", "minimum": 1}, "minItems": 1}
    edge = {"type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 2}
    strokes = {
        "type": "array",
        "items": {
            "anyOf": [
                {"type": "array", "items": edge, "minItems": 2, "maxItems": 2},
                line,
                {
                    "type": "object",
                    "properties": {
                        "points": line,
                        "loop": {"type": "boolean"},
                        "ends": {"type": "array", "items": edge, "minItems": 2, "maxItems": 2},
                    },
                    "additionalProperties": False,
                },
            ]
        },
    }
    corners = {"type": "array", "items": {"enum": ["convex", "c", "reflex", "r"]}}
    boundary = {
        "sides": {"anyOf": [counted, {"type": "array", "items": line, "minItems": 1}]},
        "corners": corners,
        "strokes": strokes,
        "loops": {"type": "integer", "minimum": 0},
        "lengths": counted,
        "edge_length": {"type": "number", "exclusiveMinimum": 0},
        "vertices": {"type": "boolean"},
    }
    described = {name: one.text.help for name, one in list_options(FillOptions).items()}
    properties = {
        name: {**options["properties"][name], "description": described[name]}
        if name in described
        else options["properties"][name]
        for name in OPTIONS
    }
    return {
        **options,
        "title": "FillQuestion",
        "properties": {**boundary, **properties},
        "required": ["sides"],
    }
