"""Quad disks and their patterns: half-edges, codes, labels, reduction. No files, no database."""
