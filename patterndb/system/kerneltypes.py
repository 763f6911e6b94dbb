"""Types of kernels as JSON: of arguments in the list of kernels, of results with compiled ones."""

# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from importlib import import_module
from typing import Any

#: Packages of the project, beneath which kernels and the named tuples that they take stand.
OWN_PACKAGES = {"patterndb", "ingest", "query", "patterndb_sketch", "viewer", "patterndb_app"}


def spell_type(given: Any) -> Any:
    """A numba type as JSON: "int64"; "int32 2C" for an array of two axes in C order, "int32 2C
    readonly"; ["tuple", ...], or ["module:Class", ...] for a named one, with the parts' types;
    ["literal", 0] for a constant, ["optional", "int64"] where there may be None.

    Raises ValueError for one of another kind.
    """
    from numba.core import types

    if isinstance(given, types.Array):
        if given.aligned and isinstance(given.dtype, types.Number | types.Boolean):
            how = "" if given.mutable else " readonly"
            return f"{given.dtype} {given.ndim}{given.layout}{how}"
    elif isinstance(given, types.BaseNamedTuple):
        made: Any = given
        where = f"{made.instance_class.__module__}:{made.instance_class.__qualname__}"
        if _is_own(where):
            return [where, *map(spell_type, made.types)]
    elif isinstance(given, types.BaseTuple):
        each: Any = given
        return ["tuple", *map(spell_type, each)]
    elif isinstance(given, types.Literal):
        constant: Any = given
        if isinstance(constant.literal_value, int | str):
            return ["literal", constant.literal_value]
    elif isinstance(given, types.Optional):
        return ["optional", spell_type(given.type)]
    elif isinstance(given, types.Number | types.Boolean | types.NoneType):
        return str(given)
    raise ValueError(f"a kernel is called with {given!r}, which the list has no words for")


def make_type(spelled: Any) -> Any:
    """The numba type that :func:`spell_type` spelled.

    Raises ImportError or AttributeError where a named tuple's class is no more, and ValueError or
    TypeError for what spells no type.
    """
    from numba.core import types

    if isinstance(spelled, str):
        dtype, *array = spelled.split()
        made = getattr(types, "boolean" if dtype == "bool" else dtype, None)
        if not isinstance(made, types.Number | types.Boolean | types.NoneType):
            raise ValueError(f"{dtype!r} is no type of numbers")
        if not array:
            return made
        return types.Array(made, int(array[0][:-1]), array[0][-1], readonly=len(array) > 1)
    kind, *parts = spelled
    if kind == "literal":
        if len(parts) != 1 or not isinstance(parts[0], int | str):
            raise ValueError(f"{parts!r} is no constant of a type")
        return types.literal(parts[0])
    inner = [make_type(part) for part in parts]
    if kind == "optional" and len(inner) == 1:
        return types.Optional(inner[0])
    if kind == "tuple":
        return types.Tuple(inner)
    # Only these are imported, whatever is spelled: a module is run by that.
    if not _is_own(kind):
        raise ValueError(f"{kind!r} is no class of the project")
    module, _, name = kind.partition(":")
    found = getattr(import_module(module), name)
    if not (isinstance(found, type) and issubclass(found, tuple)):
        raise ValueError(f"{kind!r} is no named tuple")
    uniform = len(set(inner)) == 1
    return (
        types.NamedUniTuple(inner[0], len(inner), found)
        if uniform
        else types.NamedTuple(inner, found)
    )


def _is_own(where: str) -> bool:
    """Does a class, "module:Class", stand in a module of the project?"""
    return where.partition(":")[0].partition(".")[0] in OWN_PACKAGES
