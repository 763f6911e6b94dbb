/** One pattern, large: its quads, and its polychords, each lit up while it is pointed at. */

import { make, makeSvg } from "./dom.ts";
import { formatPlural } from "./numbers.ts";
import { makeNet, type QuadNet } from "./quadnet.ts";
import { chooseTint, chooseValenceColour } from "./theme.ts";
import { fitPlaces, type Flat, outlineBand, outlineMarker } from "./thumbnail.ts";

const SIZE = 560;

export interface PatternFigure {
  readonly picture: SVGSVGElement;
  /** A list of the polychords, for the keyboard. */
  readonly list: HTMLElement;
}

/**
 * Draws a pattern with its polychords.
 *
 * places: of the vertices, y upwards. corners: vertices on the border with one quad (convex) or
 * three and more (reflex).
 */
export function drawPattern(
  quads: readonly (readonly number[])[],
  places: readonly Flat[],
  corners: ReadonlySet<number>,
): PatternFigure {
  const net = makeNet(quads, places.length);
  const at = fitPlaces(places, SIZE, 34);
  const picture = makeSvg("svg", {
    viewBox: `0 0 ${SIZE} ${SIZE}`,
    class: "pattern-figure",
    role: "img",
    "aria-label": `a pattern of ${formatPlural(quads.length, "quad")} with ${formatPlural(net.strands.length, "polychord")}`,
  });
  const line = (points: readonly Flat[]): string => `M${points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`;
  const faces = quads.map((quad) => `${line(quad.map((v) => at[v]!))}Z`).join("");
  picture.append(makeSvg("path", { d: faces, class: "quads" }));
  const bands = net.strands.map((strand, i) => {
    const d = strand.quads.map((q, k) => `${line(outlineBand(quads[q]!.map((v) => at[v]!), strand.entries[k]!))}Z`).join("");
    return makeSvg("path", { d, class: "band polychord", fill: chooseTint(i), "data-polychord": i });
  });
  picture.append(...bands);
  const edges = (border: boolean): string =>
    net.edges.flatMap(([a, b], i) => (net.onBorder[i] === border ? [line([at[a]!, at[b]!])] : [])).join("");
  picture.append(makeSvg("path", { d: edges(false), class: "edges" }), makeSvg("path", { d: edges(true), class: "border" }));
  drawMarkers(picture, net, at, corners);
  const buttons = net.strands.map((strand, i) => {
    const shape = strand.closed ? "closed" : "from border to border";
    const key = makeSvg("svg", { viewBox: "0 0 16 16", class: "tint", "aria-hidden": "true" }, makeSvg("rect", { width: 16, height: 16, rx: 4, fill: chooseTint(i) }));
    return make("button", { type: "button", class: "polychord-row", "data-polychord": i }, key, make("span", {}, `${formatPlural(strand.quads.length, "quad")}, ${shape}`));
  });
  const list = make("div", { class: "polychords" }, ...buttons);
  const light = (chosen: number | null): void => {
    picture.classList.toggle("lit", chosen !== null);
    bands.forEach((band, i) => band.classList.toggle("on", i === chosen));
    buttons.forEach((button, i) => button.classList.toggle("on", i === chosen));
  };
  const follow = (event: Event): void => {
    const part = (event.target as Element).closest<HTMLElement | SVGElement>("[data-polychord]");
    light(part ? Number(part.dataset.polychord) : null);
  };
  for (const place of [picture, list]) {
    place.addEventListener("pointerover", follow);
    place.addEventListener("pointerleave", () => light(null));
  }
  list.addEventListener("focusin", follow);
  list.addEventListener("focusout", () => light(null));
  return { picture, list };
}

function drawMarkers(picture: SVGSVGElement, net: QuadNet, at: readonly Flat[], corners: ReadonlySet<number>): void {
  const border = new Set(net.edges.flatMap((edge, i) => (net.onBorder[i] ? [...edge] : [])));
  net.valences.forEach((valence, v) => {
    if (corners.has(v)) {
      const convex = valence === 1;
      picture.append(makeSvg("path", { d: outlineMarker(convex ? 0 : 4, at[v]!, convex ? 6 : 8), class: "corner" }));
    } else if (!border.has(v) && valence !== 4) {
      picture.append(makeSvg("path", { d: outlineMarker(valence, at[v]!, 10), fill: chooseValenceColour(valence), class: "irregular" }));
    }
  });
}
