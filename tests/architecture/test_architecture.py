"""Which part may import which: read from the source, lazy imports within functions included."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.support.shared import CHECKOUT

PACKAGES = ("patterndb", "ingest", "query", "patterndb_sketch", "viewer", "patterndb_app")

#: What each package may import of the others. The command line stands above them all; it, the
#: service and its client are counted as packages of their own.
ALLOWED = {
    "patterndb": set[str](),
    "ingest": {"patterndb"},
    "query": {"patterndb"},
    "patterndb_sketch": {"patterndb", "query"},
    "viewer": {"patterndb", "query", "patterndb_sketch"},
    "patterndb_app.client": {"patterndb", "query"},
    "patterndb_app.service": {"patterndb", "ingest", "query"},
    "patterndb_app.cli": {
        "patterndb",
        "ingest",
        "query",
        "patterndb_sketch",
        "viewer",
        "patterndb_app.client",
        "patterndb_app.service",
    },
}

#: The one exception: the face, by which scripts get all they need, and the hook by which patterns
#: and fills show themselves in a notebook. They import what stands above when asked for it.
ENTRY_POINTS = {
    "patterndb": {"ingest", "query", "patterndb_sketch", "patterndb_app.client"},
    "patterndb.notebook": {"query", "viewer"},
    "patterndb.verbs": {"ingest", "query", "patterndb_sketch", "viewer"},
}

#: They look upwards, each for the reason that docs/architecture.md gives.
FACES = ("patterndb", "patterndb.__main__", "patterndb.notebook", "patterndb.verbs")

#: What deals with files, processes or people. All else but the viewer knows arrays only:
#: topology, codes, collapsing, enumerating, solving, fitting and meshing.
WORLDLY_MODULES = ("patterndb_app.cli", "patterndb.store", "ingest.formats")
WORLDLY_MODULES += ("patterndb.notebook", "patterndb.verbs")
WORLDLY_MODULES += ("patterndb_sketch.retopo.arguments",)  # quotes values as JSON
WORLDLY_MODULES += ("patterndb.__main__", "patterndb.errors", "patterndb.system.files")
WORLDLY_MODULES += ("patterndb.store.starter", "ingest.pipeline")
WORLDLY_MODULES += ("ingest.cluster",)  # processes and a network
WORLDLY_MODULES += ("patterndb.system.caches", "query.boundaryfile", "patterndb.system.documents")
WORLDLY_MODULES += ("patterndb.system.knownfiles",)
WORLDLY_MODULES += ("patterndb.system.extras", "query.batchline")  # how it is installed; JSON lines
WORLDLY_MODULES += (
    "patterndb_sketch.surfacing.networkfile",
    "patterndb_sketch.features.session",
)
WORLDLY_MODULES += (
    "patterndb_sketch.features.files.shapearrays",
    "patterndb_sketch.features.files.strokesjson",
    "patterndb_sketch.features.files.curvefiles",
)
WORLDLY_MODULES += (
    "patterndb_sketch.features.files.networkjson",
    "patterndb_sketch.features.files.templatejson",
    "query.holes.models",
)
WORLDLY_MODULES += (
    "patterndb_sketch.sessions",
    "patterndb_sketch.recovery",
    "patterndb_sketch.retopo.files",
    "patterndb_sketch.retopo.script",
)

WORLDLY_MODULES += ("patterndb.system.mappedarrays",)

#: What the others do not import, and functions they do not call.
WORLDLY = {"sqlite3", "pathlib", "io", "shutil", "tempfile", "subprocess", "json"}
WORLDLY |= {"click", "pyvista", "matplotlib"}
WORLDLY_CALLS = {"open", "print", "input", "echo", "connect", "read_text", "write_text"}

#: Slow to import; only what needs one may.
DRAWING = {"pyvista", "vtkmodules", "matplotlib"}


@cache
def modules() -> dict[str, Path]:
    """All modules of the packages, by their dotted names."""
    found: dict[str, Path] = {}
    for package in PACKAGES:
        for path in sorted((CHECKOUT / package).rglob("*.py")):
            parts = path.relative_to(CHECKOUT).with_suffix("").parts
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


@dataclass(slots=True)
class ModuleScan:
    """The facts about a module that the tests ask for. Its tree, which is large, is not kept.

    imports: dotted names of all that it imports, wherever the import stands; ``from a import b``
    counts as a, and as a.b too if that is a module. nearest: of these the modules of the project,
    a.b alone if that is one; of an entry point only what it imports at its head when it runs.
    calls: names of the functions that it calls. classes: names of its classes.
    """

    docstring: str | None
    imports: set[str] = field(default_factory=set)
    nearest: set[str] = field(default_factory=set)
    calls: set[str] = field(default_factory=set)
    classes: list[str] = field(default_factory=list)
    creates_tables: bool = False


@cache
def scan(module: str) -> ModuleScan:
    """Parse a module, and return what the tests ask about it."""
    tree = ast.parse(modules()[module].read_text(encoding="utf-8"))
    found = ModuleScan(ast.get_docstring(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.imports |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively; write the whole name"
            assert node.module is not None
            found.imports.add(node.module)
            within = {f"{node.module}.{alias.name}" for alias in node.names}
            found.imports |= within & modules().keys()
        elif isinstance(node, ast.Call):
            found.calls.add(_called(node))
            if _called(node) in ("import_module", "__import__"):
                found.imports |= {str(a.value) for a in node.args if isinstance(a, ast.Constant)}
        elif isinstance(node, ast.ClassDef):
            found.classes.append(node.name)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.creates_tables |= "CREATE TABLE" in node.value.upper()
        if module not in FACES:
            found.nearest |= _list_nearest(node)
    if module in FACES:
        for node in _walk_head(tree):
            found.nearest |= _list_nearest(node)
    found.nearest &= modules().keys() - {module}
    return found


def _list_nearest(node: ast.AST) -> set[str]:
    """Return the names that a statement imports: modules where these are, else what has them."""
    if isinstance(node, ast.Import):
        return {alias.name for alias in node.names}
    if isinstance(node, ast.ImportFrom):
        names = {f"{node.module}.{alias.name}" for alias in node.names}
        return {name if name in modules() else str(node.module) for name in names}
    return set()


def imports(module: str) -> set[str]:
    """Return the dotted names of all that a module imports."""
    return scan(module).imports


def _called(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def part(module: str) -> str:
    """The package of a module; those of patterndb_app are counted each by itself."""
    if module in ("patterndb.__main__", "patterndb_app", "patterndb_app.__main__"):
        return "patterndb_app.cli"
    if module.startswith("patterndb_app."):
        return ".".join(module.split(".")[:2])
    return module.partition(".")[0]


def _imported_parts(module: str) -> set[str]:
    """The packages that a module imports, its own left out, and what an entry point may."""
    ours = {name for name in imports(module) if name.partition(".")[0] in PACKAGES}
    return {part(name) for name in ours} - {part(module)} - ENTRY_POINTS.get(module, set())


def test_the_scan_sees_imports_in_functions() -> None:
    assert "ingest" in imports("patterndb_app.cli.ingest")
    assert "viewer" in imports("patterndb_app.cli.pictures")
    assert len(modules()) > 60


@pytest.mark.parametrize("package", ALLOWED)
def test_arrows_run_one_way(package: str) -> None:
    wrong = {
        module: _imported_parts(module) - ALLOWED[package]
        for module in modules()
        if part(module) == package and _imported_parts(module) - ALLOWED[package]
    }
    assert not wrong


def test_nothing_imports_the_viewer_but_what_people_start() -> None:
    users = {part(module) for module in modules() if "viewer" in _imported_parts(module)}
    assert users == {"patterndb_app.cli"}


def test_what_serves_and_asks_is_used_in_the_service_and_the_client_alone() -> None:
    serving = {"fastapi", "starlette", "uvicorn"}
    users = {part(module) for module in modules() if _libraries(module) & serving}
    assert users == {"patterndb_app.service"}
    users = {part(module) for module in modules() if "httpx" in _libraries(module)}
    assert users == {"patterndb_app.client"}


def test_nothing_imports_the_command_line() -> None:
    assert not [module for module in modules() if "patterndb_app.cli" in _imported_parts(module)]


def test_sqlite_is_used_in_the_store_alone() -> None:
    users = {module for module in modules() if "sqlite3" in _libraries(module)}
    assert users
    assert all(module.startswith("patterndb.store.") for module in users), users


def test_drawing_libraries_are_used_in_the_viewer_and_a_reader_alone() -> None:
    users = {module for module in modules() if _libraries(module) & DRAWING}
    assert users
    readers = {"ingest.formats.vtk"}
    assert {module for module in users if part(module) != "viewer"} <= readers


def test_what_the_benchmarks_compare_with_is_used_in_no_package() -> None:
    assert not [module for module in modules() if _libraries(module) & {"meshlib", "CGAL", "cgal"}]


#: What runs code by reading data, wherever it is imported from.
PICKLING = {"pickle", "_pickle", "cPickle", "cloudpickle", "dill", "shelve", "marshal", "joblib"}
PICKLING |= {"numba.core.serialize", "numba.cloudpickle", "pandas", "yaml"}

#: numpy's readers, which unpickle where they are let.
ARRAY_READERS = {"load", "read_array", "write_array", "open_memmap", "fromfile", "DataSource"}


def _sources() -> list[Path]:
    """All Python of the project that is no test."""
    others = [path for name in ("scripts", "benchmarks", "examples") for path in
              sorted((CHECKOUT / name).rglob("*.py"))]  # fmt: skip
    return [*modules().values(), *others]


def test_nothing_is_unpickled_anywhere() -> None:
    found: list[str] = []
    # Only what has one of the names is parsed: all of it takes 20 seconds.
    readers, picklers = "|".join(sorted(ARRAY_READERS)), "|".join(map(re.escape, sorted(PICKLING)))
    named = re.compile(rf"\.(?:{readers})\b|\b(?:{picklers})\b")
    for path in _sources():
        source = path.read_text(encoding="utf-8")
        if not named.search(source):
            continue
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                names = {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names = {str(node.module), *(f"{node.module}.{a.name}" for a in node.names)}
            else:
                names = set[str]()
                if isinstance(node, ast.Call) and _may_unpickle(node):
                    found.append(f"{path}:{node.lineno}")
            if any(name in PICKLING or name.partition(".")[0] in PICKLING for name in names):
                found.append(f"{path}: {names}")
    assert not found


def _may_unpickle(call: ast.Call) -> bool:
    """Is this numpy reading or writing arrays without saying that none may be a pickle?"""
    if not isinstance(call.func, ast.Attribute) or call.func.attr not in ARRAY_READERS:
        return False
    owner = ast.unparse(call.func.value)
    if owner not in ("np", "numpy", "np.lib.format", "numpy.lib.format", "format"):
        return False
    told = {keyword.arg: ast.unparse(keyword.value) for keyword in call.keywords}
    return call.func.attr != "fromfile" and told.get("allow_pickle") != "False"


def _functional() -> list[str]:
    """The modules that know arrays only; what a package imports for others is not counted."""
    return [
        module
        for module, path in modules().items()
        if part(module) in ("patterndb", "ingest", "query", "patterndb_sketch")
        and path.name != "__init__.py"
        and not any((module + ".").startswith(name + ".") for name in WORLDLY_MODULES)
    ]


def test_the_core_knows_arrays_only() -> None:
    assert len(_functional()) > 100
    worldly = {
        module: (_libraries(module) & WORLDLY) | (scan(module).calls & WORLDLY_CALLS)
        for module in _functional()
    }
    assert not {module: names for module, names in worldly.items() if names}


#: They give what the store takes: Learned, by the store's own name for it.
GIVERS = ("ingest.learning", "ingest.engines", "ingest.clustertasks")


def test_the_core_does_not_know_the_store() -> None:
    assert not [
        module
        for module in _functional()
        if module not in GIVERS and any(n.startswith("patterndb.store") for n in imports(module))
    ]


def _walk_head(node: ast.AST) -> Iterator[ast.AST]:
    """All below a node but what is for types only, and functions' bodies."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        if not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield child
            yield from _walk_head(child)


def test_picklersdo_not_import_in_a_circle() -> None:
    order = TopologicalSorter({module: scan(module).nearest for module in modules()})
    try:
        order.prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(reversed(error.args[1])))


def test_a_class_has_a_name_of_its_own() -> None:
    places: dict[str, list[str]] = {}
    for module in modules():
        for name in scan(module).classes:
            places.setdefault(name, []).append(module)
    assert not {name: where for name, where in places.items() if len(where) > 1}


def _libraries(module: str) -> set[str]:
    return {name.partition(".")[0] for name in imports(module)}


@pytest.mark.parametrize(
    ("statement", "unwanted"),
    [
        (
            "import patterndb",
            {"click", "pyvista", "matplotlib", "ortools", "httpx", "fastapi"},
        ),
        (
            "import patterndb_app.cli",
            {"numpy", "query", "ingest", "viewer", "patterndb_sketch"},
        ),
        (
            "from patterndb_app.cli import cli as c; "
            "[c.get_command(c, v) for v in c.list_commands(c)]",
            {"ingest", "viewer", "pyvista", "ortools"},
        ),
        ("import ingest, ingest.formats", {"pyvista", "matplotlib", "pxr", "trimesh"}),
        ("import query", {"pyvista", "matplotlib", "ortools", "ingest", "viewer", "click"}),
        ("import viewer", {"pyvista", "vtkmodules", "matplotlib", "ortools", "ingest", "click"}),
    ],
)
def test_an_import_is_no_more_than_it_says(statement: str, unwanted: set[str]) -> None:
    script = f"import sys; {statement}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=CHECKOUT
    )
    assert not unwanted & set(done.stdout.split())


def test_every_module_says_what_it_is() -> None:
    assert not [m for m in modules() if not (scan(m).docstring or "").partition("\n")[0].strip()]


def test_every_package_is_a_package() -> None:
    for path in modules().values():
        assert (path.parent / "__init__.py").is_file(), path.parent


def test_the_schema_stands_once() -> None:
    assert (CHECKOUT / "schema.sql").is_file()
    # Packages take it along by a link.
    packaged = CHECKOUT / "patterndb" / "schema.sql"
    assert packaged.readlink() == Path("../schema.sql")
    creating = {module for module in modules() if scan(module).creates_tables}
    # The check of a file's schema knows the tables that SQLite makes for itself.
    others = {"patterndb.store.ddq", "patterndb.store.connection"}
    assert creating <= others


#: Rooms of the architecture page; a module belongs to the longest that its name begins with.
ROOMS = (
    "patterndb.errors",
    "patterndb.system",
    "patterndb.core",
    "patterndb.geometry",
    "patterndb.store",
    "ingest",
    "query",
    "patterndb_sketch",
    "viewer",
    "patterndb_app",
)


def find_room(module: str) -> str | None:
    """The room of a module; None for the face."""
    found = [room for room in ROOMS if (module + ".").startswith(room + ".")]
    return max(found, key=len, default=None)


def read_arrows() -> dict[str, set[str]]:
    """The table of docs/architecture.md: a room, and the rooms that it imports."""
    page = (CHECKOUT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows: dict[str, set[str]] = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if not line.startswith("| `patterndb") and not line.startswith(
            ("| `ingest", "| `query", "| `viewer")
        ):
            continue
        room = cells[0].strip("`")
        every = cells[2] == "every room"
        rows[room] = set(ROOMS) - {room} if every else set(re.findall(r"`([\w.]+)`", cells[2]))
    return rows


def test_the_page_has_the_arrows_that_there_are() -> None:
    arrows = read_arrows()
    assert set(arrows) == set(ROOMS)
    wrong: set[tuple[str, str]] = set()
    for module in modules():
        room = find_room(module)
        if room is None:
            assert module in FACES, f"{module} is in no room"
            continue
        for name in imports(module):
            other = find_room(name) if name in modules() else None
            if other is not None and other != room and other not in arrows[room]:
                wrong.add((module, name))
    assert not wrong


def test_picklersthat_the_page_names_are_there() -> None:
    page = (CHECKOUT / "docs" / "architecture.md").read_text(encoding="utf-8")
    packages = "|".join(PACKAGES)
    for name in set(re.findall(rf"`((?:{packages})\.[\w.]+)`", page)):
        module = name
        while module not in modules():
            module, _, _ = module.rpartition(".")
            assert module, f"docs/architecture.md names {name}"
        assert name == module or name.count(".") - module.count(".") == 1, name
