"""A first draft: a network for a whole surface, proposed by the machine, edited like any other.

The surface is remeshed evenly, a smooth cross field laid on it, and the field's separatrices traced
until they meet: they cut the surface into four-sided regions, which become patches. What stands
where:

Read :mod:`.task` (what is asked for) and :mod:`.proposing`, which is all of it, then its steps:
:mod:`.checking` (surfaces that are refused), :mod:`.remesh`, :mod:`.frames`, :mod:`.creases`,
:mod:`.crossfield` (the field and its singularities), :mod:`.layout` (all lines of a field),
:mod:`.seeds` (further places that lines begin at), :mod:`.tracing` (separatrices), :mod:`.arcs`
(those between singularities), :mod:`.walls` (borders and the seam of symmetry), :mod:`.assembly`
(lines as a network), :mod:`.drafted` (counts and the price of a layout), :mod:`.fitting` (its quads
are fitted to the surface) and :mod:`.judging` (what is wrong with them). :mod:`.byparts` drafts
part by part, and :mod:`.refitting` fits what later edits fill again.
"""
