// The WebSocket to the gateway: events in, requests out, each answered once. It comes back by itself after the gateway was restarted, ever
// more slowly up to 5 s; requests without an answer have failed then. What arrives is not interpreted here.
import { v1 } from './wire.js';

const PING_MS = 1000;
const LONGEST_PAUSE_MS = 5000;
const TRY_AGAIN_LATER = 1013; // RFC 6455's registry: too slow, or another page needed the place

/** Pause before attempt `n` (from 0), ms. */
export const pauseMs = (n) => Math.min(LONGEST_PAUSE_MS, 250 * 2 ** n);

/** {address, token} of the WebSocket to the gateway whose page has this URL; the token is behind #, which a browser sends to nobody. */
export function streamOf(url) {
  const { hash, protocol, host, pathname } = new URL(url);
  const token = new URLSearchParams(hash.slice(1)).get('token') ?? '';
  return {
    address: `${protocol === 'https:' ? 'wss:' : 'ws:'}//${host}${pathname.replace(/[^/]*$/, '')}stream`,
    token: /^[A-Za-z0-9_-]{1,128}$/.test(token) ? token : '',
  };
}

/** Subprotocols to offer: without a token one only looks. */
export function subprotocols(token) {
  return token ? [`hapticd.v1.${token}`] : ['hapticd.v1'];
}

export const monotonicS = () => performance.now() / 1000;

export class Connection {
  #socket = null;
  #attempt = 0;
  #nextId = 1;
  #waiting = new Map();
  #lastSequence = 0;
  #ping = 0;
  #next = 0;
  #closing = false;

  /** `handlers`: event(PageEvent), opened(), closed(), none of which has to be there; `pageS` a clock that never goes back, s. */
  constructor({ address, token = '', handlers = {}, pageS = monotonicS, makeSocket = (url, protocols) => new WebSocket(url, protocols) }) {
    Object.assign(this, { address, token, handlers, pageS, makeSocket });
    this.skippedEvents = 0;
    this.damagedEvents = 0;
    this.bytes = 0;
    this.goodbye = ''; // why the gateway closed it, as long as it may not come back for that
  }

  /** Connects, and again whenever the connection is lost, until close(). One that is connected or connecting stays as it is; one that waits
   *  to come back does so at once. */
  open() {
    this.#closing = false;
    if (this.#socket) return;
    clearTimeout(this.#next);
    let socket;
    try {
      socket = this.makeSocket(this.address, subprotocols(this.token));
    } catch (error) {
      console.error(error);
      this.#again();
      return;
    }
    socket.binaryType = 'arraybuffer';
    // What a socket says after close() is of no account: there may be another one by then.
    socket.onopen = () => {
      if (socket !== this.#socket) return;
      this.#attempt = 0;
      this.goodbye = '';
      this.#lastSequence = 0;
      this.#ping = setInterval(() => this.#sendPing(), PING_MS);
      this.handlers.opened?.();
      this.#sendPing();
    };
    socket.onmessage = ({ data }) => {
      if (socket === this.#socket) this.#receive(new Uint8Array(data));
    };
    socket.onclose = (event) => {
      if (socket !== this.#socket) return;
      if (event?.code === TRY_AGAIN_LATER) this.goodbye = event.reason;
      this.#closed();
    };
    this.#socket = socket;
  }

  get isOpen() {
    return this.#socket?.readyState === 1;
  }

  /** Sends an Item, as a plain object, to the daemon; resolves to its Result, or rejects when the connection goes first. */
  call(item) {
    return this.#request({ call: item }, true);
  }

  /** Seeks, pauses or paces a recording. */
  play(playback) {
    return this.#request({ playback }, false);
  }

  /** Asks the gateway to show a recording of its folder to all pages, or with an empty name the daemon; as call(). */
  show(recording) {
    return this.#request({ show: { recording } }, true);
  }

  /** Asks the gateway what it can show; as call(). */
  listRecordings() {
    return this.#request({ list_recordings: {} }, true);
  }

  /** Begins, answers or ends an experiment; as call(). */
  experiment(asked) {
    return this.#request({ experiment: asked }, true);
  }

  #request(body, answered) {
    if (!this.isOpen) return Promise.reject(new Error('not connected'));
    const id = this.#nextId++;
    this.#socket.send(v1.PageRequest.encode({ id, ...body }).finish());
    if (!answered) return Promise.resolve(null);
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  #sendPing() {
    if (this.isOpen) this.#request({ ping: { sent_s: this.pageS() } }, false).catch(() => {});
  }

  #receive(bytes) {
    this.bytes += bytes.length;
    let event;
    try {
      event = v1.PageEvent.decode(bytes);
    } catch {
      ++this.damagedEvents;
      return;
    }
    if (this.#lastSequence > 0 && event.sequence > this.#lastSequence + 1) {
      this.skippedEvents += event.sequence - this.#lastSequence - 1;
    }
    this.#lastSequence = event.sequence;
    if (event.result) this.#answer(event.result);
    else this.handlers.event?.(event);
  }

  #answer(result) {
    this.#waiting.get(result.item_id)?.resolve(result);
    this.#waiting.delete(result.item_id);
  }

  #closed() {
    this.#socket = null;
    clearInterval(this.#ping);
    for (const { reject } of this.#waiting.values()) reject(new Error('the connection was lost before the answer'));
    this.#waiting.clear();
    this.#again();
    this.handlers.closed?.();
  }

  /** Ends it until open(); what waits for an answer fails, and nothing more is heard of the socket. */
  close() {
    this.#closing = true;
    clearTimeout(this.#next);
    const socket = this.#socket;
    if (!socket) return;
    socket.close();
    if (socket === this.#socket) this.#closed();
  }

  #again() {
    if (!this.#closing) this.#next = setTimeout(() => this.open(), pauseMs(this.#attempt++));
  }
}
