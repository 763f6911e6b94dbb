"""A strip of triangles rerouted round vertices until its shortest path is shortest all round."""

from __future__ import annotations

import math

import numpy as np

from patterndb.core.halfedge import Index, Int32Array
from patterndb.geometry.points import Floats, Points
from patterndb.system.kernels import kernel


@kernel
def unfold_strip(
    vertices: Points,
    triangles: Int32Array,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[Int32Array, Points, Points]:
    """The gates between the triangles of a strip, in one plane.

    out, into (n,): the sides by which one triangle is left and the next entered, n >= 1;
    start, end: (3,) barycentric weights of points in the first and last triangle.

    Returns the vertices at the left and right of the gates (n + 2, 2), their places
    (n + 2, 2, 2), and those of start and end (2, 2). Rows 0 and n + 1 are no gates: both sides
    are the corner of the first and last triangle that is at none.
    """
    n = len(out)
    gate = np.empty((n + 2, 2), np.int32)
    flat = np.empty((n + 2, 2, 2))
    ends = np.zeros((2, 2))
    f, e = out[0] // 3, out[0] % 3
    right, left, third = triangles[f, e], triangles[f, (e + 1) % 3], triangles[f, (e + 2) % 3]
    length = _apart(vertices, right, left)
    x, y = _beyond(vertices, right, left, third)
    gate[1, 0], gate[1, 1] = left, right
    flat[1, 0, 0], flat[1, 0, 1] = length, 0.0
    flat[1, 1, 0], flat[1, 1, 1] = 0.0, 0.0
    # What is ahead lies at negative heights.
    gate[0, 0] = gate[0, 1] = third
    flat[0, :, 0], flat[0, :, 1] = x, y
    ends[0, 0] = start[(e + 1) % 3] * length + start[(e + 2) % 3] * x
    ends[0, 1] = start[(e + 2) % 3] * y
    for i in range(n):
        f, e = into[i] // 3, into[i] % 3
        third = triangles[f, (e + 2) % 3]
        left, right = gate[i + 1, 0], gate[i + 1, 1]
        x, y = _beyond(vertices, right, left, third)
        px, py = flat[i + 1, 1, 0], flat[i + 1, 1, 1]
        ux, uy = flat[i + 1, 0, 0] - px, flat[i + 1, 0, 1] - py
        size = math.sqrt(ux * ux + uy * uy)
        ux, uy = ux / size, uy / size
        sx, sy = px + x * ux + y * uy, py + x * uy - y * ux
        if i + 1 == n:
            gate[n + 1, 0] = gate[n + 1, 1] = third
            flat[n + 1, :, 0], flat[n + 1, :, 1] = sx, sy
            for c in range(3):
                v = triangles[f, c]
                if v == third:
                    tx, ty = sx, sy
                elif v == left:
                    tx, ty = flat[n, 0, 0], flat[n, 0, 1]
                else:
                    tx, ty = flat[n, 1, 0], flat[n, 1, 1]
                ends[1, 0] += end[c] * tx
                ends[1, 1] += end[c] * ty
            break
        e = out[i + 1] % 3
        keeps_left = triangles[f, e] == left or triangles[f, (e + 1) % 3] == left
        changed = 1 if keeps_left else 0
        gate[i + 2] = gate[i + 1]
        flat[i + 2] = flat[i + 1]
        gate[i + 2, changed] = third
        flat[i + 2, changed, 0], flat[i + 2, changed, 1] = sx, sy
    return gate, flat, ends


@kernel
def _apart(vertices: Points, a: Index, b: Index) -> float:
    total = 0.0
    for c in range(3):
        total += (vertices[b, c] - vertices[a, c]) ** 2
    return math.sqrt(total)


@kernel
def _beyond(vertices: Points, a: Index, b: Index, c: Index) -> tuple[float, float]:
    """How far c lies along the edge from a to b, and how far beside it."""
    length = _apart(vertices, a, b)
    ux, uy, uz = (
        (vertices[b, 0] - vertices[a, 0]) / length,
        (vertices[b, 1] - vertices[a, 1]) / length,
        (vertices[b, 2] - vertices[a, 2]) / length,
    )
    x = vertices[c, 0] - vertices[a, 0]
    y = vertices[c, 1] - vertices[a, 1]
    z = vertices[c, 2] - vertices[a, 2]
    along = x * ux + y * uy + z * uz
    x, y, z = x - along * ux, y - along * uy, z - along * uz
    return along, math.sqrt(x * x + y * y + z * z)


@kernel
def _turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the area of a, b, c: above 0 if c is left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@kernel
def pull_tight(
    gate: Int32Array, flat: Points, ends: Points
) -> tuple[Int32Array, Int32Array, float]:
    """Where the shortest path through the gates of :func:`unfold_strip` turns: (m,) numbers of
    gates, counted from 0, and (m,) their sides, 0 left and 1 right; and the path's length.

    Source: Lee and Preparata 1984; the funnel is opened anew behind every turn.
    """
    n = len(gate) - 2
    numbers = np.empty(n, np.int32)
    which = np.empty(n, np.int32)
    m = 0
    length = 0.0
    apex = ends[0].copy()
    first = 0
    while first < n:
        bounds = flat[first + 1].copy()
        at = np.array([first, first])
        turned = -1
        for j in range(first + 1, n + 1):
            for s in range(2):
                sign = 1.0 if s == 0 else -1.0
                target = flat[j + 1, s] if j < n else ends[1]
                if sign * _turn(apex, bounds[s], target) > 0.0:
                    continue
                if sign * _turn(apex, bounds[1 - s], target) < 0.0:
                    turned = 1 - s
                    break
                bounds[s] = target
                at[s] = j
            if turned >= 0:
                break
        if turned < 0:
            break
        length += math.hypot(bounds[turned, 0] - apex[0], bounds[turned, 1] - apex[1])
        apex[:] = bounds[turned]
        numbers[m] = at[turned]
        which[m] = turned
        # The gates that end in the turn are over with it.
        first = at[turned] + 1
        while first < n and gate[first + 1, turned] == gate[at[turned] + 1, turned]:
            first += 1
        m += 1
    length += math.hypot(ends[1, 0] - apex[0], ends[1, 1] - apex[1])
    return numbers[:m].copy(), which[:m].copy(), length


#: A path that turns at a vertex by less than this angle, in radians, stays there: rerouting
#: would shorten it by the square of it at most.
STRAIGHT = 1e-8

#: A point with a smaller barycentric weight than this lies on the opposite edge.
ON_EDGE = 1e-12

#: Rounds that do not shorten the path before it counts as shortest.
PATIENCE = 4


@kernel
def shorten_strip(
    vertices: Points,
    triangles: Int32Array,
    across: Int32Array,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[int, Int32Array, Int32Array, Floats, Floats]:
    """The strip whose shortest path is shorter than all near it: its first triangle, its sides
    out and into, (n,) each, and the weights (3,) of its ends; it may be of no gates.

    Every round pulls the path tight and looks at each vertex where it turns: if the angle on
    the side away from the strip is less than a straight one, the strip goes round there.
    """
    first = out[0] // 3
    seen = np.full(len(triangles), -1, np.int32)
    best = np.inf
    waited = 0
    best_out, best_into, best_start, best_end = out, into, start, end
    while True:
        out, into = _remove_loops(out, into, seen)
        first, out, into, start, end = _trim_ends(triangles, first, out, into, start, end)
        if len(out) == 0:
            return first, out, into, start, end
        gate, flat, ends = unfold_strip(vertices, triangles, out, into, start, end)
        numbers, which, length = pull_tight(gate, flat, ends)
        if length < best * (1.0 - 1e-15):
            best = length
            waited = 0
            best_out, best_into, best_start, best_end = out, into, start, end
        else:
            waited += 1
            if waited > PATIENCE:
                break
        rerouted, out, into = _reroute(
            vertices, triangles, across, out, into, gate, flat, ends, numbers, which
        )
        if not rerouted:
            break
    return best_out[0] // 3, best_out, best_into, best_start, best_end


@kernel
def _remove_loops(
    out: Int32Array, into: Int32Array, seen: Int32Array
) -> tuple[Int32Array, Int32Array]:
    """The strip without what lies between two passes through one triangle.

    seen: (t,) all -1, and so again afterwards.
    """
    n = len(out)
    kept_out = np.empty(n, np.int32)
    kept_into = np.empty(n, np.int32)
    m = 0
    if n:
        seen[out[0] // 3] = 0
    for i in range(n):
        kept_out[m] = out[i]
        kept_into[m] = into[i]
        m += 1
        f = into[i] // 3
        if seen[f] >= 0:
            for k in range(seen[f], m - 1):
                seen[kept_into[k] // 3] = -1
            m = seen[f]
        seen[f] = m
    if n:
        seen[out[0] // 3] = -1
    for k in range(m):
        seen[kept_into[k] // 3] = -1
    return kept_out[:m].copy(), kept_into[:m].copy()


@kernel
def _trim_ends(
    triangles: Int32Array,
    first: Index,
    out: Int32Array,
    into: Int32Array,
    start: Floats,
    end: Floats,
) -> tuple[int, Int32Array, Int32Array, Floats, Floats]:
    """The strip without triangles at its ends that the path only touches: the point lies on
    the side by which they are left or entered. With the strip's first triangle, before and
    after."""
    low = 0
    high = len(out)
    while low < high and start[(out[low] % 3 + 2) % 3] <= ON_EDGE:
        start = _carry_weights(triangles, out[low], into[low], start)
        first = into[low] // 3
        low += 1
    while low < high and end[(into[high - 1] % 3 + 2) % 3] <= ON_EDGE:
        end = _carry_weights(triangles, into[high - 1], out[high - 1], end)
        high -= 1
    return first, out[low:high].copy(), into[low:high].copy(), start, end


@kernel
def _carry_weights(triangles: Int32Array, side: Index, other: Index, weights: Floats) -> Floats:
    """Weights in the triangle of the side ``other`` of a point on ``side``, the same edge."""
    result = np.zeros(3)
    for e in range(3):
        for k in range(2):
            corner = (other % 3 + k) % 3
            if triangles[side // 3, e] == triangles[other // 3, corner]:
                result[corner] = weights[e]
    return result / result.sum()


@kernel
def _angle(at: Floats, a: Floats, b: Floats) -> float:
    """The angle at a place between two others, in 0..pi."""
    ux, uy = a[0] - at[0], a[1] - at[1]
    vx, vy = b[0] - at[0], b[1] - at[1]
    return math.atan2(abs(ux * vy - uy * vx), ux * vx + uy * vy)


@kernel
def _corner_angle(vertices: Points, triangles: Int32Array, f: Index, e: Index) -> float:
    """The angle of triangle f at its corner e."""
    at, a, b = triangles[f, e], triangles[f, (e + 1) % 3], triangles[f, (e + 2) % 3]
    ux, uy, uz = (
        vertices[a, 0] - vertices[at, 0],
        vertices[a, 1] - vertices[at, 1],
        vertices[a, 2] - vertices[at, 2],
    )
    vx, vy, vz = (
        vertices[b, 0] - vertices[at, 0],
        vertices[b, 1] - vertices[at, 1],
        vertices[b, 2] - vertices[at, 2],
    )
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return math.atan2(math.sqrt(x * x + y * y + z * z), ux * vx + uy * vy + uz * vz)


@kernel
def _other_side(triangles: Int32Array, side: Index, v: Index) -> int:
    """The other of the two sides at vertex v of the triangle of a side at v."""
    f, e = side // 3, side % 3
    # A side that begins at v is preceded by one that ends there, and the other way about.
    return 3 * f + (e + 2) % 3 if triangles[f, e] == v else 3 * f + (e + 1) % 3


@kernel
def _reroute(
    vertices: Points,
    triangles: Int32Array,
    across: Int32Array,
    out: Int32Array,
    into: Int32Array,
    gate: Int32Array,
    flat: Points,
    ends: Points,
    numbers: Int32Array,
    which: Int32Array,
) -> tuple[bool, Int32Array, Int32Array]:
    """The strip led round the other side of the vertices where that is shorter; was it any?

    Of turns whose fans share more than a triangle only the first is taken.
    """
    n = len(out)
    new_out = np.empty(2 * n + 64, np.int32)
    new_into = np.empty(2 * n + 64, np.int32)
    m = 0
    copied = 0
    for k in range(len(numbers)):
        s = which[k]
        v = gate[numbers[k] + 1, s]
        at = flat[numbers[k] + 1, s]
        i = numbers[k]
        while i > 0 and gate[i, s] == v:
            i -= 1
        j = numbers[k] + 1
        while j < n and gate[j + 1, s] == v:
            j += 1
        if i < copied:
            continue
        # Row i + 1 is gate i: row i, and behind the fan row j + 1, hold its outer corners.
        came = ends[0] if k == 0 else flat[numbers[k - 1] + 1, which[k - 1]]
        goes = ends[1] if k + 1 == len(numbers) else flat[numbers[k + 1] + 1, which[k + 1]]
        room = math.pi - STRAIGHT
        room -= _angle(at, came, flat[i, s]) + _angle(at, goes, flat[j + 1, s])
        final = into[j - 1] // 3
        side = _other_side(triangles, out[i], v)
        entered = across[side]
        count = 1
        while room > 0.0 and entered >= 0 and entered // 3 != final:
            f = entered // 3
            e = entered % 3
            if triangles[f, e] != v:
                e = (e + 1) % 3
            room -= _corner_angle(vertices, triangles, f, e)
            entered = across[_other_side(triangles, entered, v)]
            count += 1
        if room <= 0.0 or entered < 0:
            continue
        needed = m + (i - copied) + count + n
        if needed > len(new_out):
            more_out = np.empty(2 * needed, np.int32)
            more_into = np.empty(2 * needed, np.int32)
            more_out[:m] = new_out[:m]
            more_into[:m] = new_into[:m]
            new_out, new_into = more_out, more_into
        for g in range(copied, i):
            new_out[m] = out[g]
            new_into[m] = into[g]
            m += 1
        for _ in range(count):
            new_out[m] = side
            new_into[m] = across[side]
            side = _other_side(triangles, across[side], v)
            m += 1
        copied = j
    for g in range(copied, n):
        new_out[m] = out[g]
        new_into[m] = into[g]
        m += 1
    return copied > 0, new_out[:m].copy(), new_into[:m].copy()


@kernel
def cross_gates(
    vertices: Points,
    gate: Int32Array,
    flat: Points,
    ends: Points,
    numbers: Int32Array,
    which: Int32Array,
) -> Points:
    """(n, 3) where the path that turns at these gates passes each of the n."""
    n = len(gate) - 2
    points = np.empty((n, 3))
    k = 0
    came = ends[0]
    came_vertex = -1
    for i in range(n):
        while k < len(numbers) and numbers[k] < i:
            came = flat[numbers[k] + 1, which[k]]
            came_vertex = gate[numbers[k] + 1, which[k]]
            k += 1
        goes = ends[1]
        goes_vertex = -1
        if k < len(numbers):
            goes = flat[numbers[k] + 1, which[k]]
            goes_vertex = gate[numbers[k] + 1, which[k]]
        left, right = gate[i + 1, 0], gate[i + 1, 1]
        if left in (came_vertex, goes_vertex):
            t = 0.0
        elif right in (came_vertex, goes_vertex):
            t = 1.0
        else:
            a, b = flat[i + 1, 0], flat[i + 1, 1]
            dx, dy = goes[0] - came[0], goes[1] - came[1]
            over = (b[0] - a[0]) * dy - (b[1] - a[1]) * dx
            t = (came[0] - a[0]) * dy - (came[1] - a[1]) * dx
            t = min(max(t / over, 0.0), 1.0) if over != 0.0 else 0.5
        for c in range(3):
            points[i, c] = (1.0 - t) * vertices[left, c] + t * vertices[right, c]
    return points
