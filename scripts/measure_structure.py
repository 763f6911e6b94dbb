"""Measure the structure and the language of a checkout.

    python scripts/measure_structure.py [FOLDER ...]     by default this checkout

Counts the modules of the packages, without tests, benchmarks, scripts and examples, and the
compiled core. A module is small below SMALL lines. A circle is a set of modules that import each
other; lazy imports count, imports for types alone do not. A concept's classes are those of
CONCEPTS that the checkout defines.
"""

from __future__ import annotations

import ast
import re
import statistics
import sys
from collections import Counter
from pathlib import Path

SMALL = 60

#: Arguments from which on a function has many.
MANY_ARGUMENTS = 10

#: Classes that hold one concept, by the names that they have or had.
CONCEPTS = {
    "surface mesh": (
        "TriangleMesh Surface Model Ground GroundTopology DrawingGround HoleGround Canvas FieldMesh"
        " MeshTopology Adjacency HoleProjector SurfaceTopology TangentFrames"
    ),
    "point on a surface": (
        "Feet ModelFeet GroundPoints ProjectedPoints Pick SurfacePoints LineHits Projection"
    ),
    "curve network": (
        "CurveNetwork DrawnNetwork FeatureNetwork Network OpenNetwork ChainedNetwork OrderedNetwork"
        " NetworkBuilder LayoutBuilder"
    ),
    "stroke": (
        "Stroke GroundStroke BrushStroke StrokePart SplitStroke InkedStroke LooseStroke"
        " SurfaceStroke FeatureStroke DrawnStroke StrokeMark PointerStroke StrokePointer"
        " StrandConstraint"
    ),
    "reader of JSON documents": "Entries",
}

#: Words and shapes of sentences that the conventions do without.
UNWANTED = {
    "tell/told": r"\b(?:tells?|told)\b",
    "is/are no": r"\b(?:is|are) no\b",
    "what is/are": r"\bwhat (?:is|are)\b",
    "beside": r"\bbeside\b",
    "anew": r"\banew\b",
    "shall": r"\bshall\b",
    "but for": r"\bbut for\b",
}

#: Top-level folders that are no packages of the product.
OTHER = {"tests", "benchmarks", "scripts", "examples", "build", "dist", "demo", "docs"}

#: Entry points may import what stands above them.
FACES = {"patterndb", "patterndb.__main__", "patterndb.notebook", "patterndb.verbs"}

#: Packages from the bottom; a module imports none above its own, nor one beside it. Names that
#: packages had before are there, so that earlier checkouts can be measured.
LEVELS = {
    "patterndb": 0,
    "ingest": 1,
    "query": 1,
    "sketch": 2,
    "patterndb_sketch": 2,
    "viewer": 3,
    "patterndb_app": 4,
    "patterndb.cli": 4,
}


def main() -> None:
    for folder in sys.argv[1:] or [str(Path(__file__).parents[1])]:
        print(f"{folder}:")
        for name, value in measure_structure(Path(folder)).items():
            print(f"  {name}: {value:,}" if isinstance(value, int) else f"  {name}: {value}")


def measure_structure(root: Path) -> dict[str, int | float]:
    """The figures of one checkout."""
    modules = find_modules(root)
    trees = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in modules.items()}
    lines = [len(path.read_text(encoding="utf-8").splitlines()) for path in modules.values()]
    classes = Counter(
        node.name
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    )
    graph = {name: find_imports(name, tree, modules) for name, tree in trees.items()}
    importers = Counter(other for others in graph.values() for other in others)
    public = {name: names for name, tree in trees.items() if (names := list_public_names(tree))}
    arrows = sum(
        is_against(name, other) for name in graph if name not in FACES for other in graph[name]
    )
    for name in FACES & graph.keys():
        graph[name] = set()
    return {
        "modules": len(modules),
        "lines": sum(lines),
        "median lines": statistics.median(lines),
        "longest module": max(lines),
        f"modules below {SMALL} lines": sum(count < SMALL for count in lines),
        "of these not __init__": sum(
            count < SMALL and path.name != "__init__.py"
            for count, path in zip(lines, modules.values(), strict=True)
        ),
        "class names used twice": sum(count > 1 for count in classes.values()),
        "arrows against the layers": arrows,
        "circles of imports": len(find_circles(graph)),
        "modules with one importer": sum(importers[name] == 1 for name in modules),
        f"functions with {MANY_ARGUMENTS} or more arguments": sum(
            count_arguments(node) >= MANY_ARGUMENTS
            for tree in trees.values()
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef)
        ),
        "public names, each counted once": len(set[str]().union(*public.values())),
        "modules with public names": len(public),
        **{
            f"classes of a {concept}": count_classes(concept, classes, trees)
            for concept in CONCEPTS
        },
        **measure_rust(root),
        **{f"words: {name}": count for name, count in count_unwanted(root, modules).items()},
    }


def count_arguments(function: ast.FunctionDef) -> int:
    """Return the number of arguments of a function, without self and cls."""
    names = [
        argument.arg
        for argument in (
            *function.args.posonlyargs,
            *function.args.args,
            *function.args.kwonlyargs,
        )
    ]
    return len([name for name in names if name not in ("self", "cls")])


def list_public_names(tree: ast.Module) -> list[str]:
    """Return the entries of a module's ``__all__``."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return [
                entry.value
                for entry in ast.walk(node.value)
                if isinstance(entry, ast.Constant) and isinstance(entry.value, str)
            ]
    return []


def count_classes(concept: str, classes: Counter[str], trees: dict[str, ast.Module]) -> int:
    """Return how many classes hold a concept: by name, or derived from a class of that name."""
    names = set(CONCEPTS[concept].split())
    derived = sum(
        any(ast.unparse(base) in names for base in node.bases)
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    )
    return sum(classes[name] for name in names) + derived


def count_unwanted(root: Path, modules: dict[str, Path]) -> dict[str, int]:
    """Count the words of UNWANTED in the packages, the compiled core and the documentation."""
    paths = [*modules.values(), *root.glob("rust/*/src/**/*.rs")]
    paths += [*root.glob("*.md"), *root.glob("docs/**/*.md"), root / "schema.sql"]
    text = "\n".join(path.read_text(encoding="utf-8") for path in paths if path.is_file())
    return {name: len(re.findall(shape, text, re.IGNORECASE)) for name, shape in UNWANTED.items()}


def measure_rust(root: Path) -> dict[str, int]:
    """The figures of the compiled core; unit tests stand at the ends of its files."""
    sources = list(root.glob("rust/*/src/**/*.rs"))
    texts = {path: path.read_text(encoding="utf-8") for path in sources}
    plain = {path: text.partition("#[cfg(test)]")[0].count("\n") for path, text in texts.items()}
    binding = sum(lines for path, lines in plain.items() if "python" in path.parts)
    stubs = root.glob("patterndb/_native/**/*.pyi")
    return {
        "modules of Rust": len(sources),
        "lines of Rust": sum(plain.values()) - binding,
        "lines of its binding": binding,
        "lines of its unit tests": sum(t.count("\n") for t in texts.values()) - sum(plain.values()),
        "lines of its stubs": sum(p.read_text(encoding="utf-8").count("\n") for p in stubs),
    }


def find_modules(root: Path) -> dict[str, Path]:
    """The modules of the packages by their dotted names."""
    found: dict[str, Path] = {}
    for folder in sorted(root.iterdir()):
        if folder.name in OTHER or not (folder / "__init__.py").is_file():
            continue
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


def find_imports(name: str, tree: ast.Module, modules: dict[str, Path]) -> set[str]:
    """The modules that a module imports, wherever, but for types alone."""
    found: set[str] = set()
    stack: list[ast.AST] = [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            stack.extend(node.orelse)
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in modules else node.module)
        stack.extend(ast.iter_child_nodes(node))
    return (found & modules.keys()) - {name}


def find_level(name: str) -> tuple[int, str]:
    """How high a module stands, and its package."""
    package = "patterndb.cli" if (name + ".").startswith("patterndb.cli.") else name.split(".")[0]
    return LEVELS[package], package


def is_against(name: str, other: str) -> bool:
    """Does an import run upwards, or sideways to another package?"""
    (own, package), (level, beside) = find_level(name), find_level(other)
    return level > own or (level == own and package != beside)


def find_circles(graph: dict[str, set[str]]) -> list[set[str]]:
    """Sets of modules that reach each other."""
    reached: dict[str, set[str]] = {}
    for name in graph:
        seen: set[str] = set()
        stack = list(graph[name])
        while stack:
            other = stack.pop()
            if other not in seen:
                seen.add(other)
                stack.extend(graph[other])
        reached[name] = seen
    circles: list[set[str]] = []
    for name, seen in reached.items():
        if name in seen and not any(name in circle for circle in circles):
            circles.append({name} | {other for other in seen if name in reached[other]})
    return circles


if __name__ == "__main__":
    main()
