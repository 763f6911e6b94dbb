"""Basic enumeration: every patch of at most so many quads, each exactly once.

Connected sets of quads are built from their smallest quad, never returning to a quad that
was passed over (Redelmeier's way to count polyominoes), so each set comes up once and
nothing need be remembered; those that are disks are patches. Differs from the paper, which
grows disks and remembers them by a hash.

Most small patches look alike. A running hash of how each quad is attached to those before
it finds the pattern of a patch that was built the same way before, without reducing it.
"""

from __future__ import annotations
