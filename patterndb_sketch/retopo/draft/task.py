"""What is drafted, with what, how the draft is to be, and how much may be made in vain."""

from __future__ import annotations

from dataclasses import dataclass, field

from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.judging import MOST_OFF
from patterndb_sketch.retopo.draft.sharpedges import SharpRule
from patterndb_sketch.retopo.network import Network
from patterndb_sketch.retopo.sizes import Sizes
from patterndb_sketch.retopo.symmetry import Half
from query.engine import PatternSource

#: Edges of the mesh that the field is solved on, in target edges.
REMESHED = 0.4

#: Quads of drafts that came out unsound, or what takes as long, after which nothing else is tried:
#: a dozen seconds of work.
MOST_IN_VAIN = 6000

#: The same for the half of a symmetric surface: the whole is still to be tried then.
IN_VAIN_BY_HALVES = 2000


@dataclass(slots=True)
class DraftBudget:
    """How many quads of unsound drafts may yet be made, counted on the surface that is worked
    on."""

    left: float = MOST_IN_VAIN

    @property
    def spent(self) -> bool:
        return self.left <= 0

    def spend(self, quads: float) -> None:
        self.left -= quads


#: A draft of few quads may be this part of their edges off: at 300 quads a sphere is 2 % of its
#: diagonal off its own fills.
OFF_IN_EDGES = 0.4


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
            return MOST_OFF
        return max(MOST_OFF, OFF_IN_EDGES * self.quad / surface.diagonal)


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
