"""Defaults of how loops are cut along chords; nothing else is imported for them."""

from __future__ import annotations

import math
from typing import Literal

#: How much a cut weighs against the flatness it gains (Abbasinejad et al. 2013, section 3.2: 0.1
#: for all models but the front of the roadster, 0.6).
ALPHA = 0.1

#: A chord may add this much area, as a share of the loop's least, for each unit of box that it
#: takes away. Chosen with the shapes of benchmarks/surfacing in view: 0.3 to 0.4 serve them alike,
#: below 0.294 their gable roof loses its ridge.
AREA_PRICE = 1.0 / 3.0

#: A smooth stretch that turns by more than this gets an end inside, in radians: 45 degrees. The
#: paper bounds the turning without saying by what. The bend of an eighth of a circle rises 1/10
#: of its chord above it, little enough for one nearly flat piece.
TURNING_BOUND = math.radians(45)

#: The most sub-problems solved for one cycle: some 0.1 s. The paper's largest has 12,319.
MAX_SUBPROBLEMS = 200_000

#: How far from flat a piece of a cycle is, S(K): 0 for a planar piece, the larger the less flat.
#: "relative": sqrt(det Cov(piece) / det Cov(whole)), without unit: 1 for the whole cycle.
#: "printed": det Cov(piece), the product of the variances along the principal axes, in units of
#: length**6. Of a planar whole cycle every piece has 0.
#:
#: Source: Abbasinejad et al. 2013, section 3.2. Differs from the paper: the printed form depends on
#: the unit of length, so that at unit size alpha = 0.1 cuts nothing; hence the relative form, which
#: is the ratio of the volumes of the two boxes.
Flatness = Literal["relative", "printed"]
