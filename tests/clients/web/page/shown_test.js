// A recording in place of the daemon: what the page forgets and keeps when the source changes, and what it says of it. No browser.
import assert from 'node:assert/strict';
import test from 'node:test';
import { daemonBanner } from '../../../../clients/web/page/src/controls/banners.js';
import { shownText } from '../../../../clients/web/page/src/controls/connection_panel.js';
import { recordingChoices } from '../../../../clients/web/page/src/controls/recordings_panel.js';
import { Session } from '../../../../clients/web/page/src/controls/session.js';
import { StreamModel } from '../../../../clients/web/stream/src/stream_model.js';
import { v1 } from '../../../../clients/web/stream/src/wire.js';
import { exampleOf } from '../stream/examples.js';

const [LIVE, RECORDING] = [1, 2];
const SECOND = 1e9;

/** A model that has met a live daemon: its scene, a State at 100 s, a fault and a link. */
function met() {
  const told = [];
  const session = new Session({ call: () => Promise.reject(new Error('nobody')) });
  const model = new StreamModel({ session, pageS: () => 0, handlers: { scene: () => told.push('scene'), state: () => {}, playback: () => {}, shown: () => told.push('shown') } });
  const take = (body) => model.take(v1.PageEvent.decode(v1.PageEvent.encode({ sequence: 1, ...body }).finish()));
  take({ welcome: { version: '1', control: true, source: LIVE, presentation_delay_s: 0.008 } });
  take({ link: { state: 2 } });
  model.take(sceneEvent(1));
  take({ state: { tick: 9, t_ns: 100 * SECOND, scene_id: 1 } });
  take({ item: { fault: { latched: true, message: 'of now' } } });
  return { model, session, take, told };
}

/** The example's SceneInfo under another number. */
function sceneEvent(id) {
  const event = exampleOf('scene_event');
  event.item.scene_info.scene_id = id;
  return event;
}

const recording = (more = {}) => ({ shown: { source: RECORDING, recording: 'a.mcap', ...more } });

test('a recording begins with nothing of the daemon, and the panels keep the scene of the daemon', () => {
  const { model, session, take, told } = met();
  const live = session.scene;
  take(recording());
  assert.deepEqual([model.recorded, model.scene, model.states.newest, model.fault, model.steady], [true, null, null, null, false]);
  assert.ok(session.recorded);
  model.take(sceneEvent(5));
  take({ state: { tick: 1, t_ns: 3 * SECOND, scene_id: 5 } });
  assert.equal(model.shownNs(), 3 * SECOND);
  assert.equal(model.scene.id, 5);
  assert.equal(session.scene, live);
  assert.deepEqual(told, ['scene', 'shown', 'scene']);
});

test('back at the daemon nothing of the recording is left, and its scene is the panels’ again', () => {
  const { model, session, take } = met();
  take(recording());
  model.take(sceneEvent(5));
  take({ state: { tick: 1, t_ns: 3 * SECOND, scene_id: 5 } });
  take({ playback: { position_s: 1, duration_s: 2, rate: 1 } });
  take({ shown: { source: LIVE } });
  assert.deepEqual([model.recorded, model.scene, model.states.newest, model.playback, model.steady], [false, null, null, null, true]);
  assert.equal(session.recorded, false);
  model.take(sceneEvent(6));
  take({ state: { tick: 30, t_ns: 130 * SECOND, scene_id: 6 } });
  assert.equal(model.states.newest.tick, 30);
  assert.equal(session.scene.id, 6);
});

test('what is told anew of the same recording, and a daemon that goes, leave what is shown alone', () => {
  const { model, take } = met();
  take(recording());
  model.take(sceneEvent(5));
  take({ state: { tick: 1, t_ns: 3 * SECOND, scene_id: 5 } });
  take(recording({ daemon_fault: 'device lost' }));
  take({ link: { state: 7, message: 'gone' } });
  assert.equal(model.states.newest.tick, 1);
  assert.equal(model.shown.daemon_fault, 'device lost');
  assert.equal(model.link.state, 7);
});

test('who comes while a recording is shown, and who lost the gateway, know what is shown', () => {
  const { model, take } = met();
  model.lost();
  assert.equal(model.recorded, false);
  take({ welcome: { version: '1', source: RECORDING } });
  assert.ok(model.recorded);
  assert.equal(shownText(model.shown), 'a recording');
  take(recording({ cut_off: true }));
  assert.equal(shownText(model.shown), 'a.mcap, cut off');
  take(recording({ tools_only: true }));
  assert.match(shownText(model.shown), /^a.mcap, .*strings and contacts are in newer recordings$/);
  assert.equal(shownText({ source: LIVE }), 'live');
});

test('recordings of gateway and daemon are offered once each, and where they lie is said', () => {
  const choices = recordingChoices(['b.mcap', 'c.mcap'], ['a.mcap', 'b.mcap']);
  assert.deepEqual(choices.map(([name]) => name), ['a.mcap', 'b.mcap', 'c.mcap']);
  assert.deepEqual(choices.map(([name, text]) => text === name), [true, true, false]);
  assert.match(choices[2][1], /daemon/);
});

test('a fault of the daemon is told over a recording, with the way back for who may', () => {
  assert.equal(daemonBanner({ source: RECORDING, daemon_fault: '' }, null), null);
  assert.equal(daemonBanner(null, null), null);
  const banner = daemonBanner({ source: RECORDING, daemon_fault: 'device lost' }, () => {});
  assert.equal(banner.text, 'device lost');
  assert.equal(banner.action[0], 'Back to live');
  assert.ok(!daemonBanner({ daemon_fault: 'x' }, null).action);
});

test('a refusal to replay is said in the words of the gateway', async () => {
  const said = [];
  const session = new Session({ show: (name) => Promise.resolve(name === 'gone.mcap' ? { code: 7, message: 'gone.mcap: no such file', path: 'show.recording' } : { code: 1 }) });
  session.addEventListener('said', ({ detail }) => said.push(detail));
  await session.show('gone.mcap');
  await session.show('');
  assert.deepEqual(said, [{ ok: false, text: 'replay: gone.mcap: no such file (show.recording)' }, { ok: true, text: 'live: done' }]);
});
