// A film draws an instant once the gateway stands there and the scene's files are there, and not before. No browser: its few parts are stubs.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Film } from '../../../../clients/web/page/src/film.js';

const texts = new Map();
const classes = new Set();
globalThis.document = { body: { classList: classes }, getElementById: (id) => ({ set textContent(text) { texts.set(id, text); } }) };
globalThis.requestAnimationFrame = (draw) => setImmediate(draw);
const soon = () => new Promise((resolve) => setTimeout(resolve, 30));

/** A film of 8 s whose gateway answers when the test says so. */
function filming() {
  const stage = { asked: [], elapsed: [], drawn: 0, files: Promise.resolve(), seconds: 0 };
  const model = { recorded: true, playback: { position_s: 3, duration_s: 8, playing: true }, scene: {} };
  const panels = { seconds: 10, clear: () => ++stage.cleared };
  stage.film = new Film({ model, panels, session: { play: (wanted) => stage.asked.push(wanted) }, draw: (elapsedS) => ++stage.drawn && stage.elapsed.push(elapsedS), scene: () => stage.files });
  stage.says = (position_s, playing = false) => stage.film.heard({ position_s, playing });
  return Object.assign(stage, { panels, model, cleared: 0 });
}

test('a film begins with the recording at rest at its beginning, and tells its length', async () => {
  const stage = filming();
  stage.model.recorded = false;
  const begun = stage.film.begin('a strum');
  await soon();
  assert.equal(stage.film.rolling, false);
  stage.model.recorded = true;
  await soon();
  assert.deepEqual(stage.asked, [{ position_s: 0, playing: false, rate: 1 }]);
  assert.ok(stage.film.rolling && classes.has('film'));
  stage.says(0);
  assert.equal(await begun, 8);
  assert.deepEqual([texts.get('film-caption'), stage.panels.seconds, stage.cleared], ['a strum', 8, 1]);
});

test('an instant is drawn when the recording stands there, not while it is elsewhere or goes on', async () => {
  const stage = filming();
  const drawn = stage.film.frame(1.25);
  stage.says(1.21);
  stage.says(1.25, true);
  await soon();
  assert.equal(stage.drawn, 0);
  stage.says(1.25);
  assert.equal(await drawn, 1.25);
  assert.deepEqual([stage.drawn, texts.get('film-time')], [1, '1.25 s']);
});

test('an instant waits for the files of a scene that begins there', async () => {
  const stage = filming();
  let arrive;
  stage.files = new Promise((resolve) => { arrive = resolve; });
  const drawn = stage.film.frame(2);
  stage.says(2);
  await soon();
  assert.equal(stage.drawn, 0);
  arrive();
  await drawn;
  assert.equal(stage.drawn, 1);
});

test('what is drawn is told the time since the last instant, and none at first or after a jump back', async () => {
  const stage = filming();
  for (const at of [1, 1.5, 1.5, 0.5, 0.75]) {
    const drawn = stage.film.frame(at);
    stage.says(at);
    await drawn;
  }
  assert.deepEqual(stage.elapsed, [Infinity, 0.5, 0, Infinity, 0.25]);
});

test('an instant after the end is the end', async () => {
  const stage = filming();
  const drawn = stage.film.frame(9);
  stage.says(8);
  assert.equal(await drawn, 8);
});
