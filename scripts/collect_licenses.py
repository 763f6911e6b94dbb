"""Write the licences of the crates in the compiled core, which packages bring along.

    python scripts/collect_licenses.py

Asks ``cargo metadata`` for the crates of rust/Cargo.lock; what only builds or expands macros is not
linked. Writes patterndb/data/crate_licenses.txt.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
WRITTEN = ROOT / "patterndb" / "data" / "crate_licenses.txt"

#: Of a crate under several licences the first of these files is taken.
FILES = ("LICENSE-MIT", "LICENSE", "LICENSE.txt", "LICENSE.md", "LICENSE-APACHE")


def list_linked(metadata: dict[str, Any]) -> list[dict[str, Any]]:
    """The crates that become part of the extension, ours left out, by name."""
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    waiting = [one for one, package in packages.items() if package["name"] == "patterndb-python"]
    met = set(waiting)
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            one = dependency["pkg"]
            is_linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            is_macro = any("proc-macro" in target["kind"] for target in packages[one]["targets"])
            if is_linked and not is_macro and one not in met:
                met.add(one)
                waiting.append(one)
    linked = (packages[one] for one in met)
    return sorted((one for one in linked if one["source"]), key=lambda one: one["name"])


def main() -> None:
    manifest = ROOT / "rust" / "Cargo.toml"
    command = [
        "cargo",
        "metadata",
        "--locked",
        "--format-version",
        "1",
        "--manifest-path",
        manifest,
    ]
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode:
        sys.exit(done.stderr.decode())
    parts = ["Crates that are linked into the compiled core of patterndb, and their licences.\n"]
    for crate in list_linked(json.loads(done.stdout)):
        folder = Path(crate["manifest_path"]).parent
        found = next((folder / name for name in FILES if (folder / name).is_file()), None)
        if found is None:
            sys.exit(f"{crate['name']} {crate['version']} has no file of its licence in {folder}")
        head = f"{crate['name']} {crate['version']} ({crate['license']})"
        parts.append(f"{'=' * 80}\n{head}\n\n{found.read_text(encoding='utf-8').strip()}\n")
    WRITTEN.write_text("\n".join(parts), encoding="utf-8")
    print(f"{WRITTEN.relative_to(ROOT)}: {len(parts) - 1} crates")


if __name__ == "__main__":
    main()
