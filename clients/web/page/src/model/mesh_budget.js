// How many triangles each mesh of a scene may have: about 12 000 in all keep a processor without GPU at the speed of the screen, 70 000 do
// not. Large meshes give most; none goes below what it is recognised by.

export const DEFAULT_BUDGET = 12000;
const LEAST = 60; // of one mesh; a nail is still one

/** `meshes` [{triangles, copies}] -> triangles each may have. Their sum over the copies is at most `budget` unless the least exceeds it. */
export function shareTriangles(meshes, budget) {
  const shares = meshes.map((mesh) => Math.min(mesh.triangles, LEAST));
  const cost = () => meshes.reduce((sum, mesh, i) => sum + shares[i] * mesh.copies, 0);
  const wanted = meshes.reduce((sum, mesh, i) => sum + (mesh.triangles - shares[i]) * mesh.copies, 0);
  const factor = wanted > 0 ? Math.min(1, Math.max(0, budget - cost()) / wanted) : 0;
  return meshes.map((mesh, i) => Math.floor(shares[i] + (mesh.triangles - shares[i]) * factor));
}

/** Unit normals of the vertices, faces weighted by area: Float32Array 3 n. */
export function vertexNormals(positions, indices) {
  const normals = new Float32Array(positions.length);
  const at = (index, axis) => positions[index * 3 + axis];
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [indices[i], indices[i + 1], indices[i + 2]];
    const u = [0, 1, 2].map((axis) => at(b, axis) - at(a, axis));
    const v = [0, 1, 2].map((axis) => at(c, axis) - at(a, axis));
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c]) for (let axis = 0; axis < 3; ++axis) normals[corner * 3 + axis] += n[axis];
  }
  for (let i = 0; i < normals.length; i += 3) {
    const size = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let axis = 0; axis < 3; ++axis) normals[i + axis] /= size;
  }
  return normals;
}
