/** The question in the making: corners on a ground, counts of the sides, strokes. */

import { spreadCounts, suggestEdge } from "./counts.ts";
import type { Ground } from "./ground.ts";
import { type CornerKind, roundPoint, type StrokeQuestion } from "./permalink.ts";
import {
  add,
  cross,
  distance,
  dot,
  findCentre,
  measureArea,
  measureLength,
  normalize,
  type Point,
  type Polyline,
  scale,
  subtract,
} from "./vectors.ts";

/** A corner that turns back by more than this is reflex unless one says otherwise. */
const REFLEX = (25 * Math.PI) / 180;

export class Sketch {
  corners: Point[] = [];
  kinds: CornerKind[] = [];
  counts: number[] = [];
  strokes: StrokeQuestion[] = [];
  closed = false;
  /** Length of an edge that counts were made from; null while counts are the reader's own. */
  edge: number | null = null;
  private sides: Polyline[] | null = null;

  constructor(public ground: Ground) {}

  clear(): void {
    this.corners = [];
    this.kinds = [];
    this.counts = [];
    this.strokes = [];
    this.closed = false;
    this.edge = null;
    this.sides = null;
  }

  addCorner(point: Point): void {
    this.corners.push(roundPoint(point));
    this.sides = null;
  }

  /** Closes the polygon: it runs counter-clockwise, seen from outside, and gets counts. */
  close(): void {
    if (this.corners.length < 2 || this.closed) return;
    this.closed = true;
    if (this.corners.length === 2) this.splitDigon();
    this.sides = null;
    if (dot(measureArea(this.outline()), this.findNormal()) < 0) {
      this.corners = [this.corners[0]!, ...this.corners.slice(1).reverse()];
      this.sides = null;
    }
    this.kinds = this.guessKinds();
    this.setEdge(suggestEdge(this.measureSides()));
  }

  /** Two corners enclose nothing: bulge them to a lens of four. */
  private splitDigon(): void {
    const [a, b] = this.corners as [Point, Point];
    const middle = scale(add(a, b), 0.5);
    const across = cross(this.ground.findNormal(middle), subtract(b, a));
    const lift = scale(across, 0.3);
    this.corners = [a, subtract(middle, lift), b, add(middle, lift)].map((p) =>
      roundPoint(this.ground.project(p)),
    );
  }

  /** Takes all of a question that was asked before. */
  restore(
    corners: readonly Point[],
    kinds: readonly CornerKind[],
    counts: readonly number[],
    strokes: readonly StrokeQuestion[],
  ): void {
    this.clear();
    this.corners = [...corners];
    if (corners.length < 3) return;
    this.closed = true;
    this.kinds = kinds.length === corners.length ? [...kinds] : this.guessKinds();
    this.strokes = [...strokes];
    if (counts.length === corners.length) this.counts = [...counts];
    else this.setEdge(suggestEdge(this.measureSides()));
  }

  moveCorner(index: number, to: Point): void {
    this.corners[index] = roundPoint(to);
    const sides = this.sides;
    if (!sides) return;
    const n = this.corners.length;
    for (const side of [index, (index + n - 1) % n]) {
      if (side < sides.length) sides[side] = this.traceSide(side);
    }
  }

  setCount(side: number, count: number): void {
    this.counts[side] = count;
    this.edge = null;
  }

  setEdge(edge: number): void {
    this.edge = edge;
    this.counts = spreadCounts(this.measureSides(), edge);
  }

  toggleKind(corner: number): void {
    this.kinds[corner] = this.kinds[corner] === "reflex" ? "convex" : "reflex";
  }

  /** A polyline per side; of a polygon that is open yet, up to its last corner. */
  getSides(): readonly Polyline[] {
    const n = this.closed ? this.corners.length : Math.max(0, this.corners.length - 1);
    this.sides ??= Array.from({ length: n }, (_, i) => this.traceSide(i));
    return this.sides;
  }

  private traceSide(i: number): Polyline {
    return this.ground.trace(this.corners[i]!, this.corners[(i + 1) % this.corners.length]!);
  }

  measureSides(): number[] {
    return this.getSides().map(measureLength);
  }

  outline(): Point[] {
    return this.getSides().flatMap((side) => side.slice(0, -1));
  }

  findNormal(): Point {
    const normals = this.corners.map((c) => this.ground.findNormal(c));
    return normalize(normals.reduce(add, [0, 0, 0] as Point));
  }

  private guessKinds(): CornerKind[] {
    const sides = this.getSides();
    return sides.map((side, i) => {
      const before = sides[(i + sides.length - 1) % sides.length]!;
      const arrive = normalize(subtract(side[0]!, before[before.length - 2]!));
      const leave = normalize(subtract(side[1]!, side[0]!));
      const turn = Math.atan2(
        dot(cross(arrive, leave), this.ground.findNormal(side[0]!)),
        dot(arrive, leave),
      );
      return turn < -REFLEX ? "reflex" : "convex";
    });
  }

  /** Is a point so near to the first corner that the polygon is meant to be closed? */
  isNearFirst(point: Point, within: number): boolean {
    return this.corners.length > 2 && distance(point, this.corners[0]!) < within;
  }

  get centre(): Point {
    return findCentre(this.corners);
  }

  get edgeLength(): number {
    const edges = this.counts.reduce((a, b) => a + b, 0);
    return this.measureSides().reduce((a, b) => a + b, 0) / Math.max(1, edges);
  }
}

/** Polygons to begin with, in the plane. */
export const SHAPES: Readonly<Record<string, { title: string; corners: readonly Point[] }>> = {
  triangle: { title: "Triangle", corners: makeRegular(3) },
  quad: { title: "Quad", corners: [[-1.25, -0.85, 0], [1.25, -0.95, 0], [1.05, 0.95, 0], [-1, 0.8, 0]] },
  pentagon: { title: "Pentagon", corners: makeRegular(5) },
  hexagon: { title: "Hexagon", corners: makeRegular(6) },
  ell: {
    title: "L with a reflex corner",
    corners: [[-1, -1, 0], [1.1, -1, 0], [1.1, 0.05, 0], [0.1, 0.05, 0], [0.1, 1.1, 0], [-1, 1.1, 0]],
  },
};

function makeRegular(n: number): Point[] {
  const first = -Math.PI / 2 - Math.PI / n;
  return Array.from({ length: n }, (_, i) => {
    const angle = first + (2 * Math.PI * i) / n;
    return roundPoint([1.2 * Math.cos(angle), 1.2 * Math.sin(angle), 0]);
  });
}
