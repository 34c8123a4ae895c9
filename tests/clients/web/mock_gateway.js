// A gateway for working on the page without one: plays what capture_session.py wrote, again and again, to every page that asks, and answers
// requests as a daemon in a good mood would. Only for development and for tests of the page alone.
// usage: node mock_gateway.js PORT EVENTS|scripted FOLDER-OF-THE-PAGE FOLDER-OF-ASSETS
// Port 0 is any that is free; the address is the first line it writes. HAPTICD_PAGE_SOURCE is the page's folder with its node_modules.
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { extname, join, normalize } from 'node:path';
import { pathToFileURL } from 'node:url';
import { scriptedEvents } from './scripted_session.js';

const [port, eventsFile, page, assets] = process.argv.slice(2);
const source = process.env.HAPTICD_PAGE_SOURCE ?? new URL('../../../clients/web/page/', import.meta.url).pathname;
const require = createRequire(join(source, 'package.json'));
const { WebSocketServer } = require('ws');
const { v1, hex } = await import(pathToFileURL(require.resolve('hapticd-stream')));

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css' };
// As in clients/web/gateway/answer_head.cpp, but for the host.
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; font-src 'self'; manifest-src 'self'; connect-src 'self' ws:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** PageEvents of the capture. */
function readEvents(bytes) {
  const events = [];
  for (let at = 0; at + 4 <= bytes.length;) {
    const size = bytes.readUInt32LE(at);
    events.push(v1.PageEvent.decode(bytes.subarray(at + 4, at + 4 + size)));
    at += 4 + size;
  }
  return events;
}

const all = eventsFile === 'scripted' ? scriptedEvents() : readEvents(readFileSync(eventsFile));
const greeting = all.filter((event) => event.item?.scene_info || event.item?.record_info).slice(0, 2);
const names = new Map(greeting[0].item.scene_info.assets.map((asset) => [hex(asset.hash), asset.name]));
const instant = (event) => event.state?.t_ns ?? Object.values(event.item ?? {}).find((body) => body?.t_ns)?.t_ns;
const played = all.filter((event) => instant(event)).sort((a, b) => instant(a) - instant(b));
const first = instant(played[0]), lengthNs = instant(played.at(-1)) - first + 4e6;
const nowNs = () => performance.now() * 1e6 + 1e12;

function serve(request, response) {
  const path = normalize(new URL(request.url, 'http://mock').pathname);
  const asset = path.match(/^\/asset\/([0-9a-f]{64})$/);
  try {
    const file = asset ? join(assets, names.get(asset[1])) : join(page, path === '/' ? 'index.html' : path);
    response.writeHead(200, { 'Content-Type': TYPES[extname(file)] ?? 'application/octet-stream', 'Content-Security-Policy': POLICY });
    response.end(readFileSync(file));
  } catch {
    response.writeHead(404).end();
  }
}

function shifted(event, byNs) {
  if (event.state) return { state: { ...event.state, t_ns: event.state.t_ns + byNs } };
  const [kind, body] = Object.entries(event.item).find(([, value]) => value?.t_ns);
  return { item: { [kind]: { ...body, t_ns: body.t_ns + byNs } } };
}

/** As after Stop: a fault, whose cause says so. */
const stopped = (event) => (event.state ? { state: { ...event.state, loop_state: 6, cause: v1.Cause.CAUSE_STOPPED } } : event);

class Viewer {
  stopped = false;

  constructor(socket) {
    Object.assign(this, { socket, sequence: 0, next: 0, startNs: nowNs(), fence: 0 });
    this.send({ welcome: { version: 'mock', control: true, source: 1, presentation_delay_s: 0.008, steer: true } });
    greeting.forEach((event) => this.send(event));
    this.send({ item: { lease_info: { fence: 0, ttl_ms: 2000 } } });
    const timers = [setInterval(() => this.play(), 4), setInterval(() => this.link(), 1000)];
    this.link();
    socket.on('message', (data) => this.answer(v1.PageRequest.decode(new Uint8Array(data))));
    socket.on('close', () => timers.forEach(clearInterval));
  }

  send(body) {
    this.socket.send(v1.PageEvent.encode({ ...body, sequence: ++this.sequence }).finish());
  }

  link() {
    this.send({ link: { state: 2, clock_offset_s: 0.001, clock_error_s: 2e-4, round_trip_s: 4e-4, loss: Number(process.env.MOCK_LOSS ?? 0), bytes_per_s: 150000 } });
  }

  play() {
    for (;;) {
      const round = Math.floor(this.next / played.length), event = played[this.next % played.length];
      const byNs = this.startNs - first + round * lengthNs;
      if (instant(event) + byNs > nowNs()) return;
      this.send(this.stopped ? stopped(shifted(event, byNs)) : shifted(event, byNs));
      ++this.next;
    }
  }

  answer(request) {
    if (request.ping) this.send({ pong: { sent_s: request.ping.sent_s, daemon_t_ns: Math.round(nowNs()) } });
    if (request.list_recordings) this.send({ result: { item_id: request.id, code: 1, listing: { names: ['session.mcap'] } } });
    if (request.show) this.send({ result: { item_id: request.id, code: 2, message: 'the mock gateway has no recording' } });
    if (!request.call) return;
    const call = request.call;
    const result = { item_id: request.id, code: 1 };
    if (call.stop || call.clear) this.stopped = Boolean(call.stop);
    if (call.list_scenes) result.listing = { names: ['guqin', 'bunny', 'cabin'], descriptions: ['Guqin with a hand', 'A bunny and a frame', 'Pipes and cables'] };
    if (call.list_gestures) result.listing = { names: ['pluck_each', 'strum'], descriptions: [] };
    if (call.get_parameters) result.parameters = { values: [0, 1, 2].flatMap((i) => [{ path: `strings[${i}].tension_n`, number: 30 }, { path: `strings[${i}].youngs_modulus_pa`, number: 1.9e11 }, { path: `strings[${i}].decay_s`, number: 0.5 }]) };
    this.send({ result });
    // What the page gives back the desk takes at once.
    if (call.release) this.send({ item: { lease_info: { fence: ++this.fence, holder: 'desk', ttl_ms: 2000 } } });
    if (call.acquire) this.send({ item: { lease_info: { fence: ++this.fence, holder: 'web page', yours: true, ttl_ms: 2000, taken_from: call.acquire.take_over ? 'desk' : '', reason: call.acquire.take_over } } });
  }
}

const server = createServer(serve);
new WebSocketServer({ server, path: '/stream', handleProtocols: (protocols) => [...protocols][0] }).on('connection', (socket) => new Viewer(socket));
server.listen(Number(port), '127.0.0.1', () => console.log(`http://127.0.0.1:${server.address().port}/#token=mock`));
