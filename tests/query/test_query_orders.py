"""Every order of the table: the same fills as any other, by its own key, every time alike."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from query_cases import Source, code_of, polygon

import query
from query import Boundary, Fill, Stroke
from query.errors import InvalidQueryError
from query.identity import count_symmetries
from query.listing.orders import ORDERS, FillOrder, describe_orders
from query.placing import lay_flat, measure_flow_distance, quality
from query.placing.strands import count_edges_off

#: What an order without a measure sorts by, as far as a fill tells; the order "artist" goes by
#: what a database has seen, see tests/query/test_query_stream.py.
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


def key_of(order: FillOrder, fill: Fill, stroke: Stroke) -> float:
    """What the order sorts by."""
    if order.measure is None:
        return RANKED[order.name](fill)
    return order.measure(fill, BOUNDARY, [stroke], 1)[0]


@pytest.mark.parametrize("order", ORDERS.values(), ids=ORDERS)
def test_every_order_is_in_order(order: FillOrder) -> None:
    stroke = drawn_stroke(BOUNDARY)
    found = list(
        query.fills(Source(), BOUNDARY, strokes=[stroke], order=order.name, limit=60, pool=ALL)
    )
    assert len(found) > 10
    keys = [key_of(order, fill, stroke) for fill in found]
    assert keys == sorted(keys)
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
        by_key = sorted(pool, key=lambda fill: key_of(order, fill, stroke))
        assert found == [code_of(fill) for fill in by_key]


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
