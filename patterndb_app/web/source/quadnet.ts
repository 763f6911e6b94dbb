/** What a picture of quads shows: edges, strands of quads side by side, irregular vertices. */

export type Quad = readonly number[];

/** A strand of quads: those that a walk through opposite edges meets. */
export interface Strand {
  /** Quads in order. */
  readonly quads: readonly number[];
  /** Of each quad, the side (0 to 3) through which the walk enters. */
  readonly entries: readonly number[];
  readonly closed: boolean;
  /** Strands that run side by side all the way have the same group: one polychord made wide. */
  group: number;
}

export interface QuadNet {
  readonly quads: readonly Quad[];
  /** Pairs of vertices, each edge once. */
  readonly edges: readonly (readonly [number, number])[];
  /** Is the edge on the border? */
  readonly onBorder: readonly boolean[];
  /** Quads at each vertex. */
  readonly valences: readonly number[];
  readonly strands: readonly Strand[];
  /** Of each quad the strands through its sides 0 and 2, and through 1 and 3. */
  readonly crossing: readonly (readonly [number, number])[];
}

export function makeNet(quads: readonly Quad[], nVertices: number): QuadNet {
  const sides = new Map<number, number[]>();
  const key = (a: number, b: number): number =>
    a < b ? a * nVertices + b : b * nVertices + a;
  const valences = new Array<number>(nVertices).fill(0);
  quads.forEach((quad, q) => {
    for (let i = 0; i < 4; i++) {
      valences[quad[i]!]!++;
      const k = key(quad[i]!, quad[(i + 1) % 4]!);
      const beside = sides.get(k);
      if (beside) beside.push(q * 4 + i);
      else sides.set(k, [q * 4 + i]);
    }
  });
  const edges: [number, number][] = [];
  const onBorder: boolean[] = [];
  const opposite = new Int32Array(quads.length * 4).fill(-1);
  for (const [k, beside] of sides) {
    edges.push([Math.floor(k / nVertices), k % nVertices]);
    onBorder.push(beside.length === 1);
    if (beside.length === 2) {
      opposite[beside[0]!] = beside[1]!;
      opposite[beside[1]!] = beside[0]!;
    }
  }
  const { strands, crossing } = walkStrands(quads.length, opposite);
  groupStrands(strands, crossing, opposite);
  return { quads, edges, onBorder, valences, strands, crossing };
}

function walkStrands(
  nQuads: number,
  opposite: Int32Array,
): { strands: Strand[]; crossing: [number, number][] } {
  const crossing = Array.from({ length: nQuads }, (): [number, number] => [-1, -1]);
  const strands: Strand[] = [];
  const walk = (start: number): void => {
    const path: number[] = [];
    let side = start;
    const me = strands.length;
    while (side >= 0 && crossing[side >> 2]![(side & 3) % 2 as 0 | 1] < 0) {
      crossing[side >> 2]![(side & 3) % 2 as 0 | 1] = me;
      path.push(side);
      side = opposite[(side & ~3) | ((side + 2) & 3)]!;
    }
    strands.push({
      quads: path.map((s) => s >> 2),
      entries: path.map((s) => s & 3),
      closed: opposite[start]! >= 0,
      group: me,
    });
  };
  // From the border first, so that what ends there is walked from end to end.
  for (const border of [true, false]) {
    for (let side = 0; side < nQuads * 4; side++) {
      const free = crossing[side >> 2]![(side & 3) % 2 as 0 | 1] < 0;
      if (free && (!border || opposite[side]! < 0)) walk(side);
    }
  }
  return { strands, crossing };
}

/** Gives strands one group that run side by side, quad for quad, from end to end. */
function groupStrands(
  strands: Strand[],
  crossing: readonly (readonly [number, number])[],
  opposite: Int32Array,
): void {
  const root = (i: number): number => {
    while (strands[i]!.group !== i) i = strands[i]!.group;
    return i;
  };
  strands.forEach((strand, me) => {
    const beside = strand.quads.map((q, i) => {
      const side = q * 4 + ((strand.entries[i]! + 1) & 3);
      const other = opposite[side]!;
      return other < 0 ? -1 : crossing[other >> 2]![((other & 3) + 1) % 2 as 0 | 1];
    });
    const other = beside[0]!;
    if (other === undefined || other < 0 || beside.some((s) => s !== other)) return;
    if (strands[other]!.quads.length !== strand.quads.length) return;
    const [a, b] = [root(me), root(other)];
    if (a !== b) strands[Math.max(a, b)]!.group = Math.min(a, b);
  });
  strands.forEach((strand, i) => (strand.group = root(i)));
  const names = new Map<number, number>();
  for (const strand of strands) {
    if (!names.has(strand.group)) names.set(strand.group, names.size);
    strand.group = names.get(strand.group)!;
  }
}

/**
 * The irregular vertices of a fill: inside, whose number of quads is not 4, and on the border,
 * whose number is not what its place asks for: 1 at a convex corner, 3 at a reflex one, else 2.
 *
 * asked: quads that each border vertex should have, by vertex; others are inside.
 */
export function listIrregular(
  net: QuadNet,
  asked: ReadonlyMap<number, number>,
): { vertex: number; valence: number; border: boolean }[] {
  const found: { vertex: number; valence: number; border: boolean }[] = [];
  net.valences.forEach((valence, vertex) => {
    const border = asked.has(vertex);
    if (valence !== (asked.get(vertex) ?? 4)) found.push({ vertex, valence, border });
  });
  return found;
}
