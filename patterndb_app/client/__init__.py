"""Asking a service from Python: ``patterndb.connect`` is a function of remote."""
