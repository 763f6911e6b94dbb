"""How long after the last corner the first fill is on the screen, in a real browser.

    python benchmarks/page_latency.py [--rounds 25]

Polygons of three to six sides are clicked on the page of ``patterndb serve``, at places that a seed
gives. The clock starts when the polygon is closed and stops when the browser, having drawn the
first fill, asks for the next picture (the page's own measure ``first-fill``). It draws in software
(SwiftShader). Needs the page (``make page``), a browser of the system, and the extra ``dev``.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import statistics
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))

from drive_page import click_corners, open_browser, run_service, wait_for_fills  # noqa: E402

SEED = 7

#: The page's measures of one polygon, in milliseconds.
MEASURE = "performance.getEntriesByName('first-fill').map(entry => entry.duration)"


def main() -> None:
    parser = argparse.ArgumentParser(description="time the first fill on the page")
    parser.add_argument("--rounds", type=int, default=25, help="polygons that are drawn")
    asked = parser.parse_args()
    if not (ROOT / "patterndb_app" / "web" / "bundle" / "index.html").is_file():
        parser.error("there is no page yet; make it with: python scripts/build_page.py")
    draw = random.Random(SEED)
    times: list[float] = []
    with run_service() as address, open_browser() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(120_000)
        page.goto(address)
        page.wait_for_timeout(2000)
        # The first one loads what the service has not loaded yet: it is told apart.
        for round in range(asked.rounds + 1):
            page.get_by_role("button", name="begin anew").click()
            n = 3 + round % 4
            turn = draw.uniform(0, 2 * math.pi)
            corners: list[tuple[float, float]] = []
            for i in range(n):
                angle = turn - 2 * math.pi * (i + draw.uniform(-0.2, 0.2)) / n
                radius = draw.uniform(0.26, 0.34)
                corners.append(
                    (0.45 + 0.62 * radius * math.cos(angle), 0.55 + radius * math.sin(angle))
                )
            click_corners(page, corners)
            wait_for_fills(page)
            page.wait_for_timeout(300)
            times.append(page.evaluate(MEASURE)[-1])
            print(f"{n} sides: {times[-1]:.0f} ms", file=sys.stderr, flush=True)
    first, *rest = times
    rest.sort()
    middle, late = statistics.median(rest), rest[min(len(rest) - 1, int(0.95 * len(rest)))]
    print(f"first fill on the screen, {len(rest)} polygons, seed {SEED}:")
    print(f"median {middle:.0f} ms, p95 {late:.0f} ms, the very first polygon {first:.0f} ms")
    print(f"load of the machine {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors")


if __name__ == "__main__":
    main()
