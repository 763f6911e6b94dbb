"""Polylines as drawn: a line "v N", then N lines "x y z", again and again."""

from __future__ import annotations

from patterndb.geometry.points import Points
from patterndb_sketch.surfacing.drawing import Drawing
from patterndb_sketch.surfacing.files.words import Words
from patterndb_sketch.surfacing.joining.junctions import join_polylines
from patterndb_sketch.surfacing.joining.polylines import as_curve


def polylines_drawing(words: Words, tolerance: float | None = None) -> Drawing:
    """The drawing whose strokes are the polylines, each named by its place in the file.

    tolerance: how far apart strokes may pass and still meet. They were drawn in their order:
    each is a stage. Raises InvalidNetworkError that names the line or the stroke.
    """
    polylines: list[Points] = []
    while words.left:
        name = f"stroke {len(polylines)}"
        if words.word("a polyline") != "v":
            words.fail('a polyline begins with "v" and the number of its points')
        count = words.count("the number of points", 2, words_each=3)
        polylines.append(as_curve(words.points(count, name), name))
    found = join_polylines(polylines, tolerance=tolerance)
    stages = tuple(tuple(dict.fromkeys(curve for curve, _ in walk)) for walk in found.walks)
    return Drawing(found.network, stages, found.notes)
