"""patterndb: a database of the patterns in hand-made quad meshes."""
