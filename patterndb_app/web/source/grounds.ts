/** The surfaces that come with the page, and those that are dropped on it. */

import { sendSurface } from "./api.ts";
import { type Ground, PlaneGround, SurfaceGround } from "./ground.ts";
import { parseMesh } from "./meshfile.ts";
import type { Point } from "./vectors.ts";

export interface Example {
  readonly name: string;
  readonly title: string;
  /** From where it is looked at first. */
  readonly from: Point;
  /** Corners for who wants to see something at once, in clicks on the surface. */
  readonly corners: readonly Point[];
}

/** Files under page/examples; scripts/build_page.py makes them. */
export const EXAMPLES: readonly Example[] = [
  {
    name: "ball",
    title: "Ball",
    from: [0.35, 0.3, 1],
    corners: [[-0.6, -0.45, 0.66], [0.55, -0.5, 0.66], [0.85, 0.2, 0.5], [0.2, 0.75, 0.62], [-0.6, 0.4, 0.69]],
  },
  {
    name: "saddle",
    title: "Saddle",
    from: [0.35, -0.55, 1.2],
    corners: [[-0.7, -0.55, 0.094], [0.6, -0.7, -0.065], [0.75, 0.5, 0.156], [0, 0.8, -0.32], [-0.8, 0.45, 0.22]],
  },
  {
    name: "head",
    title: "Head",
    from: [0.85, 0.12, 1],
    corners: [[3.4, -1.2, 7.6], [2.3, -5.2, 8.6], [4.2, -8.6, 6.4], [6.4, -6, 2.8], [6.6, -0.8, 3.4]],
  },
];

/** A ground with the name by which the service knows it; null for the plane. */
export interface KnownGround {
  readonly ground: Ground;
  readonly id: string | null;
  readonly from: Point;
  readonly corners: readonly Point[];
}

export const PLANE: KnownGround = { ground: new PlaneGround(), id: null, from: [0, 0, 1], corners: [] };

const loaded = new Map<string, Promise<KnownGround>>();

/** Loads an example by its name and leaves it with the service; the same one is loaded once. */
export function loadExample(name: string): Promise<KnownGround> {
  const example = EXAMPLES.find((e) => e.name === name);
  if (!example) return Promise.reject(new Error(`there is no example surface ${JSON.stringify(name)}`));
  const known = loaded.get(name) ?? fetchExample(example);
  loaded.set(name, known);
  known.catch(() => loaded.delete(name));
  return known;
}

async function fetchExample(example: Example): Promise<KnownGround> {
  const answer = await fetch(`page/examples/${example.name}.obj`);
  if (!answer.ok) throw new Error(`the example ${example.title} could not be loaded`);
  const { ground, id } = await takeSurface(await answer.arrayBuffer(), `${example.name}.obj`, example.name);
  return { ground, id, from: example.from, corners: example.corners };
}

/** Reads a surface from a file's content and leaves it with the service. */
export async function takeSurface(data: ArrayBuffer, file: string, name = "dropped"): Promise<KnownGround> {
  const ground = new SurfaceGround(name, parseMesh(data, file));
  return { ground, id: await sendSurface(data, file), from: [0.4, 0.3, 1], corners: [] };
}

/** The service forgets surfaces after a while: forget that they were left there. */
export const forgetExamples = (): void => loaded.clear();
