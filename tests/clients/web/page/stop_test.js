// Stop before all else: what wires it needs nothing but the session, and what other parts of the page throw stops none but themselves. No
// browser.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Connection } from '../../../../clients/web/stream/src/connection.js';
import { Session } from '../../../../clients/web/page/src/controls/session.js';
import { stopBanner, wireStop } from '../../../../clients/web/page/src/controls/stop.js';
import { NoPicture, noPictureWords } from '../../../../clients/web/page/src/no_picture.js';
import { Parts } from '../../../../clients/web/page/src/parts.js';

/** A wired Stop: what was asked of the daemon, which answers with `code` or, as an Error, not at all. */
function wired(code = 1) {
  const asked = [], told = [];
  const call = (item) => {
    asked.push(item);
    if (code instanceof Error) throw code;
    return Promise.resolve({ code, message: code === 1 ? '' : 'no' });
  };
  const session = new Session({ call });
  const button = {}, target = new EventTarget();
  wireStop({ button, session, target, told: (result) => told.push(result) });
  const press = (key, more = {}) => target.dispatchEvent(Object.assign(new Event('keydown', { cancelable: true }), { key, ...more }));
  const may = (is) => Object.assign(session, { mayControl: is }).changed();
  return { asked, told, session, button, press, may };
}

const soon = () => new Promise((resolve) => setImmediate(resolve));

test('button and Escape ask for Stop, once each, with any modifier and while a field is typed in', async () => {
  const { asked, told, button, press, may } = wired();
  may(true);
  await button.onclick();
  press('Escape');
  press('Escape', { shiftKey: true, ctrlKey: true });
  press('Escape', { repeat: true });
  press('a');
  await soon();
  assert.deepEqual(asked, [{ stop: {} }, { stop: {} }, { stop: {} }]);
  assert.deepEqual(told.map(({ ok }) => ok), [true, true, true]);
});

test('a page that may not control has no Stop, and its button says so as soon as that changes', async () => {
  const { asked, button, press, may } = wired();
  assert.equal(button.disabled, true);
  press('Escape');
  await button.onclick();
  assert.deepEqual(asked, []);
  may(true);
  assert.equal(button.disabled, false);
  may(false);
  assert.equal(button.disabled, true);
});

test('a Stop that does not arrive is said, whatever went wrong', async () => {
  for (const [code, words] of [[2, /no/], [new Error('not connected'), /not connected/]]) {
    const { told, button, may } = wired(code);
    may(true);
    await button.onclick();
    assert.equal(told.length, 1);
    assert.match(stopBanner(told[0]).text, words);
    assert.match(stopBanner(told[0]).text, /emergency stop/);
  }
  assert.equal(stopBanner({ ok: true, text: '' }), null);
});

test('a part that throws is told once while it throws the same, and gives what stands in for it', async () => {
  const told = [];
  const parts = new Parts((name, error) => told.push(`${name}: ${error.message}`));
  const silent = console.error;
  console.error = () => {};
  try {
    const broken = new Error('no storage');
    for (let i = 0; i < 3; ++i) assert.equal(parts.run('plots', () => { throw broken; }, null), null);
    assert.equal(parts.run('plots', () => 7, null), 7);
    assert.equal(await parts.load('picture', () => Promise.reject(new Error('gone')), 'nothing'), 'nothing');
    assert.equal(await parts.load('picture', async () => 8), 8);
    assert.equal(await parts.load('sound', () => { throw new Error('no sound'); }, 0), 0);
    new Parts(() => { throw new Error('worse'); }).run('x', () => { throw broken; });
  } finally {
    console.error = silent;
  }
  assert.deepEqual(told.slice(0, 3), ['plots: no storage', 'picture: gone', 'sound: no sound']);
});

test('a socket that cannot be made is tried again, and a listener that throws does not end that', () => {
  const later = [];
  const timers = [globalThis.setTimeout, console.error];
  globalThis.setTimeout = (action) => later.push(action);
  console.error = () => {};
  try {
    let made = 0;
    const socket = { readyState: 1 };
    const connection = new Connection({ address: 'ws://h/stream', token: '', pageS: () => 0, makeSocket: () => {
      ++made;
      if (made < 3) throw new Error('not allowed');
      return socket;
    }, handlers: { closed: () => { throw new Error('a listener'); } } });
    connection.open();
    later.shift()();
    later.shift()();
    assert.equal(made, 3);
    assert.throws(() => socket.onclose(), /a listener/);
    assert.equal(later.length, 1);
  } finally {
    [globalThis.setTimeout, console.error] = timers;
  }
});

test('in the place of the picture stands why there is none and what can be done', async () => {
  for (const [why, words] of [['opened', /WebGL 2.*hardware acceleration/s], ['fetched', /load the page again/], ['lost', /comes back by itself/]]) {
    const { title, text } = noPictureWords(why, why === 'lost' ? undefined : new Error('because'));
    assert.ok(title.length > 0);
    assert.match(text, words);
    assert.match(text, /Plots, control, the experiment and Stop work/);
    if (why !== 'lost') assert.match(text, /because/);
  }
  const none = new NoPicture();
  await none.setScene({});
  none.look('top');
  none.setStereo('side');
  none.draw(null, null);
  assert.deepEqual([none.project([0, 0, 0]), none.frames, none.assets.missing, none.view], [null, 0, 0, null]);
});
