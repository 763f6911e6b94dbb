"""Write docs/cli.md, docs/api.md and lists of docs/retopo.md and docs/queries.md from the code;
pictures and output from the program.

    python scripts/build_docs.py              write them
    python scripts/build_docs.py --check      exit code 1 and a diff if they are stale
    python scripts/build_docs.py --walk       do what README and guides say (three
                                              minutes), and keep the pictures and the output
                                              that they show

The pages are put together by the modules beside this one, not by click's or inspect's own
formatting, so that they are the same under every version of Python and click.
"""

from __future__ import annotations

import argparse
import difflib
import sys

from build_docs_api import api_page
from build_docs_cli import cli_page
from build_docs_pictures import DOCS, ILLUSTRATED, ROOT, walk
from build_docs_queries import queries_page
from build_docs_retopo import retopo_page


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="only say whether they are stale")
    parser.add_argument("--walk", action="store_true", help="do what the pages say")
    arguments = parser.parse_args()
    if arguments.walk:
        for page in ILLUSTRATED:
            walk(page)
        return
    stale = False
    retopo, queries = DOCS / "retopo.md", DOCS / "queries.md"
    for path, page in (
        (DOCS / "cli.md", cli_page()),
        (DOCS / "api.md", api_page()),
        (retopo, retopo_page(retopo.read_text(encoding="utf-8"))),
        (queries, queries_page(queries.read_text(encoding="utf-8"))),
    ):
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        if old == page:
            continue
        stale = True
        name = path.relative_to(ROOT).as_posix()
        if arguments.check:
            sys.stdout.writelines(
                difflib.unified_diff(
                    old.splitlines(True), page.splitlines(True), name, f"{name} (from the code)"
                )
            )
        else:
            path.write_text(page, encoding="utf-8")
            print(f"written: {name}")
    if arguments.check and stale:
        sys.exit("the documentation is stale; 'make docs' writes it anew")


if __name__ == "__main__":
    main()
