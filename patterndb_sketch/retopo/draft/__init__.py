"""A first draft: a network for a whole surface, proposed by the machine, edited like any other.

The surface is remeshed evenly, a smooth cross field laid on it, and the field's separatrices traced
until they meet: they cut the surface into four-sided regions, which become patches with quads.

Read :mod:`.task` (the question) and :mod:`.settings` (what is tried, and what is good enough), then
the way from the surface to the quads: :mod:`.manifold` (what no field lies on), :mod:`.parts` (each
part by itself), :mod:`.proposing` (one part: the tries, and the steps of each), :mod:`.creases`,
:mod:`.fieldmesh` with its :mod:`.frames`, :mod:`.crossfield` (the field and its singularities),
:mod:`.seeds` (regular places that lines begin at, too), :mod:`.tracing` (lines), :mod:`.joints`
(where they begin and end), :mod:`.assembly` (lines as a network), :mod:`.layout` (all of these,
with counts and a price), :mod:`.fitting` with :mod:`.fixedcurves` (quads are fitted to the
surface) and :mod:`.judging`. :mod:`.refitting` fits what later edits fill again.
"""
