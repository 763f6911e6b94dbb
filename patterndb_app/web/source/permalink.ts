/** The address of a question: what is after the # holds all that was asked. */

import type { Point } from "./vectors.ts";

export type CornerKind = "convex" | "reflex";

export interface StrokeQuestion {
  readonly points: readonly Point[];
  readonly loop: boolean;
}

/** A question as the page asks it: everything a fill's list depends on. */
export interface Question {
  /** The name of an example, "plane", or "dropped": a link cannot hold a file. */
  readonly surface: string;
  readonly corners: readonly Point[];
  readonly kinds: readonly CornerKind[];
  readonly counts: readonly number[];
  readonly strokes: readonly StrokeQuestion[];
  readonly options: Readonly<Record<string, string>>;
  /** The fill that is looked at, from 1. */
  readonly rank: number;
}

export interface Place {
  readonly tab: string;
  readonly values: URLSearchParams;
}

/** Reads an address's fragment: "#fill?n=5,4" is the tab fill with the value n. */
export function parsePlace(hash: string): Place {
  const [tab = "", query = ""] = hash.replace(/^#/, "").split("?", 2) as [string, string?];
  return { tab, values: new URLSearchParams(query) };
}

export function formatPlace(tab: string, values: URLSearchParams): string {
  // Commas and colons may stand as they are in a fragment, and are easier to read so.
  const query = values.toString().replace(/%2C/g, ",").replace(/%3B/g, ";").replace(/%3A/g, ":");
  return query ? `#${tab}?${query}` : `#${tab}`;
}

const OPTION = /^[a-z_]+$/;

export function encodeQuestion(question: Question): URLSearchParams {
  const values = new URLSearchParams();
  if (question.surface !== "plane") values.set("s", question.surface);
  if (question.corners.length) values.set("c", formatPoints(question.corners));
  if (question.kinds.includes("reflex")) {
    values.set("k", question.kinds.map((k) => (k === "reflex" ? "r" : "c")).join(""));
  }
  if (question.counts.length) values.set("n", question.counts.join(","));
  for (const stroke of question.strokes) {
    values.append(stroke.loop ? "l" : "f", formatPoints(stroke.points));
  }
  for (const [name, value] of Object.entries(question.options)) values.set(`o.${name}`, value);
  if (question.rank > 1) values.set("r", String(question.rank));
  return values;
}

/** Reads a question from an address; null where there is none, or one that cannot be read. */
export function decodeQuestion(values: URLSearchParams): Question | null {
  const corners = parsePoints(values.get("c") ?? "");
  if (corners === null) return null;
  const counts = (values.get("n") ?? "").split(",").filter(Boolean).map(Number);
  if (counts.some((n) => !Number.isInteger(n) || n < 1)) return null;
  if (counts.length && counts.length !== corners.length) return null;
  const letters = values.get("k") ?? "c".repeat(corners.length);
  if (!/^[cr]*$/.test(letters) || letters.length !== corners.length) return null;
  const strokes: StrokeQuestion[] = [];
  for (const [name, value] of values) {
    if (name !== "f" && name !== "l") continue;
    const points = parsePoints(value);
    if (points === null || points.length < 2) return null;
    strokes.push({ points, loop: name === "l" });
  }
  const options: Record<string, string> = {};
  for (const [name, value] of values) {
    const option = name.startsWith("o.") ? name.slice(2) : "";
    if (OPTION.test(option)) options[option] = value;
  }
  const rank = Number(values.get("r") ?? 1);
  return {
    surface: values.get("s") ?? "plane",
    corners,
    kinds: [...letters].map((l) => (l === "r" ? "reflex" : "convex")),
    counts,
    strokes,
    options,
    rank: Number.isInteger(rank) && rank > 0 ? rank : 1,
  };
}

/** Coordinates with six figures, none below 1e-9: a link shall give the same list. */
export const roundPoint = (p: Point): Point => [round(p[0]), round(p[1]), round(p[2])];

const round = (x: number): number => (Math.abs(x) < 1e-9 ? 0 : Number(x.toPrecision(6)));

function formatPoints(points: readonly Point[]): string {
  return points.map((p) => roundPoint(p).slice(0, p[2] === 0 ? 2 : 3).join(",")).join(";");
}

function parsePoints(text: string): Point[] | null {
  if (!text) return [];
  const points: Point[] = [];
  for (const part of text.split(";")) {
    const xyz = part.split(",").map(Number);
    if (xyz.length < 2 || xyz.length > 3 || xyz.some((x) => !Number.isFinite(x))) return null;
    points.push([xyz[0]!, xyz[1]!, xyz[2] ?? 0]);
  }
  return points;
}
