"""The form in which compiled kernels are kept: machine code and its description, of which nothing
is run by being read.

numba keeps what it compiled as a pickle, which runs what it names. Here it is bytes: how long the
parts are, a description in JSON, the machine code, and the intermediate code that kernels compiled
later take parts of. Types are spelled as in the list of kernels
(:func:`patterndb.system.kerneltypes.spell_type`), constants are types of numbers; whatever else a
kernel would need is not kept. The types of the arguments are those that a kernel is asked for.

The machine code itself is run when the kernel is called, and may then unpickle what it holds:
numba stores so the errors that a kernel raises. Who reads it sees to where it comes from.
"""

# What numba gives and takes is private, and without types.
# pyright: reportMissingTypeStubs=false, reportPrivateUsage=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numba.core.compiler import CompileResult
from numba.core.environment import _rebuild_env
from numba.core.funcdesc import PythonFunctionDescriptor
from numba.core.typing.templates import signature

from patterndb.system.kerneltypes import make_type, spell_type

#: Bytes of the description and of the machine code; the rest is intermediate code.
_SIZES = struct.Struct("<QQ")

#: What the description has, in this order, with the types of JSON.
_FIELDS: dict[str, Any] = {
    "library": str,  # its name, which the engine knows it by
    "name": str,  # of the function
    "unique": str,  # the same with a number, for messages
    "symbol": str,  # the name that the machine code has
    "tags": list,  # that the name ends with
    "number": int,
    "arguments": list,  # their names
    "returned": (str, list),  # its type
    "environment": list,  # name and constants
    "environments": list,  # of those that it calls
}

#: Types of numbers that are constants of a kernel's environment.
_DTYPES = frozenset((
    "bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32",
    "float64", "complex64", "complex128",
))  # fmt: skip


def format_compiled(made: CompileResult) -> bytes:
    """The bytes of what was compiled. Raises ValueError where it holds what they cannot tell."""
    library, described, environment, _, objectmode, lifted, _, again, others = made._reduce()
    if objectmode or lifted or again or described.kws or described.inline or described.noalias:
        raise ValueError(f"{described.qualname} is compiled in a way that is not kept")
    held = (
        library[0],
        described.qualname,
        described.unique_name,
        described.mangled_name,
        list(described.abi_tags),
        described.uid,
        list(described.args),
        spell_type(described.restype),
        _spell_environment(environment),
        [_spell_environment(other) for other in others],
    )
    code, shared = library[2]
    head = json.dumps(held).encode()
    return b"".join((_SIZES.pack(len(head), len(code)), head, code, shared))


def load_compiled(content: bytes, arguments: Any, module: str, target: Any) -> CompileResult:
    """Make a kernel of its bytes ready to be called.

    arguments: numba's types. module: name of one that it is said to stand in. target: what numba
    compiles for. Raises ValueError for bytes that are none.
    """
    try:
        size, code_size = _SIZES.unpack_from(content)
        body = memoryview(content)[_SIZES.size :]
        if len(body) < size + code_size:
            raise ValueError("it ends too early")
        held = json.loads(bytes(body[:size]))
        _check_fields(held)
        library, name, unique, symbol, tags, number, names, spelled, own, others = held
        if len(names) != len(arguments):
            raise ValueError("the number of arguments is another")
        returned = make_type(spelled)
        environment = _make_environment(own)
        referred = [_make_environment(other) for other in others]
    except (
        struct.error, ValueError, TypeError, ImportError, AttributeError, RecursionError,
    ) as error:  # fmt: skip
        raise ValueError(f"no compiled kernel: {error}") from None

    def mangle(*_: Any, **__: Any) -> str:
        return symbol

    described = PythonFunctionDescriptor(
        native=True, modname=module, qualname=name, unique_name=unique, doc="", typemap=None,
        restype=returned, calltypes=None, args=tuple(names), kws=(), argtypes=tuple(arguments),
        mangler=mangle, env_name=environment.env_name, abi_tags=tuple(tags),
        uid=number,
    )  # fmt: skip
    code = bytes(body[size : size + code_size]), bytes(body[size + code_size :])
    return CompileResult._rebuild(
        target, (library, "object", code), described, environment,
        signature(returned, *arguments), False, (), "", [], tuple(referred),
    )  # fmt: skip


def _check_fields(held: Any) -> None:
    if not isinstance(held, list) or len(held) != len(_FIELDS):
        raise ValueError("its description is another")
    for (field, kind), value in zip(_FIELDS.items(), held, strict=True):
        if not isinstance(value, kind):
            raise ValueError(f"its {field} is {type(value).__name__}")
    if not all(isinstance(word, str) for word in (*held[4], *held[6])):
        raise ValueError("its tags or arguments are no names")


def _spell_environment(environment: Any) -> list[Any]:
    names: list[str] = []
    for constant in environment.consts:
        if not isinstance(constant, np.dtype) or constant.name not in _DTYPES:
            raise ValueError(f"the constant {constant!r} of {environment.env_name} is not kept")
        names.append(constant.name)
    return [environment.env_name, names]


def _make_environment(spelled: Any) -> Any:
    """An environment, whose globals are those of this module: compiled code reads none of them."""
    name, names = spelled
    if not isinstance(name, str) or not _DTYPES.issuperset(names):
        raise ValueError("an environment has constants that are no types of numbers")
    return _rebuild_env(__name__, [np.dtype(one) for one in names], name)
