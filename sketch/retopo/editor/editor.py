"""The editor: a state, its history, and calls of tools."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from query.engine import PatternSource
from sketch.retopo.editor.arguments import read_arguments
from sketch.retopo.editor.history import History
from sketch.retopo.editor.state import State
from sketch.retopo.editor.table import TOOLS
from sketch.retopo.editor.tool import Work
from sketch.retopo.errors import InvalidRetopoError, RefusedError
from sketch.retopo.filling import Cache, FilledNetwork, completed
from sketch.retopo.ground import Ground
from sketch.retopo.network import Network, with_borders
from sketch.retopo.sizes import Sizes


@dataclass(frozen=True, slots=True)
class Call:
    """A tool by name, with arguments as plain data; see :data:`TOOLS`."""

    tool: str
    arguments: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a call came to.

    changed: is the state another one? refused: why the tool did nothing, None if it did
    something. notes: what the user should know.
    """

    changed: bool
    refused: str | None = None
    notes: tuple[str, ...] = ()


class Editor:
    """A network on a ground, edited by calls.

    A window, a script and a test say what is to be done in the same calls; "undo" and "redo" are
    two of them. A tool that refuses, or changes nothing, leaves no step in the history. After a
    call patches have their loops; :meth:`fill` gives them counts, fills and places, at once or
    when there is time.
    """

    def __init__(self, ground: Ground, source: PatternSource, sizes: Sizes | None = None) -> None:
        """On a ground, whose borders become marked chains; source: of patterns."""
        self.ground = ground
        self.source = source
        chosen = Sizes.of(ground.diagonal) if sizes is None else sizes
        network = Network(longest=2.0 * ground.diagonal)
        network = with_borders(network, ground, chosen.sampling)
        self._history = History(State(network, chosen))
        self._cache = Cache()
        self._filled: FilledNetwork | None = None

    @property
    def state(self) -> State:
        return self._history.now

    @property
    def network(self) -> Network:
        return self._history.now.network

    @property
    def sizes(self) -> Sizes:
        return self._history.now.sizes

    @property
    def undoable(self) -> int:
        """Steps that can be undone."""
        return self._history.undoable

    @property
    def redoable(self) -> int:
        """Steps that can be redone."""
        return self._history.redoable

    def do(self, call: Call) -> Outcome:
        """Obey a call.

        Raises InvalidRetopoError for a tool or arguments that there are not; whatever else a
        tool cannot do is told in the outcome.
        """
        if call.tool in ("undo", "redo"):
            read_arguments(call.tool, {}, call.arguments)
            moved = self._history.undo() if call.tool == "undo" else self._history.redo()
            return Outcome(True) if moved else Outcome(False, f"there is nothing to {call.tool}")
        tool = TOOLS.get(call.tool)
        if tool is None:
            there = ", ".join([*TOOLS, "undo", "redo"])
            raise InvalidRetopoError(f"there is no tool {call.tool!r}; there are {there}")
        arguments = read_arguments(call.tool, tool.arguments, call.arguments)
        try:
            result = tool.act(Work(self.state, self.ground, self.source), arguments)
        except RefusedError as error:
            return Outcome(False, str(error))
        if result.state.same(self.state):
            return Outcome(False, None, result.notes)
        self._history.step(result.state)
        return Outcome(True, None, result.notes)

    def fill(self) -> FilledNetwork:
        """Counts, fills and places for all patches of the state now; it keeps them."""
        found = completed(self.network, self.ground, self.source, self.sizes.edge, self._cache)
        self.adopt(self.network, found)
        return found

    def adopt(self, network: Network, found: FilledNetwork) -> bool:
        """Keep what was filled elsewhere, if the network is still the one that it was made for."""
        if network is not self.network:
            return False
        if found.network is not network:
            self._history.settle(replace(self.state, network=found.network))
        self._filled = found
        return True

    def restore(self, state: State) -> None:
        """Begin from a state that was saved; nothing can be undone."""
        self._history = History(state)
        self._filled = None
