"""The definitions in plain Python: slow, short, and sharing nothing with the kernels.

A function here has the name of the kernel it is the reference of. Half-edges are as in
``patterndb.core.halfedge``: number ``4 * quad + edge``, twin -1 on the border; where quads are
missing from a complex it is a dictionary, else a list.
"""
