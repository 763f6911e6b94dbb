"""What holds where nothing else is asked for: the library and its verbs' options read it here.

No more than numbers, so that --help need not wait for what uses them.
"""

from __future__ import annotations

#: Directions by their names.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

#: Of curves (:class:`patterndb_sketch.features.snap.SnapSettings`): bends or normals, what normals
#: are measured from, at which angle in degrees, and how stiff curves are.
ALPHA, AXIS, BETA, STIFFNESS = 1.0, "z", 90.0, 1.0

#: Degree of splines; how often ribs are built about a curve.
DEGREE, SNAP_ROUNDS = 3, 3

#: Reach of ribs to either side, as a share of the model's diagonal. The paper has "a predefined
#: radius"; curves move by a few percent when they snap.
RADIUS = 0.05

#: Of registration: how many of its shortest edges a vertex may go from the membrane (the paper
#: found 1 to 3 best), and rounds of mapping, each from the surface of the one before.
DELTA, MAPPING_ROUNDS = 2.0, 1
