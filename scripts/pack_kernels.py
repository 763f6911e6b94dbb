"""Compile all kernels of the list from empty, and pack them for a wheel.

    python scripts/pack_kernels.py [--cpu generic] [--keep FOLDER] [--note-times]

Writes patterndb/data/kernels/<python>.pack, which `python -m build --wheel` takes along
(hatch_build.py), and beside it, what must be installed for it to be of use. Nothing that was
compiled before is used, unless --keep names a folder, which then holds what was compiled.

Code is made for any processor of the architecture ("generic"), or for one with certain features
(--cpu x86-64-v3): what came along with a wheel is only used where the processor has them all.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import os
import sys
import tempfile
import time
from pathlib import Path

import llvmlite
import llvmlite.binding as llvm
import numba

from patterndb.system.caches import KERNELS_VARIABLE
from patterndb.system.files import replace_file
from patterndb.system.kernellist import (
    LIST_NAME,
    find_kernel,
    format_kernel,
    parse_kernel,
    read_list,
)
from patterndb.system.kernelpack import PACK_VARIABLE, write_pack

DATA = Path(__file__).resolve().parents[1] / "patterndb" / "data"

#: Features of the levels that x86-64 processors are sorted into (System V ABI, x86-64 supplement).
LEVELS: dict[str, str] = {
    "generic": "",
    "x86-64-v2": "+cx16,+popcnt,+sahf,+sse3,+sse4.1,+sse4.2,+ssse3",
    "x86-64-v3": "+cx16,+popcnt,+sahf,+sse3,+sse4.1,+sse4.2,+ssse3"
    ",+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave",
}

#: Seconds between two lines that say how far it is.
TELL_EVERY = 1.5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cpu", choices=LEVELS, default="generic", help="what it is made for")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="use and keep what is in it")
    parser.add_argument("--jobs", type=int, help="processes; one a core")
    parser.add_argument("--note-times", action="store_true", help="write them into the list")
    parser.add_argument("--list", type=Path, help="another list than the package's")
    parser.add_argument("-o", "--output", type=Path, help="the pack")
    given = parser.parse_args()
    with contextlib.ExitStack() as stack:
        folder = given.keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        build(given, folder)


def build(given: argparse.Namespace, folder: Path) -> None:
    """Compile into the folder and pack, in a process with the settings: numba reads them once."""
    settings = {
        "NUMBA_CPU_NAME": given.cpu,
        "NUMBA_CPU_FEATURES": LEVELS[given.cpu],
        KERNELS_VARIABLE: str(folder),
        PACK_VARIABLE: "",
    }
    if any(os.environ.get(name) != value for name, value in settings.items()):
        command = [sys.executable, __file__, *sys.argv[1:], "--keep", str(folder)]
        sys.exit(os.spawnve(os.P_WAIT, sys.executable, command, {**os.environ, **settings}))

    # Imported here because they read the settings.
    from patterndb.system.kernels import get_stamp
    from patterndb.system.warming import compile_listed, count_processes

    lines = given.list.read_text(encoding="utf-8").splitlines() if given.list else []
    kernels = [parse_kernel(line) for line in lines] or read_list()
    began = told = time.monotonic()

    def progress(done: int, total: int, left: float) -> None:
        nonlocal told
        if time.monotonic() - told >= TELL_EVERY or done == total:
            told = time.monotonic()
            print(
                f"compiling kernels, once: {done} of {total}, about {left:.0f} s",
                file=sys.stderr,
                flush=True,
            )

    jobs = given.jobs or count_processes(kernels)
    made = compile_listed(kernels, processes=jobs, progress=progress)
    for kernel, error in made.failed:
        print(f"{kernel.module}.{kernel.name}: {error}", file=sys.stderr)
    for kernel in made.gone:
        print(f"{kernel.module}.{kernel.name} is no more", file=sys.stderr)
    if made.failed or made.gone:
        sys.exit("the list is not that of this code: python scripts/record_kernels.py mends it")
    if given.note_times:
        lines = [
            format_kernel(dataclasses.replace(k, seconds=max(1, round(made.seconds[k.key]))))
            for k in kernels
        ]
        replace_file(DATA / LIST_NAME, "".join(line + "\n" for line in lines))
    entries: dict[str, bytes] = {}
    for kernel in kernels:
        found = find_kernel(kernel)
        assert found is not None
        dispatcher, types = found
        content = dispatcher._cache.read_kept(types)
        if content is None:
            sys.exit(f"{kernel.module}.{kernel.name} cannot be kept: it holds addresses")
        entries[dispatcher._cache.pack_key(types)] = content
    path = given.output or DATA / "kernels" / f"{sys.implementation.cache_tag}.pack"
    size = write_pack(
        path,
        entries.items(),
        stamp=get_stamp(),
        triple=llvm.get_process_triple(),
        needs=[name.lstrip("+") for name in LEVELS[given.cpu].split(",") if name],
    )
    requires = f"numba=={numba.__version__}\nllvmlite=={llvmlite.__version__}\n"
    replace_file(path.with_suffix(".requires"), requires)
    raw = sum(map(len, entries.values()))
    print(
        f"{len(entries)} kernels, {raw / 1e6:.1f} MB, packed {size / 1e6:.1f} MB, "
        f"in {time.monotonic() - began:.0f} s by {jobs} processes: {path}"
    )


if __name__ == "__main__":
    main()
