"""The verb that compiles kernels ahead: warmup."""

from __future__ import annotations

import time
from collections.abc import Sequence

import click

from patterndb.errors import PatternDBError
from patterndb_app.cli.compiletalk import CompileTalk
from patterndb_app.cli.failure import EXIT_BAD_INPUT
from patterndb_app.cli.options import as_json
from patterndb_app.cli.text import plural, say, write, write_json


@click.command()
@click.argument("verbs", metavar="[VERB]...", nargs=-1)
@as_json
def warmup(verbs: Sequence[str], as_json: bool) -> int:
    """Compile the kernels that verbs need, all if none is named, so that no later run waits.

    Wheels bring compiled kernels, and there is nothing to do. Elsewhere, and with another release
    of numba, they are compiled once, in as many processes as there are processors, and kept in
    the user's cache folder.

    \b
    patterndb warmup
    patterndb warmup query fill
    """
    from patterndb.system.caches import kernel_folder
    from patterndb.system.kernellist import read_list
    from patterndb.system.kernels import find_shipped
    from patterndb.system.warming import compile_listed, count_processes, find_missing

    known = sorted({verb for kernel in read_list() for verb in kernel.verbs})
    for verb in verbs:
        if verb not in known:
            raise click.UsageError(f"{verb} is no verb with kernels; there are {', '.join(known)}")
    listed = read_list(verbs or None)
    missing = find_missing(listed)
    folder = kernel_folder()
    pack, reason = find_shipped()
    if missing and folder is None:
        raise PatternDBError("there is no folder to keep kernels in: set PATTERNDB_CACHE")
    began = time.perf_counter()
    failed: list[str] = []
    if missing:
        if pack is None:
            say(f"kernels must be compiled: {reason}")
        talk = CompileTalk("compiling kernels")
        talk.update(0, len(missing), 0.0)
        with talk.shown():
            done = compile_listed(missing, processes=count_processes(missing), progress=talk.update)
        failed = [f"{kernel.module}.{kernel.name}: {error}" for kernel, error in done.failed]
    seconds = time.perf_counter() - began
    document = {
        "listed": len(listed),
        "compiled": len(missing) - len(failed),
        "failed": failed,
        "shipped": pack is not None,
        "reason": reason,
        "folder": str(folder or ""),
        "seconds": round(seconds, 2),
    }
    if as_json:
        write_json(document)
    elif missing:
        write(
            f"{plural(len(missing) - len(failed), 'kernel')} compiled in {seconds:.0f} s: {folder}"
        )
    else:
        where = "came with this installation" if pack is not None else f"are in {folder}"
        write(f"nothing to compile: all {plural(len(listed), 'kernel')} {where}")
    for text in failed:
        say(text)
    return EXIT_BAD_INPUT if failed else 0
