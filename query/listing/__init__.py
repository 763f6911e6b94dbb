"""From a question to a list of fills.

Read filters (which patterns may be taken, and why a list stays empty), table (what a boundary can
be matched with), ranking and lane (the fits of one table, in order), construction (the lane of what
is put together of parts), stream (all lanes merged) and orders (the orders there are to choose).
"""
