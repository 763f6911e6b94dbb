/** What is drawn in the scene: surfaces, quads with strands, lines, markers. */

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  Float32BufferAttribute,
  Group,
  Mesh,
  type Object3D,
  Points,
} from "three";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { LAYER, findFaceMaterial, findLineMaterial, findMarkerMaterial } from "./materials.ts";
import { listTriangles, type PolygonMesh } from "./meshfile.ts";
import { listIrregular, type QuadNet } from "./quadnet.ts";
import { chooseTint, chooseValenceColour, type Palette } from "./theme.ts";
import { blend, type Point, type Polyline } from "./vectors.ts";

export interface Marker {
  readonly at: Point;
  readonly colour: string;
  /** Corners of its shape; a disc for fewer than 3. */
  readonly sides: number;
  /** In pixels of the page. */
  readonly radius: number;
}

/** A fill with what its picture needs. */
export interface DrawnNet {
  readonly net: QuadNet;
  readonly points: readonly Point[];
  /** Quads that each border vertex should have. */
  readonly asked: ReadonlyMap<number, number>;
}

export function makeMarkers(markers: readonly Marker[], rim: string, layer = LAYER.marker): Points {
  const geometry = new BufferGeometry();
  const colours = markers.flatMap((m) => new Color(m.colour).toArray());
  geometry.setAttribute("position", new Float32BufferAttribute(markers.flatMap((m) => [...m.at]), 3));
  geometry.setAttribute("tint", new Float32BufferAttribute(colours, 3));
  geometry.setAttribute("sides", new Float32BufferAttribute(markers.map((m) => m.sides), 1));
  geometry.setAttribute("radius", new Float32BufferAttribute(markers.map((m) => m.radius), 1));
  const points = new Points(geometry, findMarkerMaterial(rim, layer));
  points.frustumCulled = false;
  points.renderOrder = layer;
  return points;
}

export function makeLines(
  lines: readonly Polyline[],
  colour: string,
  width: number,
  layer: number,
): LineSegments2 {
  const positions: number[] = [];
  for (const line of lines) {
    for (let i = 1; i < line.length; i++) positions.push(...line[i - 1]!, ...line[i]!);
  }
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(positions);
  const drawn = new LineSegments2(geometry, findLineMaterial(colour, width, layer));
  drawn.frustumCulled = false;
  drawn.renderOrder = layer;
  return drawn;
}

/** A mesh's triangles with smooth normals. */
export function makeGeometry(mesh: PolygonMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  const flat = new Float32Array(mesh.points.length * 3);
  mesh.points.forEach((p, i) => flat.set(p, 3 * i));
  geometry.setAttribute("position", new BufferAttribute(flat, 3));
  geometry.setIndex(listTriangles(mesh));
  geometry.computeVertexNormals();
  return geometry;
}

export function makeSurface(geometry: BufferGeometry, palette: Palette): Mesh {
  return new Mesh(geometry, findFaceMaterial(palette.surface, LAYER.surface));
}

/** Edges of a mesh's polygons, each once. */
export function makeMeshEdges(mesh: PolygonMesh, colour: string, width: number, layer: number): LineSegments2 {
  const seen = new Set<number>();
  const n = mesh.points.length;
  const lines: Point[][] = [];
  for (const face of mesh.faces) {
    face.forEach((a, i) => {
      const b = face[(i + 1) % face.length]!;
      const key = a < b ? a * n + b : b * n + a;
      if (seen.has(key)) return;
      seen.add(key);
      lines.push([mesh.points[a]!, mesh.points[b]!]);
    });
  }
  return makeLines(lines, colour, width, layer);
}

/** Quads in their colours, with edges, border, and markers at irregular vertices. */
export function makeFillFigure(fill: DrawnNet, palette: Palette, strands: boolean): Group {
  const { net, points } = fill;
  const figure = new Group();
  figure.add(makeQuads(net, points, palette.quad, strands));
  const inner = net.edges.filter((_, i) => !net.onBorder[i]);
  const border = net.edges.filter((_, i) => net.onBorder[i]);
  const lay = (edges: readonly (readonly [number, number])[]): Polyline[] =>
    edges.map(([a, b]) => [points[a]!, points[b]!]);
  figure.add(makeLines(lay(inner), palette.edge, 1.5, LAYER.edge));
  figure.add(makeLines(lay(border), palette.boundary, 3, LAYER.boundary));
  const ticks = [...new Set(border.flat())].map(
    (v): Marker => ({ at: points[v]!, colour: palette.boundary, sides: 0, radius: 2.6 }),
  );
  figure.add(makeMarkers(ticks, palette.boundary, LAYER.boundary));
  figure.add(makeMarkers(markIrregular(fill, palette), palette.rim));
  return figure;
}

/**
 * Markers of irregular vertices: inside, shape and colour say the valence, as in all pictures; on
 * the border, where a corner is not what it was asked to be, they are rings.
 */
export function markIrregular({ net, points, asked }: DrawnNet, palette: Palette): Marker[] {
  return listIrregular(net, asked).flatMap(({ vertex, valence, border }): Marker[] => {
    const at = points[vertex]!;
    if (!border) return [{ at, colour: chooseValenceColour(valence), sides: valence, radius: 6.5 }];
    return [
      { at, colour: palette.selected, sides: 0, radius: 6.5 },
      { at, colour: palette.rim, sides: 0, radius: 3 },
    ];
  });
}

/**
 * The quads as one mesh. With strands, each quad is cut in nine: the middle thirds of opposite
 * sides are joined by the tints of the polychords that run through, as on sheets of fills.
 */
export function makeQuads(net: QuadNet, points: readonly Point[], colour: string, strands: boolean): Mesh {
  const positions: number[] = [];
  const colours: number[] = [];
  const base = new Color(colour);
  const cuts = strands ? [0, 0.25, 0.75, 1] : [0, 1];
  net.quads.forEach((quad, q) => {
    const [a, b, c, d] = quad.map((v) => points[v]!) as [Point, Point, Point, Point];
    const at = (u: number, v: number): Point => blend(blend(a, b, u), blend(d, c, u), v);
    // Through sides 0 (a b) and 2: the band stands where u is in the middle.
    const [through0, through1] = net.crossing[q]!.map(
      (strand) => new Color(chooseTint(net.strands[strand]!.group)),
    ) as [Color, Color];
    for (let i = 0; i + 1 < cuts.length; i++) {
      for (let j = 0; j + 1 < cuts.length; j++) {
        const tint = base.clone();
        if (strands && i === 1 && j === 1) tint.copy(through0).lerp(through1, 0.5).multiplyScalar(0.92);
        else if (strands && i === 1) tint.copy(through0);
        else if (strands && j === 1) tint.copy(through1);
        const [u0, u1, v0, v1] = [cuts[i]!, cuts[i + 1]!, cuts[j]!, cuts[j + 1]!];
        const cell = [at(u0, v0), at(u1, v0), at(u1, v1), at(u0, v1)];
        for (const k of [0, 1, 2, 0, 2, 3]) positions.push(...cell[k]!);
        for (let k = 0; k < 6; k++) colours.push(tint.r, tint.g, tint.b);
      }
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
  geometry.computeVertexNormals();
  const mesh = new Mesh(geometry, findFaceMaterial(colour, LAYER.fill, true));
  mesh.renderOrder = LAYER.fill;
  return mesh;
}

/** Frees the shapes that the graphics card holds of an object and those below it. */
export function dispose(object: Object3D): void {
  object.traverse((part) => {
    if (part instanceof Mesh || part instanceof Points) {
      part.geometry.dispose();
    }
  });
  object.removeFromParent();
}
