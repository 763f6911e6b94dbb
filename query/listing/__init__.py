"""From a request to a list of fills.

Read table (rows of patterns that a boundary can be matched with), matches (a request for one
boundary, and the rows of one table that fit, by rank), construction (fills put together of parts),
merging (all of these by rank, none twice), fills (the list that a caller holds), explanation (why
it is empty) and orders (the orders to choose from).
"""
