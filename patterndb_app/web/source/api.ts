/** Talks to the service: one function a call, one kind of error. */

import type { PolygonMesh } from "./meshfile.ts";
import type { Point } from "./vectors.ts";

/** What the service refused, in its words. */
export class ServiceError extends Error {
  constructor(
    message: string,
    readonly status: number,
  ) {
    super(message);
  }
}

export interface FillLine {
  readonly pattern: string;
  readonly origin: string;
  readonly frequency: number;
  readonly widths: readonly number[];
  readonly n_irregular: number;
  readonly n_irregular_boundary: number;
  readonly strict: boolean;
  readonly flow_distance: number | null;
  readonly n_vertices: number;
  readonly quads: readonly (readonly number[])[];
  readonly sides: readonly (readonly number[])[];
  /** Where the vertices lie, where the boundary has points. */
  readonly placed?: readonly Point[] | null;
}

export interface StreamEnd {
  readonly done: true;
  readonly truncated: boolean;
  /** False where the time limit ended the search: there may be more than was found. */
  readonly complete?: boolean;
  readonly seconds: number;
  readonly reason?: string | null;
}

export interface OrderInfo {
  readonly name: string;
  /** What comes first in it. */
  readonly first: string;
  readonly needs_strokes: boolean;
}

export interface Statistics {
  readonly patterns: number;
  readonly meshes: number;
  readonly patches: number;
  readonly by_sides: Readonly<Record<string, number>>;
}

export interface PatternRow {
  readonly id: string;
  readonly sides: number;
  readonly n_irregular: number;
  readonly n_quads: number;
  readonly convex: boolean;
  readonly frequency: number;
  readonly svg: string;
}

export interface PatternPage {
  readonly patterns: readonly PatternRow[];
  readonly next: string | null;
}

export interface PatternDetail {
  readonly id: string;
  readonly sides: number;
  readonly n_quads: number;
  readonly frequency: number;
  readonly quads: readonly (readonly number[])[];
  readonly vertices: readonly (readonly [number, number])[];
  /** Of the irregular vertices inside. */
  readonly valences: readonly number[];
  readonly corner_vertices: readonly number[];
  readonly occurrences: readonly { readonly mesh: string; readonly licence: string | null; readonly count: number }[];
}

export interface HoleLoop {
  readonly loop: readonly number[];
  readonly edges: number;
  readonly centre: Point;
  readonly length: number;
}

export interface HoleFillLine {
  readonly pattern: string;
  readonly origin: string;
  readonly score: number | null;
  readonly quads: readonly (readonly number[])[];
  readonly points: readonly Point[];
  readonly n_irregular: number;
  readonly flipped: number;
  readonly flat: boolean;
}

/** The shapes that fills of holes can have, the default first, and the range of tension. */
export interface ShapeInfo {
  readonly shapes: readonly { readonly name: string; readonly what: string }[];
  readonly tension: readonly [number, number];
}

export interface HoleAnswer {
  readonly loop: readonly number[];
  readonly twin: boolean;
  readonly seconds: number;
  readonly fills: readonly HoleFillLine[];
}

/** Addresses are relative: the page may be served below a folder. */
const at = (path: string): string => `v1/${path}`;

async function ask<T>(path: string, init: RequestInit = {}): Promise<T> {
  const answer = await send(path, init);
  return (await answer.json()) as T;
}

async function send(path: string, init: RequestInit): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(at(path), init);
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new ServiceError("the service does not answer; is patterndb serve still running?", 0);
  }
  if (answer.ok) return answer;
  throw new ServiceError(await readError(answer), answer.status);
}

async function readError(answer: Response): Promise<string> {
  if (answer.status === 429) return "the service is at its limit of requests; try again in a moment";
  try {
    const body = (await answer.json()) as { error?: string };
    if (body.error) return body.error;
  } catch {
    // What answers in another shape is not the service, but something before it.
  }
  return `the service answered ${answer.status} ${answer.statusText}`;
}

const asJson = (body: unknown, signal?: AbortSignal): RequestInit => ({
  method: "POST",
  headers: { "content-type": "application/json" },
  body: JSON.stringify(body),
  ...(signal && { signal }),
});

/** Reads lines of JSON as they arrive. */
export async function* readLines(body: ReadableStream<Uint8Array>): AsyncGenerator<unknown> {
  const reader = body.getReader();
  const decoder = new TextDecoder();
  let rest = "";
  try {
    for (;;) {
      const { done, value } = await reader.read();
      rest += decoder.decode(value, { stream: !done });
      const lines = rest.split("\n");
      rest = done ? "" : lines.pop()!;
      for (const line of lines) if (line.trim()) yield JSON.parse(line);
      if (done) return;
    }
  } finally {
    // Who stops listening closes the connection, which ends the search.
    await reader.cancel().catch(() => undefined);
  }
}

/** Asks for fills and gives each as it is found; returns what the last line says. */
export async function* streamFills(
  question: Readonly<Record<string, unknown>>,
  signal: AbortSignal,
): AsyncGenerator<FillLine, StreamEnd> {
  const init = asJson(question, signal);
  const answer = await send("fills", {
    ...init,
    headers: { ...init.headers, accept: "application/x-ndjson" },
  });
  for await (const line of readLines(answer.body!)) {
    const row = line as FillLine | StreamEnd | { ok: false; error: string; status: number };
    if ("done" in row) return row;
    if ("ok" in row && !row.ok) throw new ServiceError(row.error, row.status);
    yield row as FillLine;
  }
  throw new ServiceError("the service ended the list before it was whole", 0);
}

export const askStats = (): Promise<Statistics> => ask("stats");

export async function askOrders(): Promise<readonly OrderInfo[]> {
  return (await ask<{ orders: OrderInfo[] }>("orders")).orders;
}

export const askPatterns = (query: URLSearchParams, signal?: AbortSignal): Promise<PatternPage> =>
  ask(`patterns?${query}`, signal ? { signal } : {});

export const askPattern = (id: string): Promise<PatternDetail> =>
  ask(`patterns/${encodeURIComponent(id)}`);

/** Leaves a surface with the service; returns the name by which questions mention it. */
export async function sendSurface(data: ArrayBuffer, name: string): Promise<string> {
  const type = name.toLowerCase().endsWith(".ply") ? "model/ply" : "model/obj";
  const init: RequestInit = { method: "POST", headers: { "content-type": type }, body: data };
  return (await ask<{ id: string }>("surfaces", init)).id;
}

export async function askLoops(mesh: PolygonMesh): Promise<readonly HoleLoop[]> {
  const answer = await ask<{ holes: HoleLoop[] }>("holes", asJson({ mesh, list: true }));
  return answer.holes;
}

export const askShapes = (): Promise<ShapeInfo> => ask("shapes");

/** lies: the entries of the question that say how fills are to lie. */
export async function askHoleFills(
  mesh: PolygonMesh,
  vertex: number,
  limit: number,
  lies: Readonly<Record<string, unknown>>,
  signal: AbortSignal,
): Promise<HoleAnswer> {
  const answer = await ask<{ holes: HoleAnswer[] }>(
    "holes",
    asJson({ mesh, loop: [vertex], limit, ...lies }, signal),
  );
  return answer.holes[0]!;
}
