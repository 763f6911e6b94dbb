/** Edge counts of a boundary's sides: what lengths suggest, and the nearest even ones. */

export const sum = (counts: readonly number[]): number => counts.reduce((a, b) => a + b, 0);

export const isEven = (counts: readonly number[]): boolean => sum(counts) % 2 === 0;

/** An edge length that gives a boundary of these side lengths about `edges` edges. */
export function suggestEdge(lengths: readonly number[], edges = 22): number {
  const total = sum(lengths);
  return total > 0 ? total / edges : 1;
}

/**
 * Counts whose edges are about so long, with an even sum of at least 4.
 *
 * Where rounding leaves an odd sum, the side that was rounded farthest goes the other way.
 */
export function spreadCounts(lengths: readonly number[], edge: number): number[] {
  const exact = lengths.map((length) => Math.max(length / edge, 0));
  const counts = exact.map((e) => Math.max(1, Math.round(e)));
  while (sum(counts) < 4 || !isEven(counts)) {
    let best = 0;
    let bestCost = Infinity;
    let bestStep = 1;
    counts.forEach((count, i) => {
      for (const step of [1, -1]) {
        if (count + step < 1 || (step < 0 && sum(counts) <= 4)) continue;
        const cost = Math.abs(count + step - exact[i]!) / Math.max(count, 1);
        if (cost < bestCost) [best, bestCost, bestStep] = [i, cost, step];
      }
    });
    counts[best]! += bestStep;
  }
  return counts;
}

/** A way to an even perimeter: the side that changes, by how much, and all counts then. */
export interface EvenOffer {
  readonly side: number;
  readonly step: 1 | -1;
  readonly counts: readonly number[];
}

/**
 * The nearest even counts: each changes one side by one edge, the least relative change first.
 *
 * lengths: of the sides, if they are known: an edge shall then stay about as long as the others.
 */
export function offerEven(
  counts: readonly number[],
  lengths?: readonly number[],
  most = 4,
): EvenOffer[] {
  if (isEven(counts)) return [];
  const edge = lengths ? sum(lengths) / Math.max(1, sum(counts)) : 0;
  const offers: { offer: EvenOffer; cost: number }[] = [];
  counts.forEach((count, side) => {
    for (const step of [1, -1] as const) {
      if (count + step < 1 || sum(counts) + step < 4) continue;
      const changed = counts.map((c, i) => (i === side ? c + step : c));
      const cost = lengths
        ? Math.abs(Math.log(lengths[side]! / (count + step) / edge || 1))
        : 1 / Math.min(count, count + step);
      offers.push({ offer: { side, step, counts: changed }, cost });
    }
  });
  offers.sort((a, b) => a.cost - b.cost);
  return offers.slice(0, most).map(({ offer }) => offer);
}
