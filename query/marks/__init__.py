"""Marked patterns: relaxed matching as strict matching of patterns with marks."""
