"""Using: the calls that keys and gestures come to."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb_sketch.retopo.ground import GroundPoints
from viewer.retopo.foreseeing import Foreseeing
from viewer.retopo.modes import ToolMode, ToolOption

#: By how much a key changes a brush, and how far brushes go, as parts of the usual size.
WIDER, BRUSHES = 1.15, (0.1, 6.0)


class Using(Foreseeing):
    """Tools in use: what keys and gestures have the editor do."""

    def choose_mode(self, tool: str) -> None:
        """Take another tool."""
        self._choose(next(mode for mode in self.modes if mode.tool == tool))

    def next_mode(self, step: int) -> None:
        """Take the tool after this one in the list, or before; not those that act at once."""
        kept = [mode for mode in self.modes if mode.gesture != "act"]
        self._choose(kept[(kept.index(self.mode) + step) % len(kept)])

    def wider(self, step: int) -> None:
        """A larger brush, or a smaller one."""
        name = self.mode.brush
        if not name:
            self.message = f"{self.mode.title} has no brush"
        elif self.mode.given_as:
            factor = self._factors.get(name, 1.0) * WIDER**step
            self._factors[name] = float(np.clip(factor, *BRUSHES))
        elif name == "edge":
            self.do("recount", edge=self.sizes.edge * WIDER**step)
        else:
            self.do("sizes", **{name: getattr(self.sizes, name) * WIDER**step})
        self._seek()

    def more(self, step: int) -> None:
        """More of what this tool has: edges, the next completion, the next number."""
        mode = self.mode
        number = next((option for option in mode.options if option.number), None)
        if mode.gesture == "count":
            self.count(step, whole_strip=False)
        elif mode.tool == "autocomplete":
            count = self.preview.count if self.preview is not None else 0
            self.choice = int(np.clip(self.choice - step, 0, max(count - 1, 0)))
            self._seek()
        elif number is not None:
            value = self.option(mode, number)
            ordered = sorted(v for v in number.values if isinstance(v, int))
            at = ordered.index(value) if isinstance(value, int) else 0
            self.options[mode.tool, number.name] = ordered[
                int(np.clip(at + step, 0, len(ordered) - 1))
            ]
        else:
            self.message = f"there is nothing to be more or less of in {mode.title}"

    def next_option(self) -> None:
        """The next value of the tool's first option that is no number."""
        option = next((option for option in self.mode.options if not option.number), None)
        if option is None:
            self.message = f"{self.mode.title} has no such option"
        else:
            self._turn(option)

    def count(self, by: int, *, whole_strip: bool) -> None:
        """More or fewer edges on the curve under the pointer; on all of its strip, or not."""
        found = self.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
            return
        arguments = {"at": found[1].tolist(), "by": by} | self._told_options()
        if whole_strip:
            arguments["strip"] = True
        self.do("subdivide", **arguments)

    def mirror(self) -> None:
        """Symmetry on, about the surface's own plane, or off."""
        on = self.shown.state.plane is None
        self.do("symmetry", **({"find": True} if on else {"on": False}))
        self._seek()

    def next_fill(self, step: int) -> None:
        """The fill after that of the patch under the pointer in its list, or before."""
        foot = self.foot
        if foot is None:
            self.message = "put the pointer on a patch"
        else:
            self.do("choose", at=foot.points[0].tolist(), by=step)

    def erase_under(self) -> None:
        """Erase the curve under the pointer."""
        found = self.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
        else:
            self.do("erase", at=found[1].tolist())

    # What gestures come to

    def _choose(self, mode: ToolMode) -> None:
        if mode.tool == "symmetry":
            self.mirror()
            return
        if mode.gesture == "act":
            self.do(mode.tool, **(dict(mode.fixed) | self._told_options(mode)))
            return
        self.mode, self.choice, self._held = mode, 0, None
        self._let_go()
        self._seek()

    def _turn(self, option: ToolOption) -> None:
        """The next value of an option."""
        at = option.values.index(self.option(self.mode, option))
        self.options[self.mode.tool, option.name] = option.values[(at + 1) % len(option.values)]

    def _drawn(self, line: list[Points]) -> None:
        """A line was drawn on the ground."""
        if len(line) < 2:
            self.message = "draw on the surface"
            return
        given = self._given() | {self.mode.places[0]: np.stack(line).tolist()}
        self.do(self.mode.tool, **given)

    def _click(self, foot: GroundPoints | None) -> None:
        """A click on the ground."""
        mode = self.mode
        if foot is None:
            self.message = "point at the surface"
            return
        point = foot.points[0]
        if mode.gesture in ("stroke", "drag", "plane"):
            self.message = f"hold the button: {mode.hint}"
        elif mode.gesture == "count":
            self._pin()
        elif mode.tool == "autocomplete":
            self._complete(point)
        else:
            found = self.chain_under() if mode.target == "chain" else None
            at = point if found is None else found[1]
            name = mode.places[-1] if mode.gesture in ("scribble", "within") else mode.places[0]
            self.do(mode.tool, **(self._given() | {name: at.tolist()}))

    def _pin(self) -> None:
        """Keep the count of the curve under the pointer, or let it change again."""
        found = self.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
            return
        chain = self.network.chains[found[0]]
        at = found[1].tolist()
        if chain.pinned:
            self.do("subdivide", at=at, free=True)
        elif chain.count:
            self.do("subdivide", at=at, count=chain.count)
        else:
            self.message = "this curve has no count yet: it is in no patch"

    def _complete(self, point: Points) -> None:
        """Take the completion that is shown."""
        self._seek()
        self._latest.wait()
        self._take_preview()
        preview = self.preview
        if preview is None or not preview.count:
            self.do("autocomplete", **(self._given() | {"at": point.tolist()}))
            return
        given = self._given() | {"at": preview.at.tolist(), "choice": preview.number}
        self.choice = 0
        self.do("autocomplete", **given)

    def _dragged(self, begun: Points, still: bool) -> None:
        """Something was dragged from one point of the ground to another, or clicked."""
        mode, foot = self.mode, self._foot
        if foot is None:
            self.message = "let go on the surface"
            return
        if mode.gesture == "corner":
            first, second = mode.places
            wedge = {} if still else {second: begun.tolist()}
            self.do(mode.tool, **(self._given() | {first: foot.points[0].tolist()} | wedge))
        elif still:
            self.message = f"hold the button: {mode.hint}"
        else:
            self.do(mode.tool, **(self._given() | self._ends(begun, foot)))

    def _cut(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        found = self._plane(begin, end)
        if found is None:
            self.message = "drag a line across a part of the surface"
            return
        point, normal, limit = found
        at = {"at": point.tolist(), "normal": normal.tolist(), "limit": limit}
        self.do(self.mode.tool, **(self._given() | at))
