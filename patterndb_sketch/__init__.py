"""The sketch tools that draw boundaries for the query engine, headless.

May import ``query`` and ``patterndb``; ``viewer`` stands above it.
"""
