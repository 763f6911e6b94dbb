"""Curve networks: curves that meet at nodes, from curves as they were drawn.

Read network (curves, nodes, cycles) and naming (cycles by the names of their curves); polylines
(curves as they come), meetings (where polylines meet), smoothcurves and crossings (where the curves
meet that samples stand for), survey (how exactly a drawing was made, and which meetings are meant),
duplicates and cuts (the nodes), joining (the network of it all); drawing (a network and what is
known of its making), normals (of the surface along curves).
"""
