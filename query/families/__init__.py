"""Complete families of patterns, grown instead of learned."""
