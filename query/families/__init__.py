"""Complete families of patterns, grown instead of learned.

Read growing (how strips of quads make them), family (what a query takes) and arraycache (where both
families and marked patterns are kept between runs).
"""
