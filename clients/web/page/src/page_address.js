// What the page's address says: the token behind #, which a browser sends to nobody, and how to draw.
//   ?lod=high    full meshes and richer light, for a machine with a GPU
//   ?view=NAME   camera preset to begin with; ?stereo=side|anaglyph; ?magnify=N; ?still hides what moves the eye from a picture

/** {token, high, view, stereo, magnify, socket} of a URL. */
export function readAddress(url) {
  const { searchParams, hash, protocol, host, pathname } = new URL(url);
  const token = new URLSearchParams(hash.slice(1)).get('token') ?? '';
  const magnify = Number(searchParams.get('magnify'));
  return {
    token: /^[A-Za-z0-9_-]{1,128}$/.test(token) ? token : '',
    high: searchParams.get('lod') === 'high',
    view: searchParams.get('view') ?? 'player',
    stereo: searchParams.get('stereo') ?? 'off',
    magnify: magnify >= 1 && magnify <= 50 ? magnify : 1,
    socket: `${protocol === 'https:' ? 'wss:' : 'ws:'}//${host}${pathname.replace(/[^/]*$/, '')}stream`,
  };
}

/** Subprotocols to offer: without a token the page only looks. */
export function subprotocols(token) {
  return token ? [`hapticd.v1.${token}`] : ['hapticd.v1'];
}
