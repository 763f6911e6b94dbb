"""Draw the pictures of the window of retopology of the documentation.

    python scripts/draw_retopo_viewer.py [--out DIR]

A hand is drawn on, tool by tool, by the moves of a mouse, and a head where a tool wants ridges or
two halves: what each shows while it is used, or before and after, is a picture of
retopo-tools.png; retopo-viewer.png is the whole window. Hand and head are those of the examples,
made smooth. Needs no display.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import trimesh
from draw_retopo_viewer_mouse import TOOL, WINDOW, Hand, Place, save, sheet
from PIL import Image

import patterndb
from ingest.formats import read_mesh
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.editor import Retopology
from query.engine import PatternSource
from viewer.retopo import RetopoState

ROOT = Path(__file__).parents[1]

#: Rounds of subdivision that make a mesh of the examples smooth.
ROUNDS = {"hand.obj": 3, "head.obj": 2}

#: Fingers: the middles of their first and last loops in the plane of the hand, half the length of
#: the line that cuts them, and how many patches go around.
FINGERS = {
    "pinky": ((-3.45, 0.2), (-4.35, 3.72), 1.1),
    "ring": ((-1.25, 0.9), (-1.64, 6.15), 1.05),
    "middle": ((1.24, 0.9), (1.24, 7.25), 1.05),
    "index": ((3.3, 0.9), (4.17, 6.05), 1.0),
    "thumb": ((5.0, -5.1), (7.55, -3.05), 1.25),
}


def smooth(name: str) -> Surface:
    """A mesh of the examples, subdivided."""
    coarse = Surface.from_polygons(read_mesh(ROOT / "examples" / name))
    mesh = trimesh.Trimesh(coarse.vertices, coarse.triangles).subdivide_loop(ROUNDS[name])
    return Surface.from_arrays(mesh.vertices, mesh.faces).orient()


def across(middle: Place, other: Place, half: float) -> tuple[Place, Place]:
    """A line across a finger at the middle of a loop of it."""
    along = np.subtract(other, middle)
    side = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    return (np.add(middle, half * side).tolist(), np.subtract(middle, half * side).tolist())


def fingers(hand: Hand) -> None:
    """Loops around fingers, and cylinders between them."""
    for name, (low, high, half) in FINGERS.items():
        shown = name == "middle"
        if shown:
            hand.closer((1.2, 4.0), 2.0)
        hand.keys("l")
        hand.drag(*across(low, high, half))
        hand.press(*across(high, low, half))
        if shown:
            hand.before()
        hand.release()
        if shown:
            hand.after("drag across, and it is cut")
        hand.keys("c")
        hand.press(low, high)
        if shown:
            hand.before()
        hand.release()
        if shown:
            hand.after("draw from loop to loop")
            hand.keys("v 3")


def palm(hand: Hand) -> None:
    """A patch about a spine, completions beside it, and curves drawn freely."""
    hand.closer((0.4, -4.0), 2.1)
    hand.keys("i ] ]")
    hand.press((0.3, -1.7), (0.35, -3.5), (0.45, -5.0), (0.6, -6.4))
    hand.tool("a patch about its midline")
    hand.release()
    hand.keys("a")
    hand.hover((1.45, -4.0))
    hand.tool("what would close here")
    hand.click((1.45, -4.0))
    hand.click((-0.75, -4.0))


def curves(hand: Hand) -> None:
    """Curves that make patches of three, four and five sides around."""
    hand.closer((0.4, -5.0), 1.6)
    hand.keys("d")
    (low_left, low_right), (top_left, top_right), (left_top, left_low, right_top, right_low) = (
        corners(hand)
    )
    hand.drag(top_left, beside(left_top, 0.6, 0.7), left_top)
    hand.drag(top_right, beside(right_top, -0.6, 0.6), right_top)
    hand.drag(low_left, (-0.5, -8.3))
    hand.drag((-0.5, -8.3), (-2.3, -7.9))
    hand.press((-2.3, -7.9), (-2.7, -6.6), beside(left_low, 0.1, -0.1))
    hand.tool("ends snap, as rings show")
    hand.release()
    hand.drag(low_right, (1.7, -8.3))
    hand.drag((1.7, -8.3), (2.9, -6.9), right_low)


def beside(place: Place, x: float, y: float) -> Place:
    """A place so far to the right of another, and above it."""
    return (place[0] + x, place[1] + y)


def corners(hand: Hand) -> tuple[list[Place], list[Place], list[Place]]:
    """Of the patches on the palm: the lower ones of the middle one, its upper ones, and those
    at the far sides of its neighbours, left and right, the upper first."""
    nodes = [node.point[:2] for node in hand.state.network.nodes.values() if node.valence == 2]
    palm = [at for at in nodes if at[1] < -1.0 and at[0] < 4.4]
    palm.sort(key=lambda at: at[1])
    middle = sorted(palm[:2], key=lambda at: at[0]), sorted(palm[-2:], key=lambda at: at[0])
    beside = sorted(palm[2:-2], key=lambda at: (at[0] > 0.0, -at[1]))
    low, top = ([at.tolist() for at in pair] for pair in middle)
    return low, top, [at.tolist() for at in beside]


def shaping(hand: Hand) -> None:
    """Curves that are there get another course."""
    hand.closer((-1.4, -6.6), 3.2)
    hand.keys("g")
    hand.press((-2.3, -7.9), (-3.0, -8.3))
    hand.tool("curves follow a corner")
    hand.state.leave()
    hand.keys("r")
    hand.press((-2.4, -7.5), (-3.4, -6.9), (-3.3, -6.2), (-2.68, -5.7))
    hand.tool("a part of a curve anew")
    hand.state.leave()
    with hand.for_now():
        hand.keys("d")
        hand.closer((0.2, -9.2), 4.0)
        hand.drag(*[(-1.3 + 0.5 * k, -9.2 + 0.3 * (0, 1, -1, 1, -1, 1, 0)[k]) for k in range(7)])
        hand.keys("f")
        hand.hover((0.2, -8.9))
        hand.before()
        for _ in range(8):
            hand.click((-1.3, -9.2))
        hand.hover((4.9, -5.0))
        hand.after("click by click")
    with hand.for_now():
        hand.keys("d")
        hand.drag((-1.2, -9.5), (1.9, -9.5))
        hand.drag((-0.6, -10.1), (0.7, -8.5))
        hand.drag((1.1, -10.1), (-0.2, -8.5))
        hand.keys("k" + 11 * " ]")
        hand.hover((0.25, -9.3))
        hand.before()
        hand.click((0.25, -9.3))
        hand.hover((4.6, -6.0))
        hand.after("a tangle becomes one corner")


def details(hand: Hand) -> None:
    """Counts, other fills, corners, and erasing."""
    hand.closer((-1.4, -6.6), 3.2)
    with hand.for_now():
        hand.keys("t")
        hand.hover((-1.4, -8.1))
        hand.before()
        for _ in range(3):
            hand.state.wheel(1.0)
        hand.state.settle()
        hand.after("the wheel over a curve")
    with hand.for_now():
        hand.keys("y")
        hand.hover((-1.3, -6.8))
        hand.before()
        hand.click((-1.3, -6.8))
        hand.after("the next of a patch's list")
    with hand.for_now():
        hand.keys("j")
        hand.hover((-2.3, -7.9))
        hand.before()
        hand.click((-2.3, -7.9))
        hand.hover((-1.0, -9.0))
        hand.after("one less: four sides")
    with hand.for_now():
        hand.keys("P .")
        hand.click((-1.3, -6.8))
        hand.keys(".")
        hand.before()
        hand.click((-1.3, -6.8))
        hand.hover((-1.0, -9.0))
        hand.after("a loop becomes one, or none")
    with hand.for_now():
        hand.keys("9")
        hand.press((-2.2, -7.4), (-1.4, -6.6), (-0.9, -5.8))
        hand.before()
        hand.release()
        hand.hover((-1.0, -9.0))
        hand.after("painted, quads are finer")
    with hand.for_now():
        hand.keys("e")
        hand.press((-0.2, -7.0), (-1.4, -5.2), (-1.5, -4.8))
        hand.before()
        hand.release("open end")
        hand.hover((-1.0, -9.0))
        hand.after("what a scribble crosses")


def quads(hand: Hand) -> None:
    """What changes quads, curves staying or following."""
    hand.closer((0.35, -4.0), 3.0)
    with hand.for_now():
        hand.keys("w")
        hand.press((-0.55, -2.6), (0.3, -2.9), (0.6, -3.8), (0.7, -5.2), (1.1, -6.0))
        hand.before()
        hand.release()
        hand.hover((4.2, -8.0))
        hand.after("where edges are to run")
        hand.keys("5")
        hand.press((0.3, -4.0))
        hand.before()
        hand.on((0.3, -4.9))
        hand.after("irregular vertices go along")
        hand.state.leave()
    hand.keys("4")
    hand.hover((0.6, -4.2))
    hand.tool("along a strip of quads")
    with hand.for_now():
        hand.closer((-0.2, -4.8), 4.0)
        hand.keys("6" + 7 * " ]")
        hand.press((-0.2, -4.3))
        hand.before()
        hand.on((0.25, -4.75))
        hand.after("drag vertices and curves")
        hand.release()
        hand.keys("7")
        hand.hover((0.1, -4.6))
        hand.before()
        for _ in range(4):
            hand.click((0.1, -4.6))
        hand.after("click by click")


def head(hand: Hand) -> None:
    """What wants two halves, or a ridge."""
    hand.closer((0.0, -1.0), 2.6)
    with hand.for_now():
        hand.keys("d")
        hand.drag((0.0, 1.8), (0.45, 0.8), (0.55, -0.6), (0.4, -1.8), (0.0, -2.6))
        hand.keys("z")
        hand.hover((0.55, -0.6))
        hand.before()
        hand.click((0.55, -0.6), "still on its way")
        hand.hover((5.0, -12.0))
        hand.after("onto a ridge or a valley")
    hand.keys("M i ]")
    hand.closer((0.0, -2.4), 1.6)
    hand.press((3.9, -0.8), (3.9, -3.0), (3.0, -5.0))
    hand.before()
    hand.release()
    hand.after("on one half, and both get it", "symmetry")


def draft(hand: Hand) -> None:
    """A whole surface, as the machine proposes it."""
    hand.before()
    hand.keys("8")
    hand.after("the machine begins", "draft")


@contextmanager
def opened(
    name: str, source: PatternSource, tools: dict[str, tuple[str, Image.Image]]
) -> Iterator[Hand]:
    """A mouse over a mesh of the examples, seen from the front."""
    state = RetopoState(Retopology(smooth(name), source))
    hand = Hand(state, tools)
    try:
        hand.image(TOOL)
        hand.keys("3")
        yield hand
    finally:
        state.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "images")
    out = parser.parse_args().out
    tools: dict[str, tuple[str, Image.Image]] = {}
    with patterndb.open() as source:
        with opened("hand.obj", source, tools) as hand:
            # Fingers want finer quads than what is usual.
            hand.keys("t [ [ [ [ [")
            fingers(hand)
            palm(hand)
            curves(hand)
            shaping(hand)
            details(hand)
            quads(hand)
            hand.image(WINDOW)
            hand.keys("v 3 a")
            hand.hover((0.6, -6.7))
            save(hand.image(WINDOW), out / "retopo-viewer.png")
        with opened("head.obj", source, tools) as hand:
            head(hand)
        with opened("head.obj", source, tools) as hand:
            draft(hand)
    missing = [mode.title for mode in hand.state.tool.modes if mode.tool not in tools]
    if missing:
        sys.exit(f"no picture of: {', '.join(missing)}; draw one of each")
    save(sheet(tools, hand.state.tool.modes), out / "retopo-tools.png")


if __name__ == "__main__":
    main()
