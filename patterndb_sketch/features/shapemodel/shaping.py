"""The shape that is being made: coefficients, pulls, curves that are held, and the way back."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from patterndb.core.halfedge import Int64Array
from patterndb.errors import PatternDBError
from patterndb.geometry.points import Floats, Points
from patterndb_sketch.features.errors import InvalidFeatureError
from patterndb_sketch.features.registration import Template
from patterndb_sketch.features.registration.template import MIRROR, Mirroring
from patterndb_sketch.features.shapemodel.edit import STIFFNESS, ShapeEdit, edit, pull_feature
from patterndb_sketch.features.shapemodel.model import ShapeModel
from patterndb_sketch.history import History
from patterndb_sketch.sessions import SessionFormat


@dataclass(frozen=True, slots=True, eq=False)
class ShapeLine:
    """A feature curve of whole shapes, as it is grabbed.

    name: of the feature. vertices: (n,) of the whole shape. part: number of the template's part.
    mirrored: is it the mirror image of the feature, so that pulls are mirrored, too?
    """

    name: str
    vertices: Int64Array
    part: int
    mirrored: bool

    @property
    def title(self) -> str:
        """The name as people read it."""
        return self.name.replace("_", " ")

    def pull(self, offset: Points) -> Points:
        """(3,) what the feature is moved by where this line is moved by an offset (3,)."""
        return offset * MIRROR if self.mirrored else offset


def list_shape_lines(shapes: ShapeModel, template: Template) -> tuple[ShapeLine, ...]:
    """List the features of a model's shapes, then their mirror images that are not themselves.

    template: the one that the shapes were laid with; raises InvalidFeatureError for another.
    """
    mirroring = Mirroring.of(template)
    if not np.array_equal(mirroring.quads, shapes.quads):
        raise InvalidFeatureError(
            f"the shape model's {len(shapes.quads)} quads are not those of the template "
            f"{template.name}; give the one that its shapes were laid with"
            + (f", {shapes.template}" if shapes.template else "")
        )
    twin = np.arange(len(mirroring.source))
    images = np.flatnonzero(mirroring.image)
    twin[images] = mirroring.source[images]
    twin[mirroring.source[images]] = images
    own: list[ShapeLine] = []
    mirrored: list[ShapeLine] = []
    for feature in shapes.features:
        vertices = np.asarray(feature.vertices, np.int64)
        part = int(template.of_part[mirroring.source[vertices[0]]])
        own.append(ShapeLine(feature.name, vertices, part, False))
        # One in the middle plane is its own image.
        image = twin[vertices]
        if not np.array_equal(image, vertices):
            mirrored.append(ShapeLine(feature.name, image, part, True))
    return (*own, *mirrored)


# What of a shape can be chosen, and taken back step by step.

#: How far sliders go, in standard deviations: 997 of 1000 normally distributed shapes are within.
SIGMAS = 3.0

#: What a held curve weighs, least and most: a thousandth, and a hundred times, what is pulled.
HOLD = (1e-3, 100.0)

#: What leaving the present shape costs, least and most: from what decides only where nothing
#: else does to what hardly moves.
STIFF = (1e-4, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class ShapeChoice:
    """All that can be taken back step by step.

    coefficients: (l,) of the shape. origin: how it came about. held: names of the features that
    pulls of others shall leave where they are. hold: the weight of those. stiffness: what it
    costs to leave the present shape; both as for :func:`patterndb_sketch.features.shapemodel.edit`.
    """

    coefficients: Floats
    origin: str
    held: frozenset[str] = frozenset()
    hold: float = 1.0
    stiffness: float = STIFFNESS

    def is_like(self, other: ShapeChoice) -> bool:
        """Is nothing different?"""
        return np.array_equal(self.coefficients, other.coefficients) and (
            self.held,
            self.hold,
            self.stiffness,
        ) == (other.held, other.hold, other.stiffness)


#: How the choice of a shape is kept in case of a crash: as it is.
SHAPE_SESSION: SessionFormat[ShapeChoice, ShapeChoice] = SessionFormat(
    "shape-model", InvalidFeatureError, ShapeChoice, lambda choice: choice, lambda choice, _: choice
)


@dataclass(frozen=True, slots=True, eq=False)
class Pulled:
    """The last pull.

    line: what was pulled. wanted: (n, 3) where its vertices should be. miss: the greatest
    distance from there.
    """

    line: ShapeLine
    wanted: Points = field(repr=False)
    miss: float


#: Pulls that miss by less than this share of the shape's size are fulfilled.
FULFILLED = 1e-4

#: A coefficient is at its limit within this many standard deviations: sliders are set by hand.
AT_LIMIT = 1e-6

Ghost = Literal["none", "mean", "known"]
GHOSTS: tuple[Ghost, ...] = ("none", "mean", "known")


class Shaping:
    """A shape model, and the shape of it that is shown.

    shapes: the model. lines: its features and their images, which can be pulled. template: the
    one that its shapes were laid with. coefficients: of the
    first shape; by default the mean. held: names of the curves that are
    held at first. message: what there is to say of the last thing done.

    Raises InvalidFeatureError if the template is another one, or for other coefficients than
    the model has.
    """

    def __init__(
        self,
        shapes: ShapeModel,
        template: Template,
        coefficients: ArrayLike | None = None,
        held: Collection[str] = (),
    ) -> None:
        self.shapes = shapes
        self.parts = tuple(part.name for part in template.parts)
        self.lines = list_shape_lines(shapes, template)
        first = np.zeros(shapes.n_modes) if coefficients is None else coefficients
        given = np.array(first, np.float64)
        self.points = shapes.shape(given)
        self.steps = History(ShapeChoice(given, self._origin(given), held=frozenset(held)))
        self.pulled: Pulled | None = None
        self.ghost: Ghost = "none"
        self.message = ""
        #: The training shape that was looked at last.
        self._known = self._number(given)
        self._seed = 0
        self._begun: ShapeChoice | None = None
        self._saved = self.choice

    # What is shown

    @property
    def choice(self) -> ShapeChoice:
        """All that can be taken back."""
        return self.steps.now

    @property
    def unsaved(self) -> bool:
        """Is the shape another than the one that was saved last, or than the first?"""
        return not np.array_equal(self.choice.coefficients, self._saved.coefficients)

    def mark_saved(self) -> None:
        """The shape was saved as it is."""
        self._saved = self.choice

    @property
    def size(self) -> float:
        """The diagonal of the box around the mean shape."""
        return float(np.linalg.norm(np.ptp(self.shapes.mean, axis=0)))

    @property
    def sigmas(self) -> Floats:
        """(l,) the coefficients in standard deviations."""
        return self.choice.coefficients / self.shapes.deviations

    @property
    def box(self) -> tuple[Floats, Floats]:
        """((l,), (l,)) the limits of pulls, in standard deviations."""
        low, high = self.shapes.box
        return low / self.shapes.deviations, high / self.shapes.deviations

    @property
    def limits(self) -> NDArray[np.int64]:
        """(l,) -1 or 1 where a coefficient is at its least or greatest, -2 or 2 where it is
        beyond, else 0."""
        low, high = self.box
        now = self.sigmas
        at = np.where(now >= high - AT_LIMIT, 1, np.where(now <= low + AT_LIMIT, -1, 0))
        return np.where((now > high + AT_LIMIT) | (now < low - AT_LIMIT), 2 * at, at)

    @property
    def nearest(self) -> tuple[str, float]:
        """The training shape that is nearest, and its root mean square distance of vertices."""
        apart = np.linalg.norm(self.shapes.coefficients - self.choice.coefficients, axis=1)
        k = int(apart.argmin())
        return self.shapes.names[k], float(apart[k] / np.sqrt(len(self.shapes.mean)))

    @property
    def ghost_name(self) -> str:
        """Which shape the ghost is of, "" if none is shown."""
        if self.ghost == "none":
            return ""
        return "mean" if self.ghost == "mean" else self.shapes.names[self._ghost_known()]

    def ghost_coefficients(self) -> Floats | None:
        """(l,) of the ghost, None if none is shown."""
        if self.ghost == "none":
            return None
        if self.ghost == "mean":
            return np.zeros(self.shapes.n_modes)
        return self.shapes.coefficients[self._ghost_known()]

    # What keys do

    def reset(self) -> None:
        """The mean shape."""
        self._show(np.zeros(self.shapes.n_modes), "mean")

    def sample(self) -> None:
        """Another random shape; the same ones come in the same order every time."""
        self._seed += 1
        self._show(self.shapes.sample(self._seed), f"random shape {self._seed}")

    def step(self, by: int) -> None:
        """The next training shape, or the one before, as the modes show it."""
        count = len(self.shapes.names)
        first = 0 if by > 0 else count - 1
        self._known = first if self._known is None else (self._known + by) % count
        self._show(self.shapes.coefficients[self._known], self.shapes.names[self._known])

    def nudge(self, mode: int, by: float) -> None:
        """Change a mode by so many standard deviations."""
        self.begin()
        self.set_mode(mode, float(self.sigmas[mode]) + by)
        self.finish()

    def next_ghost(self) -> None:
        """No ghost, the mean's, or that of the training shape that was looked at last; of the
        nearest if none was."""
        self.ghost = GHOSTS[(GHOSTS.index(self.ghost) + 1) % len(GHOSTS)]

    def toggle_held(self, name: str) -> None:
        """Hold a feature, or let it go."""
        held = self.choice.held ^ {name}
        self._commit(replace(self.choice, held=held))
        title = name.replace("_", " ")
        self.message = f"{title} is held" if name in held else f"{title} follows again"

    def take(self, choice: ShapeChoice) -> None:
        """Take a choice that was kept, as one step."""
        self._commit(choice)
        self.pulled = None

    def let_go(self) -> None:
        """Hold no feature."""
        if not self.choice.held:
            self.message = "no curve is held"
            return
        self._commit(replace(self.choice, held=frozenset()))

    def undo(self) -> None:
        """Take the last change back."""
        self._swap(self.steps.undo, "there is nothing to take back")

    def redo(self) -> None:
        """What was taken back last again."""
        self._swap(self.steps.redo, "nothing was taken back")

    # Changes that go on while something is dragged; each is one step to take back

    def begin(self) -> None:
        """Something is going to be dragged."""
        self._begun = self.choice
        self.message = ""

    def finish(self) -> None:
        """It was let go."""
        begun, self._begun = self._begun, None
        self.pulled = None
        if begun is not None and not begun.is_like(self.choice):
            self.steps.keep(begun)

    def drop(self) -> None:
        """It shall not have been dragged."""
        begun, self._begun = self._begun, None
        self.pulled = None
        if begun is not None:
            self._change(begun)

    def set_mode(self, mode: int, sigmas: float) -> None:
        """A mode, in standard deviations; no further than SIGMAS."""
        after = self.choice.coefficients.copy()
        after[mode] = np.clip(sigmas, -SIGMAS, SIGMAS) * self.shapes.deviations[mode]
        self._change(replace(self.choice, coefficients=after, origin=self._origin(after)))
        self.pulled = None
        beyond = abs(int(self.limits[mode])) > 1
        self.message = f"mode {mode + 1} is beyond the training shapes" if beyond else ""

    def set_hold(self, weight: float) -> None:
        """What held curves weigh in the next pulls."""
        self._change(replace(self.choice, hold=float(np.clip(weight, *HOLD))))

    def set_stiffness(self, stiffness: float) -> None:
        """What it costs the next pulls to leave the shape."""
        self._change(replace(self.choice, stiffness=float(np.clip(stiffness, *STIFF))))

    def pull(self, line: ShapeLine, offset: Points, vertex: int | None) -> bool:
        """Move a line from where it was when the drag began; False if no shape was found.

        offset: (3,). vertex: the place in the line of the one vertex that is pulled; by default
        the whole line is moved.
        """
        begun = self._begun
        assert begun is not None
        shapes, name = self.shapes, line.name
        start = np.clip(begun.coefficients, *shapes.box)
        held = {one: begun.hold for one in begun.held if one != name}
        try:
            targets = pull_feature(shapes, name, line.pull(offset), start=start, vertex=vertex)
            found = edit(shapes, targets, held=held, start=start, stiffness=begun.stiffness)
        except PatternDBError as error:
            self.message = str(error)
            return False
        self._change(replace(begun, coefficients=found.coefficients, origin="edited"))
        self.points = found.points
        wanted = targets[name]
        if line.mirrored:
            wanted = wanted * (1.0, -1.0, 1.0)
        self.pulled = Pulled(line, wanted, found.misses[name])
        self.message = self._told(line, found, begun, held)
        return True

    def _told(
        self, line: ShapeLine, found: ShapeEdit, begun: ShapeChoice, held: Mapping[str, float]
    ) -> str:
        """What the edit could not reach, "" if it could."""
        notes: list[str] = []
        miss = found.misses[line.name]
        if miss > FULFILLED * self.size:
            at = int(np.count_nonzero(found.at_bound))
            stopped = f"; {at} mode{'s' if at > 1 else ''} at the limit" if at else ""
            notes.append(f"{line.title}: short of the pull by up to {miss:.3g} units{stopped}")
        if held:
            start = self.shapes.shape(np.clip(begun.coefficients, *self.shapes.box))
            ways = {
                name: float(np.linalg.norm((found.points - start)[at], axis=1).max())
                for name, at in ((name, self.shapes.feature(name).vertices) for name in held)
            }
            name = max(ways, key=ways.__getitem__)
            if ways[name] > FULFILLED * self.size:
                notes.append(f"held {name.replace('_', ' ')} gave way by {ways[name]:.3g}")
        low, high = self.shapes.box
        if ((begun.coefficients < low) | (begun.coefficients > high)).any():
            notes.append("modes that were beyond the training shapes were drawn back to them")
        return ". ".join(notes)

    # How it is done

    def _ghost_known(self) -> int:
        if self._known is not None:
            return self._known
        return self.shapes.names.index(self.nearest[0])

    def _origin(self, coefficients: Floats) -> str:
        """What a shape is called that was not come by in one step."""
        if not coefficients.any():
            return "mean"
        known = self._number(coefficients)
        return "edited" if known is None else self.shapes.names[known]

    def _number(self, coefficients: Floats) -> int | None:
        """Which training shape has these coefficients."""
        same = np.flatnonzero((self.shapes.coefficients == coefficients).all(axis=1))
        return int(same[0]) if len(same) else None

    def _show(self, coefficients: Floats, origin: str) -> None:
        self._commit(replace(self.choice, coefficients=coefficients, origin=origin))
        self.pulled = None

    def _commit(self, after: ShapeChoice) -> None:
        """A change that is one step."""
        before = self.choice
        self._change(after)
        self.steps.keep(before)

    def _change(self, after: ShapeChoice) -> None:
        if after.coefficients is not self.choice.coefficients:
            self.points = self.shapes.shape(after.coefficients)
        self.steps.settle(after)

    def _swap(self, turn: Callable[[], bool], nothing: str) -> None:
        if not turn():
            self.message = nothing
            return
        self.points = self.shapes.shape(self.choice.coefficients)
        self.pulled = None
