import assert from "node:assert/strict";
import { test } from "node:test";
import { formatObj, parseObj, parsePly, weldFill } from "../source/meshfile.ts";
import { listIrregular, makeNet } from "../source/quadnet.ts";

const grid = (m: number, n: number): number[][] =>
  Array.from({ length: m * n }, (_, k) => {
    const v = Math.floor(k / m) * (m + 1) + (k % m);
    return [v, v + 1, v + m + 2, v + m + 1];
  });

test("strands of a grid are its rows and columns, two groups", () => {
  const net = makeNet(grid(4, 3), 20);
  assert.equal(net.strands.length, 7);
  assert.deepEqual(net.strands.map((s) => s.quads.length).sort(), [3, 3, 3, 3, 4, 4, 4]);
  assert.equal(new Set(net.strands.map((s) => s.group)).size, 2);
  assert.equal(net.edges.length, 31);
  assert.equal(net.onBorder.filter(Boolean).length, 14);
  assert.ok(net.crossing.every(([a, b]) => a >= 0 && b >= 0 && a !== b));
});

test("a corner of three quads has one irregular vertex and three strands", () => {
  const net = makeNet([[0, 1, 6, 5], [1, 2, 3, 6], [6, 3, 4, 5]], 7);
  assert.equal(net.strands.length, 3);
  const asked = new Map([0, 1, 2, 3, 4, 5].map((v) => [v, v % 2 ? 2 : 1]));
  assert.deepEqual(listIrregular(net, asked), [{ vertex: 6, valence: 3, border: false }]);
});

test("a ring of quads is a closed strand", () => {
  const ring = Array.from({ length: 6 }, (_, i) => [i, (i + 1) % 6, 6 + ((i + 1) % 6), 6 + i]);
  const net = makeNet(ring, 12);
  assert.deepEqual(net.strands.filter((s) => s.closed).map((s) => s.quads.length), [6]);
});

test("meshes are read from OBJ and PLY, and written", () => {
  const obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1/1/1 2/2/2 3 -1\n";
  const mesh = parseObj(obj, "a.obj");
  assert.deepEqual(mesh.faces, [[0, 1, 2, 3]]);
  assert.deepEqual(parseObj(formatObj(mesh, ["x"]), "b.obj"), mesh);
  assert.throws(() => parseObj("v 0 0 0\nf 1 2 3\n", "c.obj"), /c\.obj.*not there/);
  const ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  assert.deepEqual(parsePly(new TextEncoder().encode(ply).buffer, "a.ply").faces, [[0, 1, 2]]);
});

test("a welded fill runs against the faces around it", () => {
  // A frame of four quads around an empty one.
  const outer: [number, number, number][] = [[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0]];
  const inner: [number, number, number][] = [[1, 1, 0], [2, 1, 0], [2, 2, 0], [1, 2, 0]];
  const faces = [0, 1, 2, 3].map((i) => [i, (i + 1) % 4, 4 + ((i + 1) % 4), 4 + i]);
  const mesh = { points: [...outer, ...inner], faces };
  for (const quad of [[4, 5, 6, 7], [7, 6, 5, 4]]) {
    const welded = weldFill(mesh, [quad], []);
    const halves = welded.faces.flatMap((f) => f.map((v, i) => `${v},${f[(i + 1) % f.length]}`));
    assert.equal(new Set(halves).size, halves.length);
    assert.deepEqual(welded.faces.slice(0, 4), faces);
  }
});
