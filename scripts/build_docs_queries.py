"""The part of the guide to queries that the code tells: the orders of fills."""

from __future__ import annotations

from build_docs_markdown import between


def queries_page(text: str) -> str:
    """The guide with the orders that there are, between its comments."""
    from query.listing.orders import ORDERS, default_order

    rows = ["| order | first comes | needs |", "|---|---|---|"]
    for order in ORDERS.values():
        first = order.first + (f", then {order.then}" if order.then else "")
        for points, drawn, where in (
            (False, False, ""),
            (True, False, " where the boundary has points"),
            (True, True, " where strokes are drawn"),
        ):
            if order.name == default_order(points=points, drawn=drawn):
                first += f" (default{where})"
        rows.append(f"| `{order.name}` | {first} | {order.needs} |")
    return between(text, "Orders", rows)
