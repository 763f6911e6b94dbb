"""From a request to a list of fills.

Read prepared (a request for one boundary), table (rows of patterns that a boundary can be matched
with), ranking (their order), matches (the rows of one table that fit), construction (fills put
together of parts), merging (all of these by rank, none twice), fills (the list
that a caller holds), explanation (why it is empty) and orders (the orders to choose from).
"""
