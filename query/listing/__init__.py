"""From a question to a list of fills: tables, lanes, orders, and the stream that merges them."""
