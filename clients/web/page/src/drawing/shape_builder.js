// Turns the shapes of a scene into geometry: the mesh by its hash, simplified to its share of the budget; without one the spheres that are
// touched; walls as planes. Also keeps what the tool touches with, for the distance to the strings.
import { MeshoptSimplifier } from 'meshoptimizer/simplifier';
import * as THREE from 'three';
import { DEFAULT_BUDGET, shareTriangles, vertexNormals } from '../model/mesh_budget.js';
import { flatPart, isLarge, levelWithin, readSphereTree } from 'hapticd-stream';
import { transform } from 'hapticd-stream/vector';
import { readPly } from './ply.js';

const STRINGS_AND_MARKS = 1500; // of the budget, for what is not a mesh
const SPHERE_TRIANGLES = 20;

/**
 * Fetches the files of all `shapes` ({mesh, tree, spheres, copies}) and returns for each {geometry | null, spheres: Float64Array x y z r
 * of what is touched | null, drawnAs: 'mesh' | 'spheres' | 'flat' | 'nothing'}. `high` leaves meshes as they are.
 */
export async function buildShapes(shapes, assets, { high, towards }) {
  const loaded = await Promise.all(shapes.map(async (shape) => ({
    mesh: await assets.get(shape.mesh, readPly),
    tree: shape.spheres ? null : await assets.get(shape.tree, readSphereTree),
  })));
  const budget = high ? Infinity : DEFAULT_BUDGET - STRINGS_AND_MARKS;
  const wanted = shapes.map((shape, i) => ({ triangles: trianglesOf(shape, loaded[i]), copies: shape.copies }));
  const shares = high ? wanted.map((mesh) => mesh.triangles) : shareTriangles(wanted, budget);
  if (!high) await MeshoptSimplifier.ready.catch(() => {});
  return shapes.map((shape, i) => buildOne(shape, loaded[i], shares[i], towards));
}

function trianglesOf(shape, { mesh, tree }) {
  if (mesh) return mesh.indices.length / 3;
  return ((shape.spheres ?? tree?.leaves)?.length ?? 0) / 4 * SPHERE_TRIANGLES;
}

function buildOne(shape, { mesh, tree }, share, towards) {
  const spheres = shape.spheres ?? tree?.leaves ?? null;
  if (mesh) return { geometry: meshGeometry(mesh, share), spheres, drawnAs: 'mesh' };
  if (shape.spheres && isLarge(shape.spheres[3])) return { geometry: flatGeometry(shape, towards), spheres, drawnAs: 'flat' };
  const drawn = shape.spheres ?? (tree && levelWithin(tree.levels, Math.max(8, share / SPHERE_TRIANGLES)));
  if (!drawn) return { geometry: null, spheres, drawnAs: 'nothing' };
  return { geometry: spheresGeometry(drawn, share), spheres, drawnAs: 'spheres' };
}

/** Normals are those of the full mesh: what is left of it still shines as round. */
function meshGeometry(mesh, share) {
  const normals = vertexNormals(mesh.positions, mesh.indices);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(mesh.positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
  geometry.setIndex(new THREE.BufferAttribute(simplified(mesh, share), 1));
  return geometry;
}

function simplified(mesh, share) {
  if (mesh.indices.length / 3 <= share || !MeshoptSimplifier.supported) return mesh.indices;
  const [indices] = MeshoptSimplifier.simplify(mesh.indices, mesh.positions, 3, share * 3, 0.05);
  return indices;
}

/** All spheres as one geometry; a few of them round, many of them coarse. */
function spheresGeometry(spheres, share) {
  const count = spheres.length / 4;
  const detail = count * 320 <= share || count <= 4 ? 3 : count * 80 <= Math.max(share, 1600) ? 1 : 0;
  const unit = new THREE.IcosahedronGeometry(1, detail);
  const corners = unit.getAttribute('position');
  const positions = new Float32Array(count * corners.count * 3);
  const normals = new Float32Array(positions.length);
  for (let i = 0, at = 0; i < spheres.length; i += 4) {
    for (let k = 0; k < corners.count; ++k, at += 3) {
      const n = [corners.getX(k), corners.getY(k), corners.getZ(k)];
      for (let axis = 0; axis < 3; ++axis) {
        normals[at + axis] = n[axis];
        positions[at + axis] = spheres[i + axis] + spheres[i + 3] * n[axis];
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
  return geometry;
}

function flatGeometry(shape, towards) {
  const pose = shape.pose ?? { p: [0, 0, 0], q: [1, 0, 0, 0] };
  const sphere = [...transform(pose, [...shape.spheres.subarray(0, 3)]), shape.spheres[3]];
  const { point, normal } = flatPart(sphere, towards.centre);
  const geometry = new THREE.PlaneGeometry(2 * towards.size, 1.2 * towards.size);
  geometry.applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal)));
  geometry.translate(...point);
  // The plane is in the world already; the body's pose is applied once more when it is drawn.
  const q = new THREE.Quaternion(pose.q[1], pose.q[2], pose.q[3], pose.q[0]);
  geometry.applyMatrix4(new THREE.Matrix4().compose(new THREE.Vector3(...pose.p), q, new THREE.Vector3(1, 1, 1)).invert());
  return geometry;
}
