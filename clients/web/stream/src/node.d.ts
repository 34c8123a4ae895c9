// Types of node.js.
/** A WebSocket as a browser has it, for Connection's `makeSocket`. */
export function nodeSocket(url: string, protocols: string[]): import('./index.js').Socket;
