"""Growing patterns: glue a strip of quads onto a pattern's boundary, reduce, and go on.

Peeling the strip off a side between two convex corners turns interior vertices of valence 3
into convex corners and those of valence 5 into reflex ones: the number of irregular and
reflex vertices never grows. So from one quad, strips glued back reach every pattern with few
of them, whoever made it. A strip may end between two quads of one polychord, so polychords are
made wider first. There is no proof that none is missed; the tests hold the result against
patterns found otherwise.

Source: own. The definitions are those of Marcias et al. 2015, section 3.
"""

from __future__ import annotations

#: How a strip may lie: from one boundary vertex to another (or once round to itself),
#: all round, or all round with a corner quad of its own.
OPEN, RING, CORNER_RING = 0, 1, 2


#: Widest that polychords are made before a strip is glued on. A strip may end between two
#: quads of one polychord at either end of it, hence three wide.
WIDEST = 3
