"""A first draft: a network for a whole surface, proposed by the machine, edited like any other.

The surface is remeshed evenly, a smooth cross field laid on it, and the field's separatrices traced
until they meet: they cut the surface into four-sided regions, which become patches. What stands
where:

Read :mod:`.proposing`, which is all of it, then its steps: :mod:`.remesh`, :mod:`.fieldmesh`,
:mod:`.crossfield` (the field and its singularities), :mod:`.tracing` (separatrices), :mod:`.arcs`
(those between singularities), :mod:`.walls` (borders and the seam of symmetry), :mod:`.assembly`
(lines as a network), :mod:`.fitting` (its quads are fitted to the surface) and :mod:`.judging`
(what is wrong with them, and refused). :mod:`.refitting` fits again what later edits fill anew.
"""
