"""Say where the Rust compiler that builds the core will come from, or how to get one.

    python scripts/find_cargo.py             before an installation
    python scripts/find_cargo.py --failed    after one that failed

Silent where ``cargo`` is on the PATH and new enough. Where it is missing, pip gets a toolchain of
its own for the build, from static.rust-lang.org into the cache folder (puccinialin): this says
so. Exits with 1, before anything is downloaded, where neither can be.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

#: Where rustup's toolchains come from.
SOURCE = "https://static.rust-lang.org/rustup/release-stable.toml"

WAYS = """Ways to get one:
  - rustup:              https://rustup.rs
  - the system's package: apt-get install cargo, dnf install cargo, brew install rust, ...
                         where it has {least} or later
  - no compiler at all:  install a wheel of patterndb in place of the clone"""


def main() -> None:
    failed = sys.argv[1:] == ["--failed"]
    manifest = Path(__file__).resolve().parents[1] / "rust" / "Cargo.toml"
    declared = re.search(r'^rust-version = "([\d.]+)"$', manifest.read_text(encoding="utf-8"), re.M)
    assert declared is not None
    least = declared[1]
    ways = WAYS.format(least=least)
    if shutil.which("cargo"):
        done = subprocess.run(["cargo", "--version"], capture_output=True, text=True, check=False)
        found = re.match(r"cargo (\d+)\.(\d+)", done.stdout)
        if found and (int(found[1]), int(found[2])) >= tuple(map(int, least.split("."))):
            return
        which = done.stdout.strip() or done.stderr.strip().partition("\n")[0]
        sys.exit(f"The core of patterndb needs Rust {least} or later; here is: {which}\n{ways}")
    if failed:
        sys.exit(f"If what failed is getting a Rust toolchain (puccinialin):\n{ways}")
    try:
        urllib.request.urlopen(SOURCE, timeout=15).close()
    except (OSError, urllib.error.URLError) as error:
        sys.exit(
            f"The core of patterndb is compiled by Rust: there is no cargo on the PATH, and "
            f"static.rust-lang.org cannot be reached ({error}).\n{ways}"
        )
    print(
        "no cargo on the PATH: pip gets a Rust toolchain for the build, once (660 MB, in the "
        "folder puccinialin of your cache folder)",
        flush=True,
    )


if __name__ == "__main__":
    main()
