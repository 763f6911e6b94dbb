/** What a boundary is drawn on: the plane, or a surface with its tree of boxes. */

import { type BufferGeometry, Plane, type Raycaster, Vector3 } from "three";
import { type HitPointInfo, MeshBVH } from "three-mesh-bvh";
import { makeGeometry } from "./figure.ts";
import type { PolygonMesh } from "./meshfile.ts";
import { blend, distance, findCentre, type Point, type Polyline } from "./vectors.ts";

export interface Ground {
  readonly name: string;
  /** Of a surface; the plane has none. */
  readonly geometry: BufferGeometry | null;
  /** A length that is small on this ground. */
  readonly grain: number;
  /** Where a ray meets it. */
  pick(ray: Raycaster): Point | null;
  /** The nearest point on it. */
  project(point: Point): Point;
  /** A short way on it from one point to another. */
  trace(a: Point, b: Point): Polyline;
  /** Its direction at a point of it. */
  findNormal(point: Point): Point;
}

export class PlaneGround implements Ground {
  readonly name = "plane";
  readonly geometry = null;
  readonly grain = 0.01;
  private readonly plane = new Plane(new Vector3(0, 0, 1), 0);

  pick(ray: Raycaster): Point | null {
    const at = ray.ray.intersectPlane(this.plane, new Vector3());
    return at ? [at.x, at.y, 0] : null;
  }

  project(point: Point): Point {
    return [point[0], point[1], 0];
  }

  trace(a: Point, b: Point): Polyline {
    return [a, b];
  }

  findNormal(): Point {
    return [0, 0, 1];
  }
}

/** Pieces of a way between two corners, and how often it is drawn tight. */
const PIECES = 16;
const ROUNDS = 24;

export class SurfaceGround implements Ground {
  readonly geometry: BufferGeometry;
  readonly centre: Point;
  readonly grain: number;
  private readonly tree: MeshBVH;

  constructor(
    readonly name: string,
    readonly mesh: PolygonMesh,
  ) {
    this.geometry = makeGeometry(mesh);
    this.tree = new MeshBVH(this.geometry);
    this.centre = findCentre(mesh.points);
    this.grain = 0.004 * Math.max(1e-9, ...mesh.points.map((p) => distance(p, this.centre)));
  }

  pick(ray: Raycaster): Point | null {
    const hit = this.tree.raycastFirst(ray.ray);
    return hit ? hit.point.toArray() : null;
  }

  project(point: Point): Point {
    return this.findNearest(point)?.point.toArray() ?? point;
  }

  /**
   * A way that lies on the surface: points of the straight line are laid on it, each is moved
   * between its neighbours and laid on it again, which draws the way tight.
   */
  trace(a: Point, b: Point): Polyline {
    let line = Array.from({ length: PIECES + 1 }, (_, i) => blend(a, b, i / PIECES));
    for (let round = 0; round <= ROUNDS; round++) {
      line = line.map((p, i) => {
        if (i === 0 || i === PIECES) return p;
        return this.project(round ? blend(line[i - 1]!, line[i + 1]!, 0.5) : p);
      });
    }
    return line;
  }

  findNormal(point: Point): Point {
    const hit = this.findNearest(point);
    if (!hit) return [0, 0, 1];
    const index = this.geometry.index!;
    const place = this.geometry.getAttribute("position");
    const [p, q, r] = [0, 1, 2].map((k) =>
      new Vector3().fromBufferAttribute(place, index.getX(hit.faceIndex * 3 + k)),
    ) as [Vector3, Vector3, Vector3];
    return q.sub(p).cross(r.sub(p)).normalize().toArray();
  }

  private findNearest(point: Point): HitPointInfo | null {
    return this.tree.closestPointToPoint(new Vector3(...point));
  }
}

