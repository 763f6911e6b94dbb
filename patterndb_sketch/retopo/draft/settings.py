"""The settings of drafts: what is tried, how much work may be in vain, and what is good enough.

:data:`SETTINGS` is the one table. Lengths are parts of the surface's diagonal or of the target
edge, as named; *work* is counted in quads of unsound drafts, or in what takes as long to make: 500
are about a second.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FieldSetting:
    """alignment: weight of the directions of curvature. merging: singularities of opposed indices
    nearer than this, in target edges, are cancelled. finer: edges are this many times as long as
    asked for, where those come too far off the surface."""

    alignment: float
    merging: float
    finer: float = 1.0


@dataclass(frozen=True, slots=True)
class DraftSettings:
    """Each setting with its meaning; :data:`SETTINGS` has the values that are used."""

    #: Fields that are tried in this order, until a draft is sound. Measured on four surfaces: where
    #: only pairs nearer than 3 edges are cancelled there are half as many irregular vertices again,
    #: where further ones than 4.5 are, those of legs go, whose quads are sheared then. With twice
    #: the alignment human_man has 45 irregular vertices instead of 54.
    fields: tuple[FieldSetting, ...] = (
        FieldSetting(0.003, 3.75),
        FieldSetting(0.003, 4.5),
        FieldSetting(0.006, 3.75),
        FieldSetting(0.01, 2.0),
        FieldSetting(0.003, 3.75, 0.8),
    )
    #: Fields that are laid out before the cheapest layout is filled and fitted.
    tried: int = 3
    #: Edge lengths that are tried in this order, in target edges: finer ones find their way round
    #: small features, coarser ones leave them out.
    edges: tuple[float, ...] = (1.0, 0.75, 1.3)
    #: Parts with no more than this share of the surface's area are small: they take the first sound
    #: draft, and try these edges, too, for quads around thin rims, as of buttons.
    small_part: float = 0.03
    small_part_edges: tuple[float, ...] = (0.5, 0.35)
    #: Of more parts all are drafted at once: each takes a tenth of a second by itself.
    most_parts: int = 100
    #: A part with a thin handle gets edges that close around it, unless it would have more quads
    #: than so many times those of the whole surface with edges as asked for.
    most_quads: float = 1.8
    #: Regular places from which lines are traced, too, where regions would be rings: a torus, whose
    #: field has no singularity, needs one.
    most_seeds: int = 12
    #: Places that are tried on a bare surface with a region that has no corners, as one that is a
    #: tube.
    bare_seeds: int = 3
    #: Places that leave the same region without corners, after which no other is tried.
    same_region: int = 3

    #: Work after which nothing else is tried: a dozen seconds; for the half of a symmetric surface,
    #: of which the whole is still to be tried; and with creases, which must not cost much more than
    #: the draft without them where they are noise.
    work: float = 6000.0
    work_on_half: float = 2000.0
    work_on_creases: float = 600.0
    #: Where a part is left open, the other parts have this work at least.
    work_left: float = 1500.0
    #: Triangles of a field, and edges of a line, that take as long to find as a quad to make.
    triangles_per_quad: float = 40.0
    line_edges_per_quad: float = 4.0

    #: A number of quads is met within this share, where rounds of scaling the edge come to it.
    count_share: float = 0.03
    scalings: int = 6
    #: Neighbourhoods in which the counts of the chosen layout are improved.
    searches: int = 4
    #: Lines are laid out as for no more than so many quads: more would divide finer, and no better.
    most_laid: int = 2500
    #: Least and greatest edges, in diagonals: they give a hundred thousand quads, or no shape.
    least_edge: float = 0.004
    most_edge: float = 0.15
    #: Edges of the mesh that the field is solved on, in target edges.
    field_edge: float = 0.4

    #: Greatest distance of a sound draft from its surface: this part of the diagonal, or this part
    #: of an edge if that is more. At 300 quads a sphere is 2 % of its diagonal off its own fills.
    most_off: float = 0.02
    most_off_edges: float = 0.4
    #: A draft with creases is nearly sound if no more quads are flipped than this share of its
    #: edges along creases, and it is off by no more than this part of the diagonal above the least:
    #: a machined body without its creases is worth less.
    few_flipped: float = 0.05
    little_off: float = 0.05
    #: A quad with a scaled Jacobian below this is poor.
    poor_quad: float = 0.3
    #: These weigh alike: irregular vertices in a thousand quads, poor quads in a thousand, and the
    #: standard deviation of lengths of edges in their mean.
    irregular_per_thousand: float = 20.0
    poor_per_thousand: float = 5.0
    uneven: float = 0.2
    #: Where a half has more poor quads in a thousand, the whole is tried, too. A plate with a hole
    #: has 13, and without symmetry 2; a koala has 7, and its symmetry is worth more than these.
    poor_half: float = 10.0
    #: A number of quads that is missed by more than this share is reported.
    near_count: float = 0.1


SETTINGS = DraftSettings()
