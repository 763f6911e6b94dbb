/** Points in space as triples, and what is computed of a few of them. */

export type Point = readonly [number, number, number];
export type Polyline = readonly Point[];

export const add = (a: Point, b: Point): Point => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Point, by: number): Point => [a[0] * by, a[1] * by, a[2] * by];
export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Point, b: Point): Point => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const norm = (a: Point): number => Math.hypot(a[0], a[1], a[2]);
export const distance = (a: Point, b: Point): number => norm(subtract(a, b));
export const blend = (a: Point, b: Point, t: number): Point => [
  a[0] + (b[0] - a[0]) * t,
  a[1] + (b[1] - a[1]) * t,
  a[2] + (b[2] - a[2]) * t,
];

export function normalize(a: Point): Point {
  const size = norm(a);
  return size > 0 ? scale(a, 1 / size) : [0, 0, 1];
}

export function measureLength(line: Polyline): number {
  let total = 0;
  for (let i = 1; i < line.length; i++) total += distance(line[i - 1]!, line[i]!);
  return total;
}

/** The point of a polyline at a share (0 to 1) of its length. */
export function interpolateAlong(line: Polyline, share: number): Point {
  let left = measureLength(line) * share;
  for (let i = 1; i < line.length; i++) {
    const step = distance(line[i - 1]!, line[i]!);
    if (left <= step || i === line.length - 1) {
      return blend(line[i - 1]!, line[i]!, step > 0 ? Math.min(1, left / step) : 0);
    }
    left -= step;
  }
  return line[0]!;
}

/** The n + 1 points that divide a polyline into n equal parts. */
export function divideEvenly(line: Polyline, n: number): Point[] {
  return Array.from({ length: n + 1 }, (_, i) => interpolateAlong(line, i / n));
}

/** The area vector of a closed polygon: its direction is the normal, its length the area. */
export function measureArea(polygon: Polyline): Point {
  let sum: Point = [0, 0, 0];
  const origin = polygon[0] ?? [0, 0, 0];
  for (let i = 0; i < polygon.length; i++) {
    const a = subtract(polygon[i]!, origin);
    const b = subtract(polygon[(i + 1) % polygon.length]!, origin);
    sum = add(sum, cross(a, b));
  }
  return scale(sum, 0.5);
}

export function findCentre(points: Polyline): Point {
  if (!points.length) return [0, 0, 0];
  return scale(points.reduce(add, [0, 0, 0] as Point), 1 / points.length);
}

/** Two unit vectors across a normal: right, and up as far as `up` goes. */
export function makeFrame(normal: Point, up: Point): { right: Point; up: Point } {
  const n = normalize(normal);
  let right = cross(up, n);
  if (norm(right) < 1e-6) right = cross([0, 0, -1], n);
  if (norm(right) < 1e-6) right = [1, 0, 0];
  right = normalize(right);
  return { right, up: cross(n, right) };
}

/** Thins a hand-drawn polyline: no point lies farther from what is kept than the tolerance. */
export function simplify(line: Polyline, tolerance: number): Point[] {
  if (line.length < 3) return [...line];
  const first = line[0]!;
  const last = line[line.length - 1]!;
  let farthest = 0;
  let at = 0;
  const along = subtract(last, first);
  const size = dot(along, along);
  for (let i = 1; i < line.length - 1; i++) {
    const t = size > 0 ? Math.min(1, Math.max(0, dot(subtract(line[i]!, first), along) / size)) : 0;
    const off = distance(line[i]!, blend(first, last, t));
    if (off > farthest) [farthest, at] = [off, i];
  }
  if (farthest <= tolerance) return [first, last];
  const before = simplify(line.slice(0, at + 1), tolerance);
  return [...before.slice(0, -1), ...simplify(line.slice(at), tolerance)];
}
