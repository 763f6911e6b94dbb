"""What the window of retopology shows and how that changes: no window in here."""

from __future__ import annotations

import numpy as np

from patterndb.geometry.points import Points
from patterndb.geometry.surface import Surface, SurfacePoints
from patterndb_sketch.retopo.editing import RetopoEditing, Snapshot
from patterndb_sketch.retopo.editor import Retopology
from patterndb_sketch.retopo.files import RetopoFiles
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.picking import find_upright
from patterndb_sketch.retopo.previews import Preview
from patterndb_sketch.retopo.sizes import Sizes
from viewer.camera import ViewerState
from viewer.pointer import CLICK
from viewer.retopo.aiming import ToolPointer
from viewer.retopo.modes import ToolMode, ToolOption
from viewer.retopo.pointing import RetopoCamera, pick_line

#: By how much a key changes a brush, and how far brushes go, as parts of the usual size.
WIDER, BRUSHES = 1.15, (0.1, 6.0)

#: The tool that moves curves nearby without being taken.
TWEAKING = "brush"

#: And where there are no quads yet.
PULLING = "pull"

#: The tool while which density is seen.
PAINTING = "density"


class RetopoState(ViewerState[RetopoCamera]):
    """A network on a surface, tools in use on it, and how it is looked at: what a mouse and a clock
    make of them.

    files: for keys that save. editing: what is asked of the editor. camera:
    from where it is looked at. tool: the one in use, and what the pointer is on. quads_shown,
    curves_shown: what is seen.
    """

    def __init__(self, editor: Retopology, *, files: RetopoFiles | None = None) -> None:
        self.editing = RetopoEditing(editor, files)
        camera = RetopoCamera(editor.surface.vertices, find_upright(editor.surface))
        super().__init__(camera, self.editing)
        self.tool = ToolPointer(self.editing, camera)
        self.quads_shown = self.curves_shown = True
        self._tool_kept: ToolMode | None = None
        self._preview: Preview | None = None

    def close(self) -> None:
        """Wait until nothing is being made any more."""
        self.editing.close()

    @property
    def surface(self) -> Surface:
        """What is drawn on."""
        return self.editing.surface

    @property
    def shown(self) -> Snapshot:
        """What there is to see."""
        return self.editing.shown

    @property
    def network(self) -> Network:
        """The curves and patches."""
        return self.editing.network

    @property
    def density_shown(self) -> bool:
        """Is it seen how dense quads shall be? While the brush that paints it is in use."""
        return self.tool.mode.tool == PAINTING

    @property
    def sizes(self) -> Sizes:
        """How long edges shall be, and how far tools reach."""
        return self.editing.sizes

    # What keys do

    def choose_mode(self, tool: str) -> None:
        """Take another tool."""
        self._choose(next(mode for mode in self.tool.modes if mode.tool == tool))

    def next_mode(self, step: int) -> None:
        """Take the tool after this one in the list, or before; not those that act at once."""
        kept = [mode for mode in self.tool.modes if mode.gesture != "act"]
        self._choose(kept[(kept.index(self.tool.mode) + step) % len(kept)])

    def wider(self, step: int) -> None:
        """A larger brush, or a smaller one."""
        name = self.tool.mode.brush
        if not name:
            self.message = f"{self.tool.mode.title} has no brush"
        elif self.tool.mode.given_as:
            factor = self.tool.factors.get(name, 1.0) * WIDER**step
            self.tool.factors[name] = float(np.clip(factor, *BRUSHES))
        elif name == "edge":
            self.editing.do("recount", edge=self.sizes.edge * WIDER**step)
        else:
            self.editing.do("sizes", **{name: getattr(self.sizes, name) * WIDER**step})
        self.tool.seek()

    def more(self, step: int) -> None:
        """More of what this tool has: edges, the next completion, the next number."""
        mode = self.tool.mode
        number = next((option for option in mode.options if option.number), None)
        if mode.gesture == "count":
            self.count(step, whole_strip=False)
        elif mode.tool == "autocomplete":
            count = self.tool.preview.count if self.tool.preview is not None else 0
            self.tool.choice = int(np.clip(self.tool.choice - step, 0, max(count - 1, 0)))
            self.tool.seek()
        elif number is not None:
            value = self.tool.option(mode, number)
            ordered = sorted(v for v in number.values if isinstance(v, int))
            at = ordered.index(value) if isinstance(value, int) else 0
            self.tool.options[mode.tool, number.name] = ordered[
                int(np.clip(at + step, 0, len(ordered) - 1))
            ]
        else:
            self.message = f"there is nothing to be more or less of in {mode.title}"

    def next_option(self) -> None:
        """The next value of the tool's first option that is no number."""
        option = next(
            (one for one in self.tool.mode.options if not one.number and one.typed is None), None
        )
        if option is None:
            self.message = f"{self.tool.mode.title} has no such option"
        else:
            at = option.values.index(self.tool.option(self.tool.mode, option))
            self.turn_option(option, option.values[(at + 1) % len(option.values)])

    def count(self, by: int, *, whole_strip: bool) -> None:
        """More or fewer edges on the curve under the pointer; on all of its strip, or not."""
        found = self.tool.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
            return
        arguments = {"at": found[1].tolist(), "by": by} | self.tool.tell_options()
        if whole_strip:
            arguments["strip"] = True
        self.editing.do("subdivide", **arguments)

    def mirror(self) -> None:
        """Symmetry on, about the plane that options name or else the surface's own, or off."""
        given: dict[str, object] = {"on": False}
        if self.shown.state.plane is None:
            mode = next(mode for mode in self.tool.modes if mode.tool == "symmetry")
            given = dict(mode.fixed) | self.tool.tell_options(mode)
            if given.keys() & {"axis", "point", "normal"}:
                # It is of a plane that is found.
                given.pop("tolerance", None)
            else:
                given["find"] = True
        self.editing.do("symmetry", **given)
        self.tool.seek()

    def next_fill(self, step: int) -> None:
        """The fill after that of the patch under the pointer in its list, or before."""
        foot = self.tool.foot
        if foot is None:
            self.message = "put the pointer on a patch"
        else:
            self.editing.do("choose", at=foot.points[0].tolist(), by=step)

    def erase_under(self) -> None:
        """Erase the curve under the pointer."""
        found = self.tool.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
        else:
            self.editing.do("erase", at=found[1].tolist())

    def accept(self) -> None:
        """Do what a click at the pointer does."""
        if self.camera.pointer is not None and self.tool.held is None:
            self._click(self.tool.foot)

    def leave(self) -> bool:
        """Escape: let go of what is drawn, or drop what waits; False if there is neither."""
        left = self.tool.held is not None or self.editing.drop_waiting()
        self.tool.held = None
        self.tool.let_go()
        return left

    def next_model_look(self) -> None:
        """The surface solid, transparent or hidden; never hidden where nothing else is seen."""
        self.message = self.camera.next_model_look(may_hide=self._sees_network)

    @property
    def _sees_network(self) -> bool:
        return bool(self.network.chains) and (
            self.curves_shown or (self.quads_shown and bool(self.shown.filled.placed))
        )

    def next_seen(self) -> None:
        """Quads and curves are seen, curves alone, or quads alone."""
        if self.quads_shown and self.curves_shown:
            self.quads_shown = False
            self.message = "curves alone are shown"
        elif self.curves_shown:
            self.quads_shown, self.curves_shown = True, False
            self.message = "quads alone are shown"
        else:
            self.curves_shown = True
            self.message = "quads and curves are shown"
        if self.camera.model_look == "hidden" and not self._sees_network:
            self.camera.model_look = "solid"

    def toggle_strips(self) -> None:
        """Show the strips of quads through the pointer, or no more."""
        self.tool.strips_shown = not self.tool.strips_shown

    def turn_option(self, option: ToolOption, value: object, mode: ToolMode | None = None) -> None:
        """Give an option of a tool a value; mode: of the tool, by default the one in use."""
        self.tool.options[(mode or self.tool.mode).tool, option.name] = value
        self.tool.seek()

    # The pointer, at places of the picture in points from its middle

    def press(self, x: float, y: float, *, turn: bool = False, tweak: bool = False) -> bool:
        """A button goes down. turn: it is the one that always turns the view. tweak: until it
        comes up, curves nearby are moved, whatever the tool is: with the brush where there are
        quads, else each by itself."""
        if tweak and self._tool_kept is None:
            self._tool_kept = self.tool.mode
            self.tool.point_at(x, y)
            tool = TWEAKING if self._is_brush_on_quads() else PULLING
            self.tool.mode = next(mode for mode in self.tool.modes if mode.tool == tool)
        self.tool.point_at(x, y)
        self.tool.pressed, self.tool.strayed = (x, y), False
        if turn:
            self.tool.held, self.tool.pressed = "view", None
            return False
        self.message = ""
        gesture = self.tool.mode.gesture
        if gesture == "plane":
            self.tool.held = "plane"
        elif self.tool.foot is None:
            self.tool.held = "view"
        elif gesture in ("stroke", "scribble", "within"):
            self.tool.held, self.tool.line = "line", [self.tool.foot.points[0]]
        elif gesture in ("drag", "corner"):
            self.tool.held, self.tool.line = "drag", [self.tool.foot.points[0]]
        else:
            self.tool.held = "click"
        return True

    def _is_brush_on_quads(self) -> bool:
        """Is a vertex of the quads within the vertex brush at the pointer?"""
        foot, vertices = self.tool.foot, self.shown.body.mesh.vertices
        if foot is None or not len(vertices):
            return False
        away = np.linalg.norm(vertices - foot.points[0], axis=1)
        return bool(away.min() <= self.sizes.brush)

    def move(self, x: float, y: float) -> bool:
        """The pointer moves; True if that changes the picture."""
        last, pressed = self.camera.pointer, self.tool.pressed
        if pressed is not None and np.hypot(x - pressed[0], y - pressed[1]) >= CLICK:
            self.tool.strayed = True
        if self.tool.held in ("view", "click") and last is not None:
            if pressed is not None:
                if not self.tool.strayed:
                    return False
                # What began as a click turns, by all that it has moved.
                last, self.tool.pressed, self.tool.held = pressed, None, "view"
            self.camera.turn(x - last[0], y - last[1])
            self.camera.pointer = (x, y)
            return True
        self.tool.point_at(x, y)
        if self.tool.held == "line" and last is not None:
            self.tool.line.extend(pick_line(self.camera.view, self.surface, last, (x, y)))
        self.tool.seek()
        return True

    def release(self, x: float, y: float) -> bool:
        """The button comes up: what was drawn is done, or it was a click."""
        try:
            return self._release(x, y)
        finally:
            if self._tool_kept is not None:
                self.tool.mode, self._tool_kept = self._tool_kept, None
                self.tool.seek()

    def _release(self, x: float, y: float) -> bool:
        held, pressed = self.tool.held, self.tool.pressed
        if pressed is not None:
            self.move(x, y)
            held = self.tool.held
        self.tool.point_at(x, y)
        # A line may end where it began.
        still = pressed is not None and not self.tool.strayed
        line = self.tool.line
        self.tool.held = self.tool.pressed = None
        self.tool.let_go()
        if held == "plane" and pressed is not None:
            self._cut(pressed, (x, y))
        elif held == "drag":
            self._dragged(line[0], still)
        elif held == "line" and not still:
            self._drawn(line)
        elif held in ("line", "click") and still:
            self._click(self.tool.foot)
        self.tool.seek()
        return True

    def wheel(self, steps: float, *, shift: bool = False, modifier: bool = False) -> bool:
        """The wheel turns: nearer or farther off; with a modifier, or in the mode of counts on a
        curve, it changes the curve's edges, with shift those of its strip."""
        counts = modifier or shift or self.tool.mode.gesture == "count"
        if counts and self.tool.chain_under() is not None:
            self.message = ""
            self.count(1 if steps > 0.0 else -1, whole_strip=shift)
            return True
        if self.tool.holding:
            return False
        self.camera.wheel(steps)
        self.tool.seek()
        return True

    def drag_view(self, dx: float, dy: float) -> bool:
        """Shift the picture."""
        return not self.tool.holding and self.camera.drag_view(dx, dy)

    # The clock

    def poll(self) -> bool:
        """Is there something new since the last time that this was asked?"""
        new = self.editing.take()
        if new:
            self.tool.seek()
        new |= self.editing.tick()
        before, self._preview = self._preview, self.tool.preview
        return new or self._preview is not before

    def settle(self) -> None:
        """Wait for all that was asked for."""
        self.editing.settle()
        self.tool.seek()
        self.editing.settle()

    # How it is done

    def _choose(self, mode: ToolMode) -> None:
        if mode.tool == "symmetry":
            self.mirror()
            return
        if mode.gesture == "act":
            self.editing.do(mode.tool, **(dict(mode.fixed) | self.tool.tell_options(mode)))
            return
        self.tool.mode, self.tool.choice, self.tool.held = mode, 0, None
        self.tool.let_go()
        self.tool.seek()

    def _drawn(self, line: list[Points]) -> None:
        """A line was drawn on the surface."""
        if len(line) < 2:
            self.message = "draw on the surface"
            return
        given = self.tool.tell_arguments() | {self.tool.mode.places[0]: np.stack(line).tolist()}
        self.editing.do(self.tool.mode.tool, **given)

    def _click(self, foot: SurfacePoints | None) -> None:
        """A click on the surface."""
        mode = self.tool.mode
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
            found = self.tool.chain_under() if mode.target == "chain" else None
            at = point if found is None else found[1]
            name = mode.places[-1] if mode.gesture in ("scribble", "within") else mode.places[0]
            self.editing.do(mode.tool, **(self.tool.tell_arguments() | {name: at.tolist()}))

    def _pin(self) -> None:
        """Keep the count of the curve under the pointer, or let it change again."""
        found = self.tool.chain_under()
        if found is None:
            self.message = "put the pointer on a curve"
            return
        chain = self.network.chains[found[0]]
        at = found[1].tolist()
        if chain.pinned:
            self.editing.do("subdivide", at=at, free=True)
        elif chain.count:
            self.editing.do("subdivide", at=at, count=chain.count)
        else:
            self.message = "this curve has no count yet: it is in no patch"

    def _complete(self, point: Points) -> None:
        """Take the completion that is shown."""
        self.tool.seek()
        self.editing.settle()
        given: dict[str, object] = self.tool.tell_arguments() | {"at": point.tolist()}
        preview = self.tool.preview
        if preview is not None and preview.count:
            given["choice"], self.tool.choice = preview.number, 0
        self.editing.do("autocomplete", **given)

    def _dragged(self, begun: Points, still: bool) -> None:
        """Something was dragged from one point of the surface to another, or clicked."""
        mode, foot = self.tool.mode, self.tool.foot
        if foot is None:
            self.message = "let go on the surface"
            return
        if mode.gesture == "corner":
            first, second = mode.places
            wedge = {} if still else {second: begun.tolist()}
            self.editing.do(
                mode.tool, **(self.tool.tell_arguments() | {first: foot.points[0].tolist()} | wedge)
            )
        elif still:
            self.message = f"hold the button: {mode.hint}"
        else:
            self.editing.do(
                mode.tool, **(self.tool.tell_arguments() | self.tool.tell_ends(begun, foot))
            )

    def _cut(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        places = self.tool.tell_plane(begin, end)
        if places is None:
            self.message = "drag a line across a part of the surface"
        else:
            self.editing.do(self.tool.mode.tool, **(self.tool.tell_arguments() | places))
