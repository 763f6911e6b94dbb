"""Tools as the editor knows them: a name, arguments, and a function from state to state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from query.engine import PatternSource
from query.placing.surface import Points
from sketch.retopo.editor.arguments import Argument
from sketch.retopo.editor.state import State
from sketch.retopo.errors import RefusedError
from sketch.retopo.ground import Feet, Ground, Stroke, cleaned
from sketch.retopo.network import Edit, Network, nearest_place, samples


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """What a tool works on."""

    state: State
    ground: Ground
    source: PatternSource

    @property
    def network(self) -> Network:
        return self.state.network

    def foot(self, point: ArrayLike) -> Feet:
        """The point of the ground nearest to a point (3,), as one foot."""
        return self.ground.nearest(np.asarray(point, np.float64)[None])

    def stroke(self, points: Points, closed: bool | None = None) -> Stroke:
        """A stroke as it was drawn, cleaned."""
        return cleaned(points, self.ground, self.state.sizes, closed)

    def chain_at(self, point: ArrayLike) -> int:
        """The chain nearest to a point of the ground, within the snap radius."""
        foot = self.foot(point)
        found = nearest_place(
            samples(self.network), foot.points[0], foot.normals[0], self.state.sizes.snap
        )
        if found is None:
            raise RefusedError("no curve is near; point closer to one")
        return found.chain

    def edited(self, edit: Edit) -> Result:
        """What a tool's edit comes to."""
        return Result(replace(self.state, network=edit.network), edit.notes)

    def with_network(self, network: Network, notes: tuple[str, ...] = ()) -> Result:
        return Result(replace(self.state, network=network), notes)


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """The state after a tool, and what the user should know."""

    state: State
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """name: in calls. help: one sentence. arguments: by name. act: from work to result; it raises
    RefusedError where the tool cannot do what it was asked for."""

    name: str
    help: str
    arguments: Mapping[str, Argument]
    act: Callable[[Work, dict[str, Any]], Result]
