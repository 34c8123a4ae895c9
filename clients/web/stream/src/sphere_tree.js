// Reader of sphere-tree files (server/scene_io/sphere_tree_file.h has the layout): the leaves, which are what is touched, and the bounds of
// every level, of which a coarse one can be drawn where no mesh is known.

const WIDTH = 8;

/** {leaves: Float64Array 4 n of x y z r, levels: [Float64Array], coarsest first, the last one the leaves}. */
export function readSphereTree(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (new TextDecoder('latin1').decode(bytes.subarray(0, 8)) !== 'HDTREE\r\n') throw new Error('sphere-tree: not one');
  const [leafCount, nodeCount, levelCount, nameBytes] = [12, 16, 20, 24].map((at) => view.getUint32(at, true));
  let at = 28 + 32 + 16 + 32 + levelCount * 20 + nameBytes;
  // Each leaf takes 32 bytes, each node at least 2: no count of a broken file can make us allocate more than it is long.
  if (at + leafCount * 32 + nodeCount * 2 > bytes.length) throw new Error('sphere-tree: the file ends too early');
  const sphere = () => {
    const values = [0, 8, 16, 24].map((offset) => view.getFloat64(at + offset, true));
    at += 32;
    return values;
  };
  const leaves = new Float64Array(leafCount * 4);
  for (let i = 0; i < leafCount; ++i) leaves.set(sphere(), i * 4);
  const nodes = [];
  for (let i = 0; i < nodeCount; ++i) {
    const used = view.getUint8(at++);
    const inner = view.getUint8(at++);
    const node = { bounds: [], leaves: [] };
    for (let k = 0; k < WIDTH; ++k) {
      if (!((used >> k) & 1)) continue;
      if ((inner >> k) & 1) node.bounds.push(sphere());
      else {
        node.leaves.push(view.getUint32(at, true));
        at += 4;
      }
    }
    nodes.push(node);
  }
  return { leaves, levels: levelsOf(nodes, leaves) };
}

/** Nodes are breadth first, so the bounds of one level of nodes are the next level, with the leaves above it. */
function levelsOf(nodes, leaves) {
  const levels = [];
  const above = [];
  let begin = 0, end = 1;
  while (begin < end && end <= nodes.length) {
    const bounds = [];
    for (const node of nodes.slice(begin, end)) {
      bounds.push(...node.bounds);
      for (const leaf of node.leaves) above.push([...leaves.subarray(leaf * 4, leaf * 4 + 4)]);
    }
    levels.push(Float64Array.from([...above, ...bounds].flat()));
    begin = end;
    end += bounds.length;
  }
  levels.push(leaves);
  return levels;
}

/** The finest level of at most `most` spheres; the coarsest where even that one has more. */
export function levelWithin(levels, most) {
  return levels.findLast((level) => level.length / 4 <= most) ?? levels[0];
}
