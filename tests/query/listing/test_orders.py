"""Every order of the table: the same fills as any other, by its own key, every time alike."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import query
from query import Boundary, Fill, Stroke
from query.errors import InvalidQueryError
from query.listing.orders import EQUALLY_NEAR, ORDERS, FillOrder, describe_orders
from query.placing import lay_flat, measure_flow_distance, quality
from query.placing.strands import count_edges_off
from query.recognition import count_symmetries
from tests.support.query.cases import Source, code_of, polygon

#: What an order without a measure sorts by, as far as a fill tells; the order "artist" goes by
#: what a database has seen, see tests/query/listing/test_stream.py.
RANKED: dict[str, Callable[[Fill], float]] = {
    "artist": lambda fill: 0.0,
    "regular": lambda fill: float(fill.n_irregular),
}

#: More fills than the boundary below has.
ALL = 10_000

BOUNDARY = polygon((4, 3, 5, 4, 4))


def drawn_stroke(boundary: Boundary) -> Stroke:
    """A bent stroke from the first side to the third."""
    points = boundary.points
    assert points is not None
    start = points[1] * 0.5 + points[2] * 0.5
    end = points[11] * 0.5 + points[12] * 0.5
    return Stroke.drawn(boundary, [start, (start + end) / 2 + [0.1, 0, 0], end])


def key_of(order: FillOrder, fill: Fill, stroke: Stroke) -> tuple[bool, float]:
    """What the order sorts by: exact strokes before near ones, unless it measures how near."""
    if order.measure is None:
        value = RANKED[order.name](fill)
    else:
        value = order.measure(fill, BOUNDARY, [stroke], 1)[0]
    return not order.needs_strokes and count_edges_off(fill, [stroke], 1) != 0, value


def sort_fills(order: FillOrder, fills: list[Fill], stroke: Stroke) -> list[Fill]:
    """By the order's key; of what is alike, the more regular first."""
    alike = 0.0 if order.alike is None else order.alike(BOUNDARY, [stroke])
    left = sorted(fills, key=lambda fill: key_of(order, fill, stroke))
    result: list[Fill] = []
    while order.alike is not None and left:
        least = key_of(order, left[0], stroke)[1]
        group = [fill for fill in left if key_of(order, fill, stroke)[1] <= least + alike]
        result += sorted(group, key=lambda fill: (fill.n_irregular, fill.n_irregular_boundary))
        left = left[len(group) :]
    return result + left


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_every_order_is_in_order(order: FillOrder) -> None:
    stroke = drawn_stroke(BOUNDARY)
    found = list(
        query.fills(Source(), BOUNDARY, strokes=[stroke], order=order.name, limit=60, pool=ALL)
    )
    assert len(found) > 10
    assert [*map(id, found)] == [*map(id, sort_fills(order, found, stroke))]
    assert all(count_edges_off(fill, [stroke], 1) is not None for fill in found)


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_every_order_has_the_same_fills_and_is_stable(order: FillOrder) -> None:
    """Fills that are equal by the key stand as the order "artist" has them."""
    stroke = drawn_stroke(BOUNDARY)

    def ask(name: str) -> list[Fill]:
        return list(
            query.fills(
                Source(),
                BOUNDARY,
                strokes=[stroke],
                order=name,
                limit=None,
                pool=ALL,
                max_irregular=5,
                origins=("learned", "family"),
            )
        )

    found = [code_of(fill) for fill in ask(order.name)]
    assert found == [code_of(fill) for fill in ask(order.name)]
    pool = ask("artist")
    assert set(found) == {code_of(fill) for fill in pool}
    assert 10 < len(found) == len(pool) < ALL
    if order.measure is not None:
        assert found == [code_of(fill) for fill in sort_fills(order, pool, stroke)]


def test_of_strands_equally_near_the_more_regular_come_first() -> None:
    """In the order "flow", beginning with the nearest and all that are as near to the eye."""
    stroke = drawn_stroke(BOUNDARY)
    found = list(query.fills(Source(), BOUNDARY, strokes=[stroke], order="flow", limit=200))
    points, line = BOUNDARY.points, stroke.points
    assert points is not None and line is not None
    edge = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).mean()
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    distances = [measure_flow_distance(f, lay_flat(f, points), [stroke]) for f in found]
    assert distances != sorted(distances)
    groups = np.array(distances) - min(distances) <= EQUALLY_NEAR * edge * length
    first = int(groups.sum())
    assert first > 1 and groups[:first].all()
    irregular = [fill.n_irregular for fill in found[:first]]
    assert irregular == sorted(irregular)


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_every_order_is_refused_without_what_it_needs(order: FillOrder) -> None:
    lengths = (4, 4, 4, 4)
    if not order.needs_points:
        assert next(query.fills(Source(), lengths, order=order.name, pool=1), None) is not None
        return
    with pytest.raises(InvalidQueryError, match=f'"{order.name}" needs {order.needs}'):
        query.fills(Source(), lengths, order=order.name)


def test_what_is_no_order_is_told_which_there_are() -> None:
    with pytest.raises(InvalidQueryError) as refusal:
        query.fills(Source(), (4, 4, 4, 4), order="best")
    assert all(name in str(refusal.value) for name in ORDERS)
    assert all(order.first in describe_orders() for order in ORDERS.values())


def test_the_measures_are_what_the_orders_say() -> None:
    stroke = drawn_stroke(BOUNDARY)
    keys: dict[str, set[float]] = {name: set() for name in ORDERS}
    for fill in query.fills(Source(), BOUNDARY, strokes=[stroke], limit=40, order="regular"):
        assert BOUNDARY.points is not None
        vertices = lay_flat(fill, BOUNDARY.points)
        expected = {
            "flow": measure_flow_distance(fill, vertices, [stroke]),
            "quality": quality(fill.quads, vertices),
            "small": float(fill.n_quads),
            "symmetric": -float(count_symmetries(fill, BOUNDARY)),
        }
        assert fill.flow_distance == count_edges_off(fill, [stroke], 1)
        for name, value in expected.items():
            measure = ORDERS[name].measure
            assert measure is not None
            measured, told = measure(fill, BOUNDARY, [stroke], 1)
            assert measured == pytest.approx(value)
            keys[name].add(measured)
            assert told.flow_distance == (measured if name == "flow" else fill.flow_distance)
    assert all(len(keys[name]) > 1 for name in ("flow", "quality", "small"))
