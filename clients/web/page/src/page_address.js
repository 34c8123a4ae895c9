// What the page's address says: the token behind #, and how to draw.
//   ?lod=high    full meshes and richer light, for a machine with a GPU
//   ?view=NAME   camera preset to begin with; ?stereo=side|anaglyph; ?magnify=N; ?still hides what moves the eye from a picture

import { streamOf } from 'hapticd-stream';

/** {token, high, view, stereo, magnify, socket} of a URL. */
export function readAddress(url) {
  const { searchParams } = new URL(url);
  const { address, token } = streamOf(url);
  const magnify = Number(searchParams.get('magnify'));
  return {
    token,
    high: searchParams.get('lod') === 'high',
    view: searchParams.get('view') ?? 'player',
    stereo: searchParams.get('stereo') ?? 'off',
    magnify: magnify >= 1 && magnify <= 50 ? magnify : 1,
    socket: address,
  };
}
