"""Builds wheels with the compiled kernels that ``scripts/pack_kernels.py`` has made, if it has.

Without a pack for the Python that builds, the wheel is for every platform, and its kernels are
compiled where it is installed. With one it is for this Python and platform, and for the release of
numba that compiled them: with another one they would be of no use.
"""

from __future__ import annotations

import os
import platform
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

#: Set to 0, a wheel without kernels is built though there is a pack.
VARIABLE = "PATTERNDB_WHEEL_KERNELS"


class KernelWheelHook(BuildHookInterface[Any]):
    """Adds the pack of the Python that builds, and says for what the wheel is then."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before a wheel is built; a standard one takes the pack along."""
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
