"""Feature curves of models of any quality: sketched, snapped, and registered to templates.

After the paper on a sketching interface for feature curve recovery of free-form surfaces.

Read model (triangles to ask), splines (B-splines through samples), initial (a stroke's first
curve), ribs (the model's outlines across it), fishbone (what pulls the curve along its ribs, and
the cut), snap (both together), strokes and drag (what users do), registration (templates of quads
laid on models along curves), shapemodel (statistics of registered shapes), sessionfile and
files (documents).
"""
