// A SceneInfo becomes what is drawn; walls, slack cables and boxes against what their numbers say.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import test from 'node:test';
import { flatPart, sagging, sceneModel } from '../../../../clients/web/stream/src/scene_model.js';
import { textOf } from '../../../../clients/web/stream/src/text_format.js';
import { hex, v1 } from '../../../../clients/web/stream/src/wire.js';
import { exampleOf } from './examples.js';

const info = () => exampleOf('scene_event').item.scene_info;

test('shapes carry the hash of what can be fetched, and nothing for what cannot', () => {
  const [part] = sceneModel(info()).tools[0].parts;
  assert.deepEqual(part.mesh, { hash: `${'0102030405060708'.repeat(3)}01020304050607ff`, size: 42 });
  assert.equal(part.tree, null);
  assert.equal(part.spheres, null);
});

test('one radius serves all spheres of a shape', () => {
  assert.deepEqual([...sceneModel(info()).bodies[0].spheres], [0, 0, 0, 0.25, 1, 0, 0, 0.25]);
});

test('a pose that is not a unit quaternion is one afterwards', () => {
  assert.deepEqual(sceneModel(info()).tools[0].pose, { p: [0, 1, 0], q: [0, 0, 1, 0] });
});

test('the box holds strings, lines, spheres and tools, and is not stretched by a wall', () => {
  const { lower, upper } = sceneModel(info()).box;
  assert.deepEqual(lower, [-1, -0.25, 0]);
  assert.deepEqual(upper, [1.25, 1, 3.25]);
});

test('a slack cable hangs by its sag in a parabola', () => {
  const points = sagging([-1, 0, 0], [1, 0.2, 0], 0.05);
  assert.equal(points.length, 6);
  for (const [x, y] of points) assert.ok(Math.abs(y - (0.1 + 0.1 * x - 0.05 * (1 - x * x))) < 1e-12);
});

test('of a wall of a kilometre the part toward the scene is drawn', () => {
  const { point, normal } = flatPart([0, 0, -1000, 1000], [0, 0, 0.1]);
  assert.ok(Math.abs(point[2]) < 1e-9 && Math.abs(normal[2] - 1) < 1e-12);
});

test('a scene as text is the scene: protoc reads the same bytes from it', () => {
  const scene = info().scene;
  const proto = process.env.HAPTICD_PROTO ?? new URL('../../../../proto', import.meta.url).pathname;
  const made = execFileSync('protoc', [`--proto_path=${proto}`, '--encode=hapticd.v1.Scene', 'hapticd/v1/scene.proto'], { input: textOf(scene) });
  assert.equal(hex(made), hex(v1.Scene.encode(scene).finish()));
});
