"""The former name of :mod:`ingest.formats`, under which the documentation once showed it."""

from ingest.formats import ReadLimits, load_file, parse, read_mesh

__all__ = ["ReadLimits", "load_file", "parse", "read_mesh"]
