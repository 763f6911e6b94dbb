"""Nearest points of triangles, and the triangles near a box, down their tree."""

from __future__ import annotations
