// Triangle meshes in PLY: three.js reads them, and what it reads is judged here. Faces have three or four corners. Whatever the bytes are, it
// ends with a whole mesh or an Error that says what is wrong.
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';

const HEADER_BYTES = 16384;
// Faces with colours or textures would each get vertices of their own; under other names they are passed over.
const PASSED_OVER = Object.fromEntries(['red', 'diffuse_red', 'r', 'diffuse_r', 'texcoord'].map((name) => [name, `unused_${name}`]));

/** {positions: Float32Array 3 n, indices: Uint32Array 3 m} */
export function readPly(bytes) {
  const geometry = parse(bytes);
  const positions = Float32Array.from(geometry.getAttribute('position').array);
  const vertices = positions.length / 3;
  const indices = Uint32Array.from(geometry.index?.array ?? []);
  const faces = facesPromised(bytes);
  if (vertices === 0 || faces === 0) throw new Error('PLY: no vertices or no faces');
  if (indices.length < 3 * faces) throw new Error('PLY: it ends too early, or a face has not three or four corners');
  if (indices.some((index) => index >= vertices)) throw new Error('PLY: a face names a vertex that is not there');
  return { positions, indices };
}

function parse(bytes) {
  const loader = new PLYLoader();
  loader.setPropertyNameMapping(PASSED_OVER);
  try {
    return loader.parse(bytes.slice().buffer);
  } catch (error) {
    throw new Error(`PLY: not readable: ${error.message}`);
  }
}

/** three.js passes over faces that it cannot read: how many the header says there are. */
function facesPromised(bytes) {
  const header = new TextDecoder('latin1').decode(bytes.subarray(0, HEADER_BYTES));
  return Number(/^element\s+face\s+(\d+)/m.exec(header)?.[1] ?? 0);
}
