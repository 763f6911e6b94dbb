"""Complete families of patterns, grown instead of learned.

Read family (what a query takes; strips of quads make them, rust/query/src/families/growing.rs) and
arraycache (where both families and marked patterns are kept between runs).
"""
