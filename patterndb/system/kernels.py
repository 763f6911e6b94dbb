"""Compile kernels once: :func:`kernel` is numba's ``njit`` with a cache that goes by content.

numba's own cache belongs to a file: it is lost when a source is touched or stands elsewhere, and
it is not when a function that a kernel calls has changed. Here the key of a compiled kernel is what
it was made of: its code and that of all kernels it calls, the constants they read, the types of its
arguments, the compiler and the processor. A clone, a second environment or a renamed module finds
what another has compiled.

Looked for first in the pack that comes with the package (:mod:`patterndb.system.kernelpack`), then
in the user's folder: ``kernels`` in the user's cache folder; ``PATTERNDB_KERNELS`` names another.
Where none can be written, kernels are compiled by every process that uses them.
"""

# numba has few types, and the hooks of its cache are private: their names are in one place, here.
# pyright: reportMissingTypeStubs=false, reportPrivateUsage=false, reportUnknownMemberType=false
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from functools import cache, partial
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar, overload

import llvmlite.binding
import numba
import numpy as np
from numba.core import config, event
from numba.core.caching import _Cache as CacheProtocol
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys
from numba.extending import typeof_impl

import patterndb._native as _native
from patterndb.system.caches import kernel_folder
from patterndb.system.compiledform import format_compiled, load_compiled
from patterndb.system.compiling import COMPILED
from patterndb.system.kernelpack import KernelPack, find_pack
from patterndb.system.kerneltypes import OWN_PACKAGES

#: Changed when files of an earlier version can no longer be read.
FORMAT = 2

_DIGEST = 32

#: Told of every call that the compiler finds in a kernel, with what is called and its types.
CALL_NOTES: list[Callable[[Any, tuple[Any, ...]], None]] = []

Function = TypeVar("Function", bound=Callable[..., Any])


@overload
def kernel(function: Function) -> Function: ...


@overload
def kernel(**options: Any) -> Callable[[Function], Function]: ...


def kernel(function: Any = None, **options: Any) -> Any:
    """Compile a function by numba on its first call, without the interpreter's lock, and keep it.

    options: those of ``numba.njit`` (inline, fastmath); the cache is set here. borrowing: the
    function makes no arrays and returns none, so that those it is given need not be counted
    while it runs. Counting is by atomic operations, one for every array of a tuple that is
    looked at: where a loop does so, it is half of the time.

    Example: ``@kernel`` above ``def area(corners: Points) -> float: ...``
    """
    if function is None:
        return partial(kernel, **options)
    if options.pop("borrowing", False):
        options["_nrt"] = False
    made: Any = numba.njit(nogil=True, **options)(function)
    made._cache = ContentCache(made, options)
    made.get_call_template = partial(_get_plain_template, made, made.get_call_template)
    native = find_native(function)
    return made if native is None else NativeKernel(made, native)


def find_native(function: FunctionType) -> Callable[..., Any] | None:
    """The function of the compiled extension that has a kernel's place and name; None without."""
    place: Any = _native
    name = function.__module__.removeprefix("patterndb.").removeprefix("patterndb_sketch.")
    for part in name.split("."):
        place = getattr(place, part, None)
    return getattr(place, function.__name__.lstrip("_"), None)


class NativeKernel:
    """A kernel of the compiled extension, which kernels that numba compiles can call as well.

    They call what numba makes of the same function: compiled code cannot call the extension.
    """

    def __init__(self, compiled: Any, native: Callable[..., Any]) -> None:
        self.compiled = compiled
        self.native = native
        self.py_func: FunctionType = compiled.py_func
        self.__doc__ = compiled.__doc__
        self.__name__: str = compiled.__name__
        self.__module__ = compiled.__module__

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self.native(*arguments, **named)


@typeof_impl.register(NativeKernel)  # pyright: ignore
def _type_native(value: NativeKernel, context: Any) -> Any:
    return numba.types.Dispatcher(value.compiled)


def _get_plain_template(made: Any, get_template: Any, args: Any, kws: Any) -> Any:
    """What numba asks of a kernel that another calls, constants taken for numbers of their kind:
    it would compile the kernel once more for each of them."""
    _, folded = made.fold_argument_types(args, kws)
    types = tuple(map(numba.types.unliteral, folded))
    for note in CALL_NOTES:
        note(made, types)
    return get_template(types, {})


class ContentCache(CacheProtocol):
    """The compiled versions of one kernel, a file each, as numba's dispatcher asks for them."""

    def __init__(self, dispatcher: Any, options: dict[str, Any]) -> None:
        self._function: FunctionType = dispatcher.py_func
        self._target: Any = dispatcher.targetctx
        self._options = repr(sorted((name, _plain(value)) for name, value in options.items()))
        self._digest: bytes | None = None
        self._enabled = True

    @property
    def cache_path(self) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]
        """The folder of the files; empty where there is none."""
        return str(kernel_folder() or "")

    def enable(self) -> None:
        """Read and keep compiled versions."""
        self._enabled = True

    def disable(self) -> None:
        """Neither read nor keep compiled versions."""
        self._enabled = False

    def flush(self) -> None:
        """Do nothing: a file whose key no kernel has is never read."""

    def digest(self) -> bytes:
        """(32,) bytes that tell the kernel, with all that it calls, from any other."""
        if self._digest is None:
            self._digest = digest_function(self._function, self._options, ())
        return self._digest

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the version for argument types; None where there is none that can be used."""
        # All that loaded code needs; what compiling needs (refresh) takes half a second to import.
        rtsys.initialize(target_context)
        if not self._enabled:
            return None
        codegen = target_context.codegen()
        content = self._find(sig, codegen)
        # Within another's compiling nothing is compiled ahead: that one holds all of it up.
        if content is None and not COMPILED.is_compiling() and COMPILED.compile_ahead():
            content = self._find(sig, codegen)
        if content is None or not isinstance(content, bytes):
            return content
        try:
            made = load_compiled(content, sig, self._function.__module__, target_context)
        except ValueError:
            return None  # it is compiled anew, and replaced
        _loaded[self._key(sig, codegen)] = made
        return made

    def _find(self, sig: Any, codegen: Any) -> Any:
        """A version that this process has, or the bytes of one that is kept; None without."""
        key = self._key(sig, codegen)
        if key in _loaded:
            return _loaded[key]
        pack, _ = find_shipped()
        content = None if pack is None else pack.read(self.pack_key(sig))
        return _read(key) if content is None else content

    def is_kept(self, sig: Any) -> bool:
        """Is there a version for argument types, in the pack or the user's folder?"""
        codegen = self._target.codegen()
        pack, _ = find_shipped()
        if pack is not None and self.pack_key(sig) in pack.entries:
            return True
        return _has(self._key(sig, codegen))

    def read_kept(self, sig: Any) -> bytes | None:
        """The bytes that the user's folder keeps of the version for argument types."""
        return _read(self._key(sig, self._target.codegen()))

    def pack_key(self, sig: Any) -> str:
        """What a pack, which is for one compiler and processor as a whole, calls the version."""
        return hashlib.sha256(self.digest() + _spell_types(sig)).hexdigest()[:40]

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Keep a version that has just been compiled."""
        if not self._enabled or any(not lifted.can_cache for lifted in data.lifted):
            return
        if data.library.has_dynamic_globals:  # addresses of this process
            return
        key = self._key(sig, data.codegen)
        # Without what the compiler noted of its work: a kernel that shares it notes its own.
        _loaded[key] = data._replace(metadata=None)
        try:
            content = format_compiled(data)
        except ValueError:
            return
        _write(key, content)

    def _key(self, sig: Any, codegen: Any) -> str:
        made_for = f"\n{codegen.magic_tuple()!r}\n{get_stamp()}".encode()
        return hashlib.sha256(self.digest() + _spell_types(sig) + made_for).hexdigest()[:40]


#: Versions of this process by key. Two kernels of the same content share one: their symbols have
#: the same names, which the linker takes once.
_loaded: dict[str, Any] = {}


def find_shipped() -> tuple[KernelPack | None, str]:
    """The pack that came along and that this process can use, or None and the reason."""
    return find_pack(get_stamp(), llvmlite.binding.get_process_triple())


def digest_function(function: FunctionType, options: str, within: tuple[Any, ...]) -> bytes:
    """Hash a function's code, the values of the globals it reads, and the functions it calls.

    within: the functions around it in the chain of calls; one that calls itself is known by
    its place among them. Names of functions and modules do not count, nor do docstrings.
    """
    if function in within:
        return b"recursion %d" % within.index(function)
    within = (*within, function)
    parts = [options.encode()]
    _add_code(parts, function.__code__, function, within)
    for value in (*(function.__defaults__ or ()), *_cells(function)):
        parts.append(_digest_value(value, (), within))
    return hashlib.sha256(b"\0".join(parts)).digest()


def _cells(function: FunctionType) -> list[Any]:
    return [cell.cell_contents for cell in function.__closure__ or ()]


def _add_code(
    parts: list[bytes], code: CodeType, function: FunctionType, within: tuple[Any, ...]
) -> None:
    parts.append(code.co_code)
    parts.append(repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags)).encode())
    for i, constant in enumerate(code.co_consts):
        if isinstance(constant, CodeType):
            _add_code(parts, constant, function, within)
        elif i == 0 and constant == function.__doc__ and isinstance(constant, str):
            parts.append(b"docstring")
        else:
            parts.append(_digest_value(constant, (), within))
    for name in code.co_names:
        if name in function.__globals__:
            parts.append(_digest_value(function.__globals__[name], code.co_names, within))
        else:
            parts.append(name.encode())
    parts.append(repr(code.co_varnames[: code.co_argcount]).encode())


def _digest_value(value: Any, names: tuple[str, ...], within: tuple[Any, ...]) -> bytes:
    """Hash what a global stands for; of an own module, the attributes with one of the names."""
    if isinstance(value, NativeKernel):
        value = value.compiled
    if isinstance(value, Dispatcher):
        held = getattr(value, "_cache", None)
        options = held._options if isinstance(held, ContentCache) else repr(value.targetoptions)
        return digest_function(value.py_func, options, within)
    if isinstance(value, ModuleType):
        if value.__name__.partition(".")[0] not in OWN_PACKAGES:
            return value.__name__.encode()
        held = [n for n in names if hasattr(value, n)]
        return b"".join(_digest_value(getattr(value, n), names, within) for n in held)
    if isinstance(value, np.ndarray):
        return repr((value.dtype, value.shape)).encode() + np.ascontiguousarray(value).tobytes()
    if isinstance(value, tuple | list):
        inner = b",".join(_digest_value(item, names, within) for item in value)
        return type(value).__name__.encode() + b"(" + inner + b")"
    if isinstance(value, frozenset):
        inner = b",".join(sorted(_digest_value(item, names, within) for item in value))
        return b"frozenset(" + inner + b")"
    if isinstance(value, bool | int | float | complex | str | bytes | type(None) | np.generic):
        return f"{type(value).__name__} {value!r}".encode()
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
    if name is not None:
        return f"{getattr(value, '__module__', '')}.{name}".encode()
    return f"{type(value).__name__} {value!r}".encode()


def _spell_types(sig: Any) -> bytes:
    return (repr(sig) + "".join(f"\n{name}" for name in _name_tuples(sig))).encode()


def _name_tuples(types: Any) -> Iterator[str]:
    """Name the named tuples among argument types, with the modules that they are loaded from.

    A kept version names them so: where such a class has moved it could not be read.
    """
    for one in types:
        if isinstance(one, numba.types.BaseNamedTuple):
            made: Any = one
            yield f"{made.instance_class.__module__}.{made.instance_class.__qualname__}"
        if isinstance(one, numba.types.BaseTuple):
            yield from _name_tuples(one)


def _plain(value: Any) -> Any:
    return sorted(value) if isinstance(value, set | frozenset) else value


@cache
def get_stamp() -> str:
    """What compiled code depends on beside its source, its types and the processor."""
    compiler = (sys.implementation.cache_tag, numba.__version__, llvmlite.__version__)
    asked: Any = config
    settings = (asked.OPT, asked.BOUNDSCHECK, asked.DEBUGINFO_DEFAULT)
    return repr((FORMAT, np.__version__.split(".")[0], compiler, settings))


class CompileListener(event.Listener):
    """Notes what numba compiles; numba's own functions count as part of the kernel's time."""

    def on_start(self, event: Any) -> None:
        """Called as something begins to be compiled."""
        COMPILED.begin()

    def on_end(self, event: Any) -> None:
        """Called as it has been compiled, or could not be."""
        held = getattr(event.data["dispatcher"], "_cache", None)
        COMPILED.end(int(isinstance(held, ContentCache)))


event.register("numba:compile", CompileListener())


def _read(key: str) -> bytes | None:
    """Read what :func:`_write` kept; None for a file that is not there or not whole."""
    folder = kernel_folder()
    if folder is None:
        return None
    try:
        content = (folder / key[:2] / key[2:]).read_bytes()
    except OSError:
        return None
    digest, rest = content[:_DIGEST], content[_DIGEST:]
    return rest if hashlib.sha256(rest).digest() == digest else None


def _has(key: str) -> bool:
    folder = kernel_folder()
    return folder is not None and (folder / key[:2] / key[2:]).is_file()


def _write(key: str, content: bytes) -> None:
    folder = kernel_folder()
    if folder is None:
        return
    path = folder / key[:2] / key[2:]
    half = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        # No fsync: what a crash of the machine leaves half written is known by its digest.
        half.write_bytes(hashlib.sha256(content).digest() + content)
        half.replace(path)
    except OSError:
        return  # a cache may fail: the next process compiles again
