/** Flat pictures of quads as SVG, in the manner of the sheets that the library draws. */

import { makeSvg } from "./dom.ts";
import { listIrregular, type QuadNet } from "./quadnet.ts";
import { chooseTint, chooseValenceColour } from "./theme.ts";
import { dot, makeFrame, type Point, subtract } from "./vectors.ts";

export type Flat = readonly [number, number];

export interface FlatFill {
  readonly net: QuadNet;
  /** Where the vertices lie, y upwards. */
  readonly places: readonly Flat[];
  readonly asked: ReadonlyMap<number, number>;
}

/** Sees points from a direction, as from far away. */
export function flatten(points: readonly Point[], normal: Point, up: Point): Flat[] {
  const frame = makeFrame(normal, up);
  const origin = points[0] ?? [0, 0, 0];
  return points.map((p) => {
    const d = subtract(p, origin);
    return [dot(d, frame.right), dot(d, frame.up)];
  });
}

/** Puts places into a square of this size, with a margin, y downwards. */
export function fitPlaces(places: readonly Flat[], size: number, margin: number): Flat[] {
  const xs = places.map((p) => p[0]);
  const ys = places.map((p) => p[1]);
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const [low, high] = [Math.min(...ys), Math.max(...ys)];
  const by = (size - 2 * margin) / Math.max(right - left, high - low, 1e-12);
  return places.map(([x, y]) => [
    size / 2 + (x - (left + right) / 2) * by,
    size / 2 - (y - (low + high) / 2) * by,
  ]);
}

const fix = (x: number): string => x.toFixed(1);
const draw = (points: readonly Flat[]): string =>
  `M${points.map(([x, y]) => `${fix(x)} ${fix(y)}`).join("L")}`;
const between = (a: Flat, b: Flat, t: number): Flat => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];

/** The band of a strand through a quad, which enters by this side: its middle half. */
export function outlineBand(quad: readonly Flat[], side: number): Flat[] {
  const [a, b, c, d] = [0, 1, 2, 3].map((k) => quad[(side + k) % 4]!) as [Flat, Flat, Flat, Flat];
  return [between(a, b, 0.25), between(a, b, 0.75), between(d, c, 0.75), between(d, c, 0.25)];
}

/** A marker's outline: corners of a regular polygon, a disc below 3, a star from 7 on. */
export function outlineMarker(kind: number, [x, y]: Flat, radius: number): string {
  const star = kind >= 7;
  const n = kind < 3 ? 24 : star ? 2 * kind : kind;
  const grown = radius * (kind < 3 || star ? 1 : kind === 3 ? 1.22 : 1.06);
  const corners = Array.from({ length: n }, (_, i): Flat => {
    const r = star ? radius * (i % 2 ? 0.62 : 1.25) : grown;
    const angle = Math.PI / 2 + (2 * Math.PI * i) / n;
    return [x + r * Math.cos(angle), y - r * Math.sin(angle)];
  });
  return `${draw(corners)}Z`;
}

/** Draws a fill as an SVG of this size. */
export function drawThumbnail(fill: FlatFill, size = 120): SVGSVGElement {
  const { net, asked } = fill;
  const at = fitPlaces(fill.places, size, size * 0.07);
  const svg = makeSvg("svg", { viewBox: `0 0 ${size} ${size}`, class: "thumbnail", "aria-hidden": "true" });
  const faces = net.quads.map((quad) => `${draw(quad.map((v) => at[v]!))}Z`).join("");
  svg.append(makeSvg("path", { d: faces, class: "quads" }));
  for (const [tint, d] of gatherBands(net, at)) svg.append(makeSvg("path", { d, fill: tint, class: "band" }));
  const lines = (border: boolean): string =>
    net.edges.flatMap(([a, b], i) => (net.onBorder[i] === border ? [draw([at[a]!, at[b]!])] : [])).join("");
  svg.append(makeSvg("path", { d: lines(false), class: "edges" }));
  svg.append(makeSvg("path", { d: lines(true), class: "border" }));
  for (const { vertex, valence, border } of listIrregular(net, asked)) {
    const d = outlineMarker(border ? 0 : valence, at[vertex]!, size * (border ? 0.024 : 0.029));
    svg.append(makeSvg("path", border ? { d, class: "odd" } : { d, fill: chooseValenceColour(valence), class: "irregular" }));
  }
  return svg;
}

function gatherBands(net: QuadNet, at: readonly Flat[]): Map<string, string> {
  const bands = new Map<string, string>();
  for (const strand of net.strands) {
    const tint = chooseTint(strand.group);
    const d = strand.quads
      .map((q, i) => `${draw(outlineBand(net.quads[q]!.map((v) => at[v]!), strand.entries[i]!))}Z`)
      .join("");
    bands.set(tint, (bands.get(tint) ?? "") + d);
  }
  return bands;
}

/** A key to the markers of some valences. */
export function drawKey(valences: readonly number[]): SVGSVGElement[] {
  return valences.map((valence) =>
    makeSvg(
      "svg",
      { viewBox: "0 0 20 20", class: "key", role: "img", "aria-label": `valence ${valence}` },
      makeSvg("path", { d: outlineMarker(valence, [10, valence === 3 ? 11 : 10], 7), fill: chooseValenceColour(valence), class: "irregular" }),
    ),
  );
}
