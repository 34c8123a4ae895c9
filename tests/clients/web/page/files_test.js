// Readers of meshes and sphere-trees against files put together byte by byte, whole and broken; and the budget of triangles.
import assert from 'node:assert/strict';
import test from 'node:test';
import { readPly } from '../../../../clients/web/page/src/drawing/ply.js';
import { shareTriangles, vertexNormals } from '../../../../clients/web/page/src/model/mesh_budget.js';
import { levelWithin, readSphereTree } from '../../../../clients/web/stream/src/sphere_tree.js';

const bytes = (text) => new TextEncoder().encode(text);
const HEAD = 'ply\nformat FORMAT 1.0\ncomment metres\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n';

function binarySquare() {
  const head = bytes(HEAD.replace('FORMAT', 'binary_little_endian'));
  const body = new DataView(new ArrayBuffer(4 * 12 + 1 + 16));
  [0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0].forEach((value, i) => body.setFloat32(4 * i, value, true));
  body.setUint8(48, 4);
  [0, 1, 2, 3].forEach((value, i) => body.setInt32(49 + 4 * i, value, true));
  return Uint8Array.from([...head, ...new Uint8Array(body.buffer)]);
}

test('a binary mesh and the same one in words are equal, and a square is two triangles', () => {
  const binary = readPly(binarySquare());
  const words = readPly(bytes(`${HEAD.replace('FORMAT', 'ascii')}0 0 0\n2 0 0\n2 1 0\n0 1 0\n4 0 1 2 3\n`));
  assert.deepEqual(binary, words);
  assert.deepEqual([...binary.indices], [0, 1, 2, 0, 2, 3]);
  assert.deepEqual([...vertexNormals(binary.positions, binary.indices)], [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1]);
});

test('a mesh that is cut off, or names vertices it has not, is refused', () => {
  const whole = binarySquare();
  for (const size of [3, 60, whole.length - 20, whole.length - 1]) assert.throws(() => readPly(whole.subarray(0, size)), /PLY/);
  const wrong = Uint8Array.from(whole);
  wrong[wrong.length - 4] = 200;
  assert.throws(() => readPly(wrong), /not there/);
});

test('a face of five corners is refused, not left out; doubles and faces with colours are read', () => {
  const ascii = HEAD.replace('FORMAT', 'ascii');
  assert.throws(() => readPly(bytes(`${ascii}0 0 0\n2 0 0\n2 1 0\n0 1 0\n5 0 1 2 3 0\n`)), /corners/);
  const body = '0 0 0\n2 0 0\n2 1 0\n0 1 0\n';
  const doubles = readPly(bytes(`${ascii.replaceAll('float', 'double')}${body}3 0 1 2\n`));
  assert.deepEqual([doubles.positions.length, ...doubles.indices], [12, 0, 1, 2]);
  assert.ok(doubles.positions instanceof Float32Array);
  const rgb = ['red', 'green', 'blue'].map((name) => `property uchar ${name}\n`).join('');
  const coloured = readPly(bytes(`${ascii.replace('end_header', `${rgb}end_header`)}${body}3 0 1 2 255 0 0\n`));
  assert.deepEqual([coloured.positions.length, ...coloured.indices], [12, 0, 1, 2]);
});

/** A tree of 3 leaves below 2 nodes: the root has leaf 0 and a bound, below which are leaves 1 and 2. */
function smallTree() {
  const out = [];
  const put = (size, write) => {
    const view = new DataView(new ArrayBuffer(size));
    write(view);
    out.push(...new Uint8Array(view.buffer));
  };
  const u32 = (value) => put(4, (view) => view.setUint32(0, value, true));
  const f64 = (...values) => values.forEach((value) => put(8, (view) => view.setFloat64(0, value, true)));
  out.push(...bytes('HDTREE\r\n'));
  [1, 3, 2, 2, 4].forEach(u32); // version, leaves, nodes, levels, bytes of the name
  out.push(...new Array(32).fill(0));
  f64(0.1, 0, 0, 0, 0, 9);
  for (const spheres of [2, 3]) {
    u32(spheres);
    f64(0.1, 0.1);
  }
  out.push(...bytes('mesh'));
  f64(1, 2, 3, 0.5, 4, 5, 6, 0.25, 7, 8, 9, 0.125);
  out.push(0b101, 0b100);
  u32(0);
  f64(5, 6, 7, 3);
  out.push(0b11, 0);
  [1, 2].forEach(u32);
  out.push(...new Array(32).fill(0));
  return Uint8Array.from(out);
}

test('a sphere-tree has its leaves, and a coarse level of leaves and bounds', () => {
  const { leaves, levels } = readSphereTree(smallTree());
  assert.deepEqual([...leaves], [1, 2, 3, 0.5, 4, 5, 6, 0.25, 7, 8, 9, 0.125]);
  assert.deepEqual([...levels[0]], [1, 2, 3, 0.5, 5, 6, 7, 3]);
  assert.equal(levelWithin(levels, 2), levels[0]);
  assert.equal(levelWithin(levels, 100), levels.at(-1));
  assert.equal(levelWithin(levels, 1), levels[0]);
});

test('a tree whose counts promise more than there is, is refused', () => {
  const broken = smallTree();
  new DataView(broken.buffer).setUint32(12, 4e9, true);
  assert.throws(() => readSphereTree(broken), /ends too early/);
  assert.throws(() => readSphereTree(bytes('not a tree at all, but long enough for its header .............')), /not one/);
});

test('all triangles together stay within the budget, ghosts counted twice, and no mesh vanishes', () => {
  const guqin = [10496, 1670, 1670, 2016, 1536, 1664].map((triangles) => ({ triangles, copies: 1 }));
  const hand = [7878, ...new Array(5).fill(980), ...new Array(5).fill(832)].map((triangles) => ({ triangles, copies: 2 }));
  const meshes = [...guqin, ...hand];
  const shares = shareTriangles(meshes, 10500);
  assert.ok(shares.reduce((sum, share, i) => sum + share * meshes[i].copies, 0) <= 10500);
  assert.ok(shares.every((share, i) => share >= 60 && share <= meshes[i].triangles));
  assert.ok(shares[0] === Math.max(...shares));
});

test('a scene that is small already is left as it is', () => {
  assert.deepEqual(shareTriangles([{ triangles: 900, copies: 1 }, { triangles: 12, copies: 2 }], 10500), [900, 12]);
});
