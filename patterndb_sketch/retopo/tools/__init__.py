"""The tools of retopology, a module each: from a network, and what the user did, to an edit of it.

A tool's module has functions that work on a network alone, and at its end its entry for the table,
a :class:`~patterndb_sketch.retopo.tool.Tool`; :mod:`patterndb_sketch.retopo.table` finds it there.
A tool that cannot do what it was asked for raises RefusedError; the network is never half changed.

Draw: stroke, loop, spine (a patch about a stroke), cylinder (patches between loops),
autocomplete with suggestions. Mend: erase, knot, corner, patch, pull, smooth, redraw, align. Quads:
counts, fill, insertloop, movepair, brush. Symmetry: symmetry. What several use: planar and closing
(patches planned in a plane), course (chains that moved), joining (nodes that meet), salience.
"""
