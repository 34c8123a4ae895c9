// A WebSocket for Node, which has none of its own before version 22: new Connection({ ..., makeSocket: nodeSocket }).
import WebSocket from 'ws';

/** A socket that behaves as a browser's. A failure to connect is its close, as for every other loss. */
export function nodeSocket(url, protocols) {
  const socket = new WebSocket(url, protocols);
  socket.onerror = () => {};
  return socket;
}
