// Reader of triangle meshes in PLY, binary little-endian or ASCII: positions and faces, as hapticd-model writes them and usual programs
// export them. Faces with more corners become fans. Whatever the bytes are, it ends with a mesh or an Error that says what is wrong.

const SIZES = { char: 1, int8: 1, uchar: 1, uint8: 1, short: 2, int16: 2, ushort: 2, uint16: 2, int: 4, int32: 4, uint: 4, uint32: 4,
  float: 4, float32: 4, double: 8, float64: 8 };

/** {positions: Float32Array 3 n, indices: Uint32Array 3 m} */
export function readPly(bytes) {
  const { header, bodyAt } = readHeader(bytes);
  const next = header.binary ? binaryReader(bytes, bodyAt) : textReader(bytes, bodyAt);
  const mesh = { positions: null, indices: null };
  for (const element of header.elements) {
    if (element.name === 'vertex') mesh.positions = readVertices(element, next);
    else if (element.name === 'face') mesh.indices = readFaces(element, next);
    else for (let i = 0; i < element.count; ++i) element.properties.forEach((property) => readProperty(property, next));
  }
  if (!mesh.positions || !mesh.indices) throw new Error('PLY: no vertices or no faces');
  const vertices = mesh.positions.length / 3;
  if (mesh.indices.some((index) => index >= vertices)) throw new Error('PLY: a face names a vertex that is not there');
  return mesh;
}

function readHeader(bytes) {
  const text = new TextDecoder('latin1').decode(bytes.subarray(0, 16384));
  const end = text.indexOf('end_header');
  if (!text.startsWith('ply') || end < 0) throw new Error('PLY: no header');
  const header = { binary: false, elements: [] };
  for (const line of text.slice(0, end).split('\n')) {
    const words = line.trim().split(/\s+/);
    if (words[0] === 'format') {
      if (words[1] === 'binary_big_endian') throw new Error('PLY: big-endian files are not read');
      header.binary = words[1] === 'binary_little_endian';
    } else if (words[0] === 'element') {
      header.elements.push({ name: words[1], count: Number(words[2]), properties: [] });
    } else if (words[0] === 'property') {
      header.elements.at(-1)?.properties.push(propertyOf(words));
    }
  }
  return { header, bodyAt: text.indexOf('\n', end) + 1 };
}

function propertyOf(words) {
  const types = words[1] === 'list' ? [words[2], words[3]] : [words[1]];
  if (types.some((type) => !SIZES[type])) throw new Error(`PLY: unknown type in "${words.join(' ')}"`);
  return { name: words.at(-1), type: types.at(-1), countType: types.length === 2 ? types[0] : null };
}

function binaryReader(bytes, start) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = start;
  const read = { char: 'getInt8', int8: 'getInt8', uchar: 'getUint8', uint8: 'getUint8', short: 'getInt16', int16: 'getInt16',
    ushort: 'getUint16', uint16: 'getUint16', int: 'getInt32', int32: 'getInt32', uint: 'getUint32', uint32: 'getUint32',
    float: 'getFloat32', float32: 'getFloat32', double: 'getFloat64', float64: 'getFloat64' };
  return (type) => {
    if (at + SIZES[type] > view.byteLength) throw new Error('PLY: the file ends too early');
    const value = view[read[type]](at, true);
    at += SIZES[type];
    return value;
  };
}

function textReader(bytes, start) {
  const words = new TextDecoder('latin1').decode(bytes.subarray(start)).split(/\s+/).filter((word) => word);
  let at = 0;
  return () => {
    if (at >= words.length) throw new Error('PLY: the file ends too early');
    return Number(words[at++]);
  };
}

function readProperty(property, next) {
  if (!property.countType) return next(property.type);
  const count = next(property.countType);
  return Array.from({ length: count }, () => next(property.type));
}

function readVertices(element, next) {
  const axes = ['x', 'y', 'z'].map((axis) => element.properties.findIndex((property) => property.name === axis));
  if (axes.includes(-1)) throw new Error('PLY: vertices without x, y and z');
  const values = [];
  for (let i = 0; i < element.count; ++i) {
    const row = element.properties.map((property) => readProperty(property, next));
    axes.forEach((axis) => values.push(row[axis]));
  }
  return Float32Array.from(values);
}

function readFaces(element, next) {
  const indices = [];
  for (let i = 0; i < element.count; ++i) {
    for (const property of element.properties) {
      const corners = readProperty(property, next);
      if (!Array.isArray(corners) || !property.name.startsWith('vertex_ind')) continue;
      for (let k = 2; k < corners.length; ++k) indices.push(corners[0], corners[k - 1], corners[k]);
    }
  }
  return Uint32Array.from(indices);
}
