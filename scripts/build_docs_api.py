"""The page of the Python interface: what can be imported from where, from its docstrings."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterable, Mapping
from typing import Any

from build_docs_markdown import NOTICE, anchors, fence, prose, tidy
from build_docs_signatures import one_line, returned, signature

#: The modules of the API page, each with the names it documents; None: its ``__all__``.
MODULES: dict[str, tuple[str, ...] | None] = {
    "patterndb": None,
    "patterndb.geometry.surface": ("SurfacePoints", "Repairs"),
    "patterndb.store": None,
    "ingest": None,
    "query": None,
    "query.placing": None,
    "query.boundaryfile": ("parse_boundary", "read_boundary", "read_strokes"),
    "patterndb_sketch.surfacing": None,
    "patterndb_sketch.surfacing.chords": ("Decomposition", "decompose", "find_affordable"),
    "patterndb_sketch.surfacing.tessellation": ("PatchMesh", "minimal_area", "tessellate_patch"),
    "patterndb_sketch.surfacing.quads": ("count_even_edges", "fill_with_quads"),
    "patterndb_sketch.features.strokes": (
        "FeatureStroke",
        "RecoveredCurve",
        "Figures",
        "Spread",
        "recover_curve",
    ),
    "patterndb_sketch.features.snap": ("Snap", "SnapSettings", "FeatureCurve", "snap"),
    "patterndb_sketch.features.splines": ("Spline", "SplineFit", "fit_spline"),
    "patterndb_sketch.features.drag": ("MatrixCamera", "Drag", "begin_drag", "move_drag"),
    "patterndb_sketch.features.files.strokesjson": ("read_strokes", "write_strokes"),
    "patterndb_sketch.features.files.networkjson": (
        "write_network",
        "read_curves",
        "write_curves",
    ),
    "patterndb_sketch.features.files.templatejson": ("read_template", "write_template"),
    "patterndb_sketch.features.files.shapearrays": ("read_shapes", "write_shapes"),
    "patterndb_sketch.features.registration": None,
    "patterndb_sketch.features.shapemodel": None,
    "patterndb_sketch.sessions": ("SessionFormat",),
    "patterndb_sketch.features.session": ("FeatureSession", "SessionCurve"),
    "patterndb_sketch.features.errors": ("InvalidFeatureError",),
    "patterndb_sketch.retopo": None,
    "patterndb_sketch.retopo.editor": ("Call", "Retopology", "Outcome", "State"),
    "patterndb_sketch.retopo.table": ("TOOLS", "describe_tools"),
    "patterndb_sketch.retopo.tool": ("Tool", "Control", "ToolWork", "Result"),
    "patterndb_sketch.retopo.tracing": ("SurfaceCurve", "clean_stroke"),
    "patterndb_sketch.retopo.network": ("Network", "Node", "Chain", "Patch"),
    "patterndb_sketch.retopo.filling": (
        "FilledNetwork",
        "RetopoMesh",
        "fill_network",
        "weld_patches",
        "rank_fills",
    ),
    "patterndb_sketch.retopo.filling.report": ("Report", "report_mesh", "hausdorff"),
    "patterndb_sketch.retopo.script": (
        "Script",
        "ScriptLine",
        "read_script",
        "write_script",
        "play_script",
    ),
    "patterndb_sketch.retopo.session": ("RetopoSession",),
    "patterndb_sketch.retopo.symmetry": None,
    "patterndb_sketch.retopo.quadimport": ("QuadImport", "import_quads"),
    "viewer": None,
    "viewer.surfacing": None,
    "viewer.features": None,
    "viewer.shapes": None,
    "viewer.retopo": None,
    "patterndb.core.pattern": ("Pattern",),
    "patterndb.core.patternclass": ("PatternClass",),
    "patterndb.core.disk": ("Disk",),
    "patterndb.core.polygonmesh": ("PolygonMesh",),
    "query.request": ("FillRequest", "PatternFilter"),
    "query.families.family": ("Family", "load_family"),
    "patterndb.errors": (
        "InvalidMeshError",
        "MeshFileError",
        "UnsupportedFormatError",
        "InvalidCodeError",
        "InvalidBoundaryError",
        "DatabaseError",
        "NotFoundError",
        "MissingExtraError",
    ),
    "query.errors": ("InvalidQueryError",),
}


def api_page() -> str:
    lines = [
        NOTICE,
        "# Python interface\n",
        "What can be imported from where. Arrays are numpy's; a shape such as (q, 4) names its "
        "sizes. The words are those of [definitions.md](definitions.md).\n",
    ]
    body: list[str] = []
    home: dict[int, str] = {}
    taken: list[str] = []
    for module_name, names in MODULES.items():
        module = importlib.import_module(module_name)
        listed: list[str] = []
        for name in names or sorted(module.__all__):
            thing = getattr(module, name)
            title = f"{module_name}.{name}"
            if id(thing) not in home:
                taken.append(title)
                home[id(thing)] = anchors(taken)[-1]
                body += [f"### {title}\n", *describe(name, thing)]
            listed.append(f"[`{name}`](#{home[id(thing)]})")
        lines.append(f"- `{module_name}`: {', '.join(listed)}")
    return "\n".join([*lines, "", *tidy(body)]).rstrip() + "\n"


def describe(name: str, thing: Any) -> list[str]:
    if isinstance(thing, Mapping):
        entries = ", ".join(f"`{entry}`" for entry in thing)
        return [f"The table of {name.lower()}, by name: {entries}.", ""]
    if isinstance(thing, tuple):
        entries = ", ".join(f"`{getattr(entry, 'name', entry)}`" for entry in thing)
        return [f"The table of {name.lower()}: {entries}.", ""]
    if not inspect.isclass(thing):
        names = inspect.signature(thing).parameters
        return [*fence("python", signature(name, thing)), *prose(thing.__doc__, names)]
    bases = [b.__name__ for b in thing.__bases__ if b is not object]
    head = f"class {name}" + (f"({', '.join(bases)})" if bases else "")
    made_of: Iterable[str] = ()
    if "__init__" in vars(thing) and not getattr(thing, "_is_protocol", False):
        # What a constructor sets is told of like what it takes.
        made_of = [*inspect.signature(thing.__init__).parameters][1:]
        made_of += [name for name in thing.__init__.__code__.co_names if name not in made_of]
        if not issubclass(thing, Exception):
            head = "class " + signature(name, thing.__init__, drop_first=True)
    lines = [*fence("python", head), *prose(thing.__doc__, [*made_of, *vars(thing)])]
    for member, value in vars(thing).items():
        if member.startswith("_"):
            continue
        if isinstance(value, property):
            returns = returned(value.fget)
            lines += [f"**`{member}`**{f' → `{returns}`' if returns else ''}", ""]
            lines += prose(value.fget.__doc__ if value.fget else None)
        elif isinstance(value, classmethod | staticmethod):
            text = signature(member, value.__func__, drop_first=isinstance(value, classmethod))
            lines += [f"**`{name}.{one_line(text)}`**", "", *prose(value.__func__.__doc__)]
        elif inspect.isfunction(value):
            text = signature(member, value, drop_first=True)
            lines += [f"**`.{one_line(text)}`**", "", *prose(value.__doc__)]
    return lines
