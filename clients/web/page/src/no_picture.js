// Where there is no picture: what replaces it, and the words in its place. A browser may have no 3D drawing (remote desktops, old
// machines, software rendering refused), or take it away later.

/** Takes whatever is asked of a picture and draws nothing. */
export class NoPicture {
  view = null;
  drawnAs = [];
  viewName = '';
  following = false;
  followShare = 0;
  frames = 0;
  triangles = 0;
  options = {};
  assets = { missing: 0 };

  async setScene() {}
  look() {}
  setStereo() {}
  draw() {}
  project() { return null; }
}

const REST = 'Plots, control, the experiment and Stop work as ever.';

/** {title, text} by why there is none: 'fetched' (its program did not come), 'opened' (the browser gives no 3D drawing) or 'lost' (it took it away). */
export function noPictureWords(why, error) {
  const reason = error ? ` (The reason given: ${String(error.message ?? error).replace('THREE.WebGLRenderer: ', '')})` : '';
  if (why === 'lost') {
    return { title: 'The picture is gone', text: `The browser has taken the 3D drawing away: the graphics driver restarted, or memory ran short. ${REST} The picture comes back by itself as soon as it can; if it does not, load the page again.` };
  }
  if (why === 'fetched') return { title: 'No picture', text: `The program that draws did not arrive. ${REST} For the picture, load the page again.${reason}` };
  return { title: 'No picture', text: `This browser gives the page no 3D drawing (WebGL 2). ${REST} For the picture, switch hardware acceleration on in the browser’s settings, update browser and graphics driver, or open this address in another browser or on another machine.${reason}` };
}
