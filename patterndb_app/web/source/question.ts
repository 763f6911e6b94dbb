/** The question as the service takes it, and the options that one can choose. */

import { roundPoint } from "./permalink.ts";
import type { Sketch } from "./sketch.ts";

/** Fills that are asked for at first, and again with "more". */
export const LISTED = 24;

/**
 * The options, by the names that the library has for them.
 *
 * The order is always asked for. Left out it would be one that measures the first hundreds of fills
 * before it lists any, where the boundary has points; "artist" has its first at once.
 */
export interface Options {
  order: string;
  strict: boolean;
  variants: boolean;
  maxIrregular: number | null;
}

export const DEFAULTS: Readonly<Options> = { order: "artist", strict: false, variants: false, maxIrregular: null };

export function encodeOptions(options: Options): Record<string, string> {
  return {
    ...(options.order !== DEFAULTS.order && { order: options.order }),
    ...(options.strict && { strict: "1" }),
    ...(options.variants && { variants: "1" }),
    ...(options.maxIrregular !== null && { max_irregular: String(options.maxIrregular) }),
  };
}

export function decodeOptions(values: Readonly<Record<string, string>>): Options {
  const most = values.max_irregular;
  return {
    order: values.order ?? DEFAULTS.order,
    strict: values.strict === "1",
    variants: values.variants === "1",
    maxIrregular: most && /^\d+$/.test(most) ? Number(most) : null,
  };
}

/** The body of POST /v1/fills: a boundary along polylines, as files for the library have it. */
export function makeBody(
  sketch: Sketch,
  options: Options,
  surface: string | null,
  limit: number,
): Record<string, unknown> {
  return {
    sides: sketch.getSides().map((side) => side.map(roundPoint)),
    lengths: sketch.counts,
    corners: sketch.kinds,
    limit,
    order: options.order,
    ...(sketch.strokes.length && { strokes: sketch.strokes }),
    ...(surface && { surface }),
    ...(options.strict && { strict: true }),
    ...(!options.variants && { per_pattern: 1 }),
    ...(options.maxIrregular !== null && { max_irregular: options.maxIrregular }),
  };
}
