"""Print the lowest releases that pyproject.toml allows, as constraints for pip.

The bounds of what is installed with patterndb and with its extras (not those of development and
benchmarks) are promises: `make lowest` installs exactly these releases and runs tests on them.
Releases that only they depend on are left to pip.

    python scripts/lowest_versions.py > lowest.txt
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
# What users never install.
OURS = ("dev", "benchmark", "all")


def list_lowest(project: Path = PROJECT) -> list[str]:
    """List `name==release` of every bound, sorted; a requirement without a bound is an error."""
    table = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    wanted = list(table["dependencies"])
    for extra, requirements in table["optional-dependencies"].items():
        if extra not in OURS:
            wanted += requirements
    lowest: set[str] = set()
    for text in wanted:
        requirement = Requirement(text)
        releases = [s.version for s in requirement.specifier if s.operator == ">="]
        if len(releases) != 1:
            raise SystemExit(f'pyproject.toml: "{text}" needs one lowest release, name>=X')
        lowest.add(f"{requirement.name}=={releases[0]}")
    return sorted(lowest, key=str.lower)


if __name__ == "__main__":
    print("\n".join(list_lowest()))
