"""How fits are ranked before they are expanded: the orders "regular" and "artist".

"regular": fewest irregular vertices, then fewest of them on the boundary, then the pattern seen
most often (Marcias et al. 2015, section 4, their order).

"artist": by what artists did, as far as a database tells. A pattern's patches are shared by the
ways in which it can lie in a boundary, of which its symmetries leave the fewer the more it has,
so that a fill is worth

    frequency * meshes * symmetries / (k * 20 ** d)

where the number of meshes makes up for meshes that repeat one pattern; k counts the fills of one
pattern from 1, most even widths first, so that fills of many patterns stand side by side, not
all of the first pattern before any of the second; and d is the number of edges by which strands
miss the strokes: nearly always the exact fill is meant, but whoever draws may be off by one.
Differs from the paper: fewest irregular vertices first hides what artists do with one or two
more; benchmarks/RESULTS.md has how often either order lists an artist's own fill.

Where strokes have ends, fits that miss none of them come first in both, and those that do after
them, by a search of their own (:mod:`query.listing.merging`).

The other orders sort what these find by a measure; see :mod:`query.listing.orders`.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from query.listing.prepared import PreparedQuery
from query.listing.table import RelaxedTable, Table, TableEntries

#: Listings that a table keeps: a query needs two, and boundaries differ in their corners.
LISTINGS_KEPT = 16

#: Tables are shared by threads that ask at the same time.
_KEEPING = threading.Lock()

#: The origin of patterns that no mesh has shown.
FAMILY = "family"

#: A place in an order: smaller comes first. Ties end at the pattern's id and the fit's place
#: among its row's, so that the same query gives the same list on any number of threads.
Rank = tuple[float, ...]


#: By how much an edge off a stroke's end makes a fill less likely.
OFF_BY_ONE = 20.0


@dataclass(frozen=True, slots=True)
class Ranking:
    """How fits are ranked before they are expanded.

    artist: does what artists did most come first? Else what is most regular does.
    worth:  where equally many vertices are irregular, does what a fill is worth decide, as in the
            order "artist", instead of how often its pattern was seen?
    used:   do recorded uses of a pattern count as much as patches of meshes?
    """

    artist: bool
    used: bool
    worth: bool = False

    def list_entries(self, table: Table, entries: TableEntries) -> Listing:
        """The entries in the order in which their fits may come."""
        seen = table.frequency[entries.row]
        meshes = table.n_meshes[entries.row].astype(np.float64)
        if self.used:
            uses = table.uses[entries.row]
            seen = seen + uses
            # What was only ever used counts as seen in one mesh.
            meshes = np.maximum(meshes, uses > 0)
        worth = meshes * seen.astype(np.float64) * table.n_symmetries[entries.row]
        worth[entries.n_irregular_boundary > 0] = 0.0
        ids = table.ids[entries.row]
        # Entries of one pattern stand in the order of their rows.
        common = worth if self.worth else seen
        keys = (entries.row, ids, -common, entries.n_irregular_boundary, entries.n_irregular)
        order = np.lexsort((*keys, -worth) if self.artist else keys)
        return Listing(self, entries.take(order), worth[order], seen[order], table.ids)

    def rank_constructed(self, irregular: int, boundary: int, off: int, place: int) -> Rank:
        """The rank of a fill that no table holds."""
        regular = (irregular, boundary, 0, 0, 0, off, place)
        return (0.0, *regular) if self.artist else regular


@dataclass(frozen=True, slots=True, eq=False)
class Listing:
    """Entries in order, with what ranks their fits.

    worth: (e,) float64 frequency times meshes times symmetries, 0 where corners are not where
           they should be, or a pattern was never seen. seen: (e,) int64.
    ids:   (r,) int64 of the table's rows.
    """

    ranking: Ranking
    entries: TableEntries
    worth: NDArray[np.float64]
    seen: NDArray[np.int64]
    ids: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.entries)

    def take(self, chosen: NDArray[np.bool_]) -> Listing:
        """Those chosen, in the same order."""
        return Listing(
            self.ranking,
            self.entries.take(chosen),
            self.worth[chosen],
            self.seen[chosen],
            self.ids,
        )

    def rank(self, at: int, off: int, place: int) -> Rank:
        """The rank of an entry's fit: ``off`` edges off the strokes, number ``place`` of its
        row's, from 0; with place -1 a rank before all of them."""
        entries = self.entries
        regular = (
            int(entries.n_irregular[at]),
            int(entries.n_irregular_boundary[at]),
            -float(self.worth[at] if self.ranking.worth else self.seen[at]),
            int(self.ids[entries.row[at]]),
            int(entries.row[at]),
            off,
            place,
        )
        if not self.ranking.artist:
            return regular
        worth = float(self.worth[at])
        return (-worth / ((max(place, 0) + 1) * OFF_BY_ONE**off), *regular)


def list_rows(query: PreparedQuery, table: Table, ranking: Ranking) -> Listing:
    """The rows of a table that may be taken, in the order in which their fits may come.

    Kept with the table: queries often ask much the same way.
    """
    q = query
    loops = any(stroke.is_loop for stroke in q.request.strokes)
    rules = tuple(
        (name, value)
        for name, rule, value in q.request.filters
        if rule.pattern is not None or rule.fit is not None
    )
    asked_before = (q.boundary.corners, rules, loops, q.request.wants(FAMILY), ranking)
    known = None if q.of_few else table.listings.get(asked_before)
    if known is not None:
        return known
    passing = q.admit_rows(table)
    if isinstance(table, RelaxedTable) and not q.request.wants(FAMILY):
        passing &= table.frequency > 0
    if loops:
        passing &= table.n_loops > 0
    entries = table.entries(q.boundary, passing)
    kept = q.request.admit_fits(entries)
    listing = ranking.list_entries(table, entries if kept.all() else entries.take(kept))
    if not q.of_few:
        with _KEEPING:
            while len(table.listings) >= LISTINGS_KEPT:
                table.listings.pop(next(iter(table.listings)))
            table.listings[asked_before] = listing
    return listing
