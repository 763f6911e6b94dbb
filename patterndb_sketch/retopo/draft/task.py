"""What is drafted, with what, how the draft is to be, and how much may be made in vain.

The command line reads the options of :class:`DraftRequest` here: what takes long to import is
imported where it is used.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from patterndb.system.requests import Request, option
from patterndb_sketch.retopo.draft.settings import SETTINGS
from patterndb_sketch.retopo.errors import InvalidRetopoError, RefusedError
from patterndb_sketch.retopo.sizes import EDGE

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from patterndb_sketch.retopo.draft.creases import SharpRule
    from patterndb_sketch.retopo.network import Network
    from patterndb_sketch.retopo.sizes import Sizes
    from patterndb_sketch.retopo.symmetry import Half
    from query.engine import PatternSource


class DraftRequest(Request, frozen=True, kw_only=True):
    """How a surface is to be drafted: the tool ``draft``, and ``patterndb retopo --draft``.

    Raises InvalidRetopoError for an invalid value, RefusedError for options that contradict each
    other.
    """

    error = InvalidRetopoError

    edge: Annotated[
        Annotated[float, Meta(gt=0)] | None,
        option(
            "Target length of the quads' edges, in the surface's unit.",
            metavar="LENGTH",
            hint="give a length above 0, or None",
            section="draft",
            default=f"{100.0 * EDGE:g} % of the diagonal",
        ),
    ] = None
    quads: Annotated[
        Annotated[int, Meta(ge=20, le=200_000)] | None,
        option(
            "About how many quads, instead of a length of edges.",
            metavar="N",
            hint="give a whole number from 20 to 200,000, or None",
            section="draft",
        ),
    ] = None
    sharp: Annotated[
        Literal["auto", "none"] | Annotated[float, Meta(ge=1, le=179)],
        option(
            "Keep sharp edges: those that stand out, all whose triangles meet at more than ANGLE "
            "degrees, or none.",
            metavar="auto|ANGLE|none",
            hint="give auto, none, or an angle from 1 to 179 degrees",
            section="draft",
        ),
    ] = "auto"
    symmetry: Annotated[
        bool,
        option(
            "Work on one half of a surface that is symmetric.",
            flag="--symmetry/--no-symmetry",
            hint="give True or False",
            section="draft",
        ),
    ] = True
    strict: Annotated[
        bool,
        option(
            "Refuse all where a part cannot be drafted well.",
            hint="give True or False",
            section="draft",
        ),
    ] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.edge is not None and self.quads is not None:
            raise RefusedError("edge and quads both say how fine a draft is; give one of them")


@dataclass(slots=True)
class DraftBudget:
    """How many quads of unsound drafts may yet be made, counted on the surface that is worked
    on."""

    left: float = SETTINGS.work

    @property
    def spent(self) -> bool:
        return self.left <= 0

    def spend(self, quads: float) -> None:
        self.left -= quads


@dataclass(frozen=True, slots=True)
class DraftGoal:
    """What a draft is to be like.

    quad: the edge length that the wanted number of quads gives, in the surface's unit; None if no
    number is wanted, and edges are as long as the sizes have them.
    sharp: which edges are creases that are kept; None for none of them.
    closed: are creases with an open end left out?
    strict: are creases given up where the draft with them would be only nearly sound?
    """

    quad: float | None = None
    sharp: SharpRule | None = None
    closed: bool = False
    strict: bool = False

    def count_quads(self, surface: Surface) -> float | None:
        """Return how many quads a surface is to have, None if no number is wanted."""
        return None if self.quad is None else float(surface.areas.sum()) / self.quad**2

    def allow_off(self, surface: Surface) -> float:
        """Return how far off a surface quads may be, in its diagonals."""
        if self.quad is None:
            return SETTINGS.most_off
        return max(SETTINGS.most_off, SETTINGS.most_off_edges * self.quad / surface.diagonal)


@dataclass(frozen=True, slots=True, eq=False)
class DraftTask:
    """What is drafted, and with what.

    network: borders, the seam of symmetry and curves that are drawn, along which the field runs and
    on which lines end; what patches cover stays as it is.
    half: that the surface is of a symmetric surface, if it is one: quads are fitted to both sides,
    and reports are about both.
    budget: when it is spent, no other setting is tried.
    """

    network: Network
    surface: Surface
    sizes: Sizes
    source: PatternSource
    half: Half | None = None
    goal: DraftGoal = DraftGoal()
    budget: DraftBudget = field(default_factory=DraftBudget)
