"""Growth by whole sides: the *side* and *convex* modes of enumeration.

From every quad, all quads beyond one whole side of the patch are added at once, again and
again; in the convex mode the quads around reflex corners follow until none is left. Patches
are reached along many ways, so those met are remembered by a hash of their quads, and the
search goes depth-first: a patch is grown on from the state it was reached in.

Source: Marcias et al. 2015, section 3.2 ("Patch enumeration", "Managing duplicates").
Differs from the paper: it hashes the boundary vertices, which on a closed mesh cannot tell a
patch from its complement; here the quads are hashed.
"""

from __future__ import annotations
