// The connection over a socket of the test, with timers that the test moves: it comes back ever more slowly until it is closed, requests without an
// answer fail, and what is no message is counted and left out.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Connection, streamOf } from '../../../../clients/web/stream/src/connection.js';
import { StreamModel } from '../../../../clients/web/stream/src/stream_model.js';
import { v1 } from '../../../../clients/web/stream/src/wire.js';

/** A connection, and the sockets that it has made, which close as those of a browser do: later. */
function opened(options = {}) {
  const sockets = [];
  const makeSocket = (url, protocols) => {
    const socket = { url, protocols, readyState: 0, sent: [], send: (data) => socket.sent.push(v1.PageRequest.decode(data)) };
    socket.close = () => {
      socket.readyState = 2;
      queueMicrotask(() => {
        socket.readyState = 3;
        socket.onclose();
      });
    };
    sockets.push(socket);
    return socket;
  };
  const connection = new Connection({ address: 'ws://h/stream', makeSocket, ...options });
  connection.open();
  connect(sockets[0]);
  return { connection, sockets };
}

function connect(socket) {
  socket.readyState = 1;
  socket.onopen();
}

/** All sockets have said that they are closed. */
const settled = () => new Promise((resolve) => setImmediate(resolve));

/** Timers that the test moves, for as long as the test `t` runs; Node 18 has none. */
function movedTimers(t) {
  const { setTimeout: real, clearTimeout: clear } = globalThis;
  let now = 0;
  const due = new Map();
  globalThis.setTimeout = (action, ms) => due.set((due.last = (due.last ?? 0) + 1), { action, at: now + ms }) && due.last;
  globalThis.clearTimeout = (id) => due.delete(id);
  t.after(() => Object.assign(globalThis, { setTimeout: real, clearTimeout: clear }));
  return {
    tick(ms) {
      now += ms;
      for (const [id, { action, at }] of [...due]) if (at <= now && due.delete(id)) action();
    },
  };
}

const message = (event) => ({ data: v1.PageEvent.encode(event).finish() });

test('without any handler it opens, asks and is answered', async () => {
  const { connection, sockets } = opened();
  const asked = connection.call({ ping: {} });
  const { id } = sockets[0].sent.at(-1);
  sockets[0].onmessage(message({ sequence: 1, result: { item_id: id, code: v1.ResultCode.RESULT_CODE_OK } }));
  assert.equal((await asked).code, v1.ResultCode.RESULT_CODE_OK);
  sockets[0].onmessage(message({ sequence: 2, link: { state: 1 } }));
  connection.close();
});

test('it comes back after a loss, and requests without an answer have failed', async (t) => {
  const timers = movedTimers(t);
  let closed = 0;
  const { connection, sockets } = opened({ handlers: { closed: () => ++closed } });
  const asked = assert.rejects(connection.call({ ping: {} }), /lost before the answer/);
  sockets[0].readyState = 3;
  sockets[0].onclose();
  await asked;
  await assert.rejects(connection.call({ ping: {} }), /not connected/);
  for (const pause of [250, 500, 1000, 2000, 4000, 5000, 5000]) {
    const before = sockets.length;
    timers.tick(pause - 1);
    assert.equal(sockets.length, before);
    timers.tick(1);
    assert.equal(sockets.length, before + 1);
    sockets.at(-1).onclose();
  }
  assert.equal(closed, 8);
  connection.close();
});

test('once closed it stays closed, whenever that is, until it is opened again', async (t) => {
  const timers = movedTimers(t);
  const { connection, sockets } = opened();
  connection.close();
  await settled();
  timers.tick(60_000);
  assert.equal(sockets.length, 1);
  connection.open();
  sockets[1].onclose();
  connection.close(); // while it waits to come back
  await settled();
  timers.tick(60_000);
  assert.equal(sockets.length, 2);
});

test('closed and opened at once, it has one socket, and the old one is of no account', async (t) => {
  const timers = movedTimers(t);
  const seen = [];
  const { connection, sockets } = opened({ handlers: { opened: () => seen.push('opened'), closed: () => seen.push('closed'), event: () => seen.push('event') } });
  const lost = assert.rejects(connection.call({ ping: {} }), /lost before the answer/);
  connection.close();
  assert.equal(connection.isOpen, false);
  await lost;
  connection.open();
  sockets[0].onmessage(message({ sequence: 1, link: { state: 1 } }));
  connect(sockets[1]);
  const asked = connection.call({ ping: {} });
  await settled();
  timers.tick(60_000);
  assert.deepEqual([sockets.length, connection.isOpen, sockets[0].readyState], [2, true, 3]);
  sockets[1].onmessage(message({ sequence: 1, result: { item_id: sockets[1].sent.at(-1).id, code: v1.ResultCode.RESULT_CODE_OK } }));
  assert.equal((await asked).code, v1.ResultCode.RESULT_CODE_OK);
  assert.deepEqual(seen, ['opened', 'closed', 'opened']);
  connection.close();
});

test('a socket that was closed while it connected is of no account', async (t) => {
  movedTimers(t);
  const { connection, sockets } = opened();
  connection.close();
  connection.open();
  connection.close();
  sockets[1].onopen();
  await settled();
  assert.deepEqual([sockets.length, connection.isOpen, sockets[1].sent.length], [2, false, 0]);
});

test('opened twice, it has one socket', (t) => {
  const timers = movedTimers(t);
  const { connection, sockets } = opened();
  connection.open();
  assert.equal(sockets.length, 1);
  sockets[0].onclose();
  connection.open(); // while it waits to come back: at once
  connection.open(); // while it connects
  timers.tick(60_000);
  assert.equal(sockets.length, 2);
  connection.close();
});

test('what is no message is counted and left out, and the next one is taken', () => {
  const events = [];
  const { connection, sockets } = opened({ handlers: { event: (event) => events.push(event) } });
  const whole = message({ sequence: 1, item: { tone: { frequency_hz: 65.5, partials: [1, 0.5] } } });
  let damaged = 0;
  for (let size = 1; size < whole.data.length; ++size) {
    sockets[0].onmessage({ data: whole.data.subarray(0, size) });
    damaged = connection.damagedEvents;
  }
  sockets[0].onmessage({ data: Uint8Array.of(0xff, 0xff, 0xff) });
  assert.ok(damaged > 5);
  assert.equal(connection.damagedEvents, damaged + 1);
  events.length = 0;
  sockets[0].onmessage(whole);
  assert.equal(events[0].item.tone.frequency_hz, 65.5);
  connection.close();
});

test('a model takes whatever comes without a session or a handler', () => {
  const model = new StreamModel();
  for (const event of [{}, { state: {} }, { item: {} }, { item: { tone: {} } }, { item: { scene_info: { scene: {} } } }, { pong: {} }, { link: {} }, { welcome: {} },
    { playback: {} }, { shown: {} }, { item: { lease_info: {} } }, { item: { fault: { latched: true } } }, { experiment: {} }]) {
    model.take(v1.PageEvent.decode(v1.PageEvent.encode({ sequence: 1, ...event }).finish()));
  }
  assert.equal(model.session.lease.fence, 0);
  model.lost();
  assert.equal(model.shownNs(), null);
});

test('the address of the stream is that of the page, and only a token that can be one is offered', () => {
  assert.deepEqual(streamOf('https://host:47880/haptic/index.html?x=1#token=abc_1-2'), { address: 'wss://host:47880/haptic/stream', token: 'abc_1-2' });
  for (const bad of ['', '#token=', '#token=a%20b', `#token=${'a'.repeat(129)}`]) assert.equal(streamOf(`http://h/${bad}`).token, '');
  assert.throws(() => streamOf('nowhere'), TypeError);
});

test('why the gateway closed it is kept until it is open again, unless the gateway only ended', async (t) => {
  const timers = movedTimers(t);
  const { connection, sockets } = opened();
  sockets[0].onclose({ code: 1001, reason: 'the gateway ends' });
  assert.equal(connection.goodbye, '');
  timers.tick(5000);
  connect(sockets[1]);
  sockets[1].onclose({ code: 1013, reason: 'a place was needed' });
  assert.equal(connection.goodbye, 'a place was needed');
  timers.tick(5000);
  sockets[2].onclose({ code: 1006, reason: '' });
  assert.equal(connection.goodbye, 'a place was needed');
  timers.tick(5000);
  connect(sockets[3]);
  assert.equal(connection.goodbye, '');
  connection.close();
});
