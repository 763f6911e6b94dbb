/** Polygon meshes from OBJ and PLY files, and to OBJ. */

import type { Point } from "./vectors.ts";

export interface PolygonMesh {
  readonly points: readonly Point[];
  readonly faces: readonly (readonly number[])[];
}

/** What is wrong with a file, where, and what would mend it. */
export class MeshReadError extends Error {}

/** Reads a file by its content: PLY begins with "ply", everything else is read as OBJ. */
export function parseMesh(data: ArrayBuffer, name: string): PolygonMesh {
  const head = new TextDecoder().decode(data.slice(0, 4));
  const mesh = /^ply\s/.test(head) ? parsePly(data, name) : parseObj(new TextDecoder().decode(data), name);
  if (!mesh.faces.length) {
    throw new MeshReadError(`${name} has no faces: drop an OBJ or PLY file of a polygon mesh`);
  }
  return mesh;
}

export function parseObj(text: string, name: string): PolygonMesh {
  const points: Point[] = [];
  const faces: number[][] = [];
  text
    .replace(/\\\r?\n/g, " ")
    .split("\n")
    .forEach((line, row) => {
      const where = `${name}, line ${row + 1}`;
      const [keyword, ...rest] = line.trim().split(/\s+/);
      if (keyword === "v") {
        const [x, y, z] = rest.slice(0, 3).map(Number);
        if (![x, y, z].every(Number.isFinite)) {
          throw new MeshReadError(`${where}: a vertex needs three numbers`);
        }
        points.push([x!, y!, z!]);
      } else if (keyword === "f") {
        const face = rest.map((token) => {
          const index = Number.parseInt(token, 10);
          return index < 0 ? points.length + index : index - 1;
        });
        if (face.length < 3) throw new MeshReadError(`${where}: a face needs three vertices`);
        faces.push(face);
      }
    });
  return checkFaces({ points, faces }, name);
}

const SIZES: Record<string, number> = {
  char: 1, uchar: 1, int8: 1, uint8: 1, short: 2, ushort: 2, int16: 2, uint16: 2,
  int: 4, uint: 4, int32: 4, uint32: 4, float: 4, float32: 4, double: 8, float64: 8,
};

interface PlyProperty {
  readonly name: string;
  readonly type: string;
  /** The type of the count before a list; empty for a single value. */
  readonly counted: string;
}

interface PlyElement {
  readonly name: string;
  readonly count: number;
  readonly properties: PlyProperty[];
}

export function parsePly(data: ArrayBuffer, name: string): PolygonMesh {
  const latin = new TextDecoder("latin1").decode(data.slice(0, 65536));
  const end = /end_header\r?\n/.exec(latin);
  if (!end) throw new MeshReadError(`${name}: the PLY header has no end_header`);
  const elements: PlyElement[] = [];
  let format = "";
  for (const line of latin.slice(0, end.index).split(/\r?\n/)) {
    const words = line.trim().split(/\s+/);
    if (words[0] === "format") format = words[1] ?? "";
    if (words[0] === "element") {
      elements.push({ name: words[1] ?? "", count: Number(words[2]), properties: [] });
    }
    if (words[0] === "property") {
      const list = words[1] === "list";
      elements.at(-1)?.properties.push({
        name: words[list ? 4 : 2] ?? "",
        type: words[list ? 3 : 1] ?? "",
        counted: list ? (words[2] ?? "") : "",
      });
    }
  }
  const read = makePlyReader(data, end.index + end[0].length, format, name);
  const points: Point[] = [];
  const faces: number[][] = [];
  for (const element of elements) {
    for (let i = 0; i < element.count; i++) {
      const row: Record<string, number | number[]> = {};
      for (const property of element.properties) {
        row[property.name] = property.counted
          ? Array.from({ length: read(property.counted) }, () => read(property.type))
          : read(property.type);
      }
      if (element.name === "vertex") points.push([row.x as number, row.y as number, row.z as number]);
      const face = row.vertex_indices ?? row.vertex_index;
      if (element.name === "face" && Array.isArray(face)) faces.push(face);
    }
  }
  return checkFaces({ points, faces }, name);
}

function makePlyReader(
  data: ArrayBuffer,
  start: number,
  format: string,
  name: string,
): (type: string) => number {
  const short = new MeshReadError(`${name}: the PLY file ends too early`);
  if (format === "ascii") {
    const words = new TextDecoder().decode(data.slice(start)).trim().split(/\s+/);
    let next = 0;
    return () => {
      const value = Number(words[next++]);
      if (!Number.isFinite(value)) throw short;
      return value;
    };
  }
  const view = new DataView(data);
  const little = format === "binary_little_endian";
  let at = start;
  return (type) => {
    const size = SIZES[type];
    if (!size) throw new MeshReadError(`${name}: the PLY type ${JSON.stringify(type)} is not known`);
    if (at + size > data.byteLength) throw short;
    const from = at;
    at += size;
    if (/^(float|double)/.test(type)) {
      return size === 8 ? view.getFloat64(from, little) : view.getFloat32(from, little);
    }
    const signed = !type.startsWith("u");
    if (size === 1) return signed ? view.getInt8(from) : view.getUint8(from);
    if (size === 2) return signed ? view.getInt16(from, little) : view.getUint16(from, little);
    return signed ? view.getInt32(from, little) : view.getUint32(from, little);
  };
}

function checkFaces(mesh: PolygonMesh, name: string): PolygonMesh {
  mesh.faces.forEach((face, i) => {
    const bad = face.find((v) => !(v >= 0 && v < mesh.points.length));
    if (bad !== undefined) {
      throw new MeshReadError(`${name}: face ${i + 1} names a vertex that is not there`);
    }
  });
  return mesh;
}

/** Writes a mesh as OBJ, every number as it is. */
export function formatObj(mesh: PolygonMesh, remarks: readonly string[] = []): string {
  return [
    ...remarks.map((line) => `# ${line}`),
    ...mesh.points.map((p) => `v ${p.join(" ")}`),
    ...mesh.faces.map((face) => `f ${face.map((v) => v + 1).join(" ")}`),
    "",
  ].join("\n");
}

/** Cuts polygons into triangles, fan by fan: (3 t) vertex numbers. */
export function listTriangles(mesh: PolygonMesh): number[] {
  const triangles: number[] = [];
  for (const face of mesh.faces) {
    for (let i = 2; i < face.length; i++) triangles.push(face[0]!, face[i - 1]!, face[i]!);
  }
  return triangles;
}

/**
 * Joins a hole's fill to its mesh: old vertices and faces stay in their order, new ones follow.
 *
 * quads name vertices of the mesh, new ones from its number of vertices on. They are turned over
 * where their rim runs as that of the faces around does: welded faces run the other way.
 */
export function weldFill(
  mesh: PolygonMesh,
  quads: readonly (readonly number[])[],
  points: readonly Point[],
): PolygonMesh {
  const halfEdges = new Set<string>();
  for (const face of mesh.faces) {
    face.forEach((v, i) => halfEdges.add(`${v},${face[(i + 1) % face.length]}`));
  }
  const backwards = quads.some((quad) =>
    quad.some((v, i) => halfEdges.has(`${v},${quad[(i + 1) % 4]}`)),
  );
  const turned = backwards ? quads.map((quad) => [...quad].reverse()) : quads;
  return { points: [...mesh.points, ...points], faces: [...mesh.faces, ...turned] };
}
