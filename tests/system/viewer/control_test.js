// What a player or a study does in the page, from its beginning to its end: a recording is made and replayed there, and the experiment of the
// paper's Table 1 is gone through. Truth: what the daemon says of itself to hapticctl.
import assert from 'node:assert/strict';
import { mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { freePort, hapticctl, playing, requireOrSkip, startBrowser, startDaemon, startGateway } from './programs.js';

requireOrSkip();

const TRIALS = 27;
const RINGING = 3; // STRING_PHASE_RINGING
const STIFFENED = ['tension_n', 'youngs_modulus_pa', 'radius_m'];
const folder = mkdtempSync(join(tmpdir(), 'hapticd-control-'));
const recordings = join(folder, 'hapticd/recordings');
let at, daemon, gateway, browser, page;

const ctl = (...words) => hapticctl('--server', at, ...words);
const said = (text) => page.waitForFunction((wanted) => document.getElementById('said').textContent === wanted, text);

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at, [], { env: { XDG_STATE_HOME: folder } });
  gateway = await startGateway(['--server', at, '--recordings', recordings]);
  browser = await startBrowser();
  page = browser.page;
  await page.goto(gateway.url);
  await playing(page);
  await page.click('[data-tab=control]');
  await page.click('#lease');
  await page.waitForFunction(() => window.hapticd.session.controls);
});

after(async () => {
  await browser?.end();
  await gateway?.end();
  await daemon?.end();
  rmSync(folder, { recursive: true, force: true });
});

/** Waits until `page` shows a recording, or the daemon. */
const recorded = (target, is) => target.waitForFunction((wanted) => window.hapticd.model.recorded === wanted && window.hapticd.model.states.newest, is);

/** Stops the time of the recording that `page` shows. */
async function pause() {
  if (await page.evaluate(() => window.hapticd.model.playback.playing)) await page.click('#playback-run');
  await page.waitForFunction(() => !window.hapticd.model.playback.playing);
}

/** Puts the slider of `page` at `place` of 1000 and waits until the recording stands there; its newest State. */
async function moveTo(place) {
  await page.fill('#playback-time', String(place));
  const there = await page.waitForFunction((share) => {
    const { position_s, duration_s } = window.hapticd.model.playback;
    return Math.abs(position_s / duration_s - share) < 0.01 && window.hapticd.model.states.newest;
  }, place / 1000);
  return there.jsonValue();
}

test('what is recorded from the page is replayed there, to all pages, strings and all, and then the daemon goes on', async () => {
  await page.selectOption('#gestures', 'pluck_each');
  await page.selectOption('#arm', { label: 'firm arm' });
  await page.fill('#repeat', '0');
  await page.click('#play-gesture');
  await said('play gesture: done');
  await page.click('#record');
  await page.locator('#recorder-note', { hasText: 'Writing' }).waitFor();
  const begun = await page.evaluate(() => window.hapticd.model.states.newest.tick);
  await page.waitForFunction((tick) => window.hapticd.model.states.newest.tick > Number(tick) + 2000, begun);
  await page.waitForFunction((ringing) => window.hapticd.model.states.newest.strings.some(({ phase }) => phase === ringing), RINGING);
  await page.click('#record');
  await page.locator('#recorder-note', { hasText: 'Written' }).waitFor();
  const file = await (await page.waitForFunction(() => document.getElementById('recordings').value)).jsonValue();
  assert.equal(ctl('record', 'list').trim(), file);
  assert.match(await page.textContent('#replay-how'), new RegExp(`hapticctl replay ${file}`));
  const other = await browser.newPage();
  await other.goto(gateway.url.split('#')[0]);
  await playing(other);
  const last = await page.evaluate(() => window.hapticd.model.states.newest.tick);
  await page.click('#replay');
  await said('replay: done');
  await Promise.all([recorded(page, true), recorded(other, true)]);
  assert.equal(await other.textContent('#playback-name'), file);
  assert.equal(await other.isVisible('#playback-live'), false);
  await page.waitForFunction(() => window.hapticd.model.playback);
  await pause();
  const late = await moveTo(990);
  // What is shown is of the past, and near its end a string sounds, as one did when it was written.
  assert.ok(late.tick <= last && late.tick > begun);
  assert.ok(late.strings.some(({ phase }) => phase === RINGING), JSON.stringify(late.strings));
  assert.equal(await page.textContent('#link'), 'recording');
  assert.equal(await page.evaluate(() => window.hapticd.model.link.state), 2);
  if (process.env.HAPTICD_PICTURES) await page.screenshot({ path: join(process.env.HAPTICD_PICTURES, 'replay.png') });
  const early = await moveTo(250);
  assert.ok(early.tick < late.tick && early.tick >= begun);
  await page.selectOption('#playback-rate', '4');
  await page.click('#playback-run');
  await other.waitForFunction(() => window.hapticd.model.playback.rate === 4 && window.hapticd.model.playback.position_s === window.hapticd.model.playback.duration_s);
  const scene = await page.evaluate(() => window.hapticd.session.scene.id);
  await page.click('#playback-live');
  await said('live: done');
  await Promise.all([recorded(page, false), recorded(other, false)]);
  await page.waitForFunction((tick) => window.hapticd.model.states.newest.tick > tick, last);
  assert.equal(await page.evaluate(() => window.hapticd.model.scene.id), scene);
  assert.equal(await page.isVisible('#playback'), false);
  await page.click('#gesture-end');
  await said('play gesture: done');
  await other.close();
});

test('who begins the experiment while a recording is shown is back at the daemon', async () => {
  await page.click('#replay');
  await recorded(page, true);
  await page.click('[data-tab=experiment]');
  await page.click('#experiment-begin');
  await recorded(page, false);
  await page.locator('h2', { hasText: `Trial 1 of ${TRIALS}` }).waitFor();
  const trial = await presented(null);
  await page.click('#experiment .stop');
  await page.waitForFunction((before) => window.hapticd.model.scene && window.hapticd.model.scene.id !== before, trial.id);
  await page.click('[data-tab=control]');
});

test('a recording that is gone is named with what to do, and the daemon is shown on', async () => {
  const [file] = readdirSync(recordings);
  rmSync(join(recordings, file));
  await page.click('#replay');
  await page.waitForFunction((name) => document.getElementById('said').textContent.startsWith(`replay: ${name}: no such file`), file);
  assert.match(await page.textContent('#said'), /--recordings/);
  assert.equal(await page.evaluate(() => window.hapticd.model.recorded), false);
});

/** {id, values} of the scene that plays, once it is another than `before` and one of the experiment, which has no tones: by the daemon's SceneInfo. */
async function presented(before) {
  const found = await page.waitForFunction(({ before, fields }) => {
    const scene = window.hapticd.model.scene;
    return scene && scene.id !== before && !scene.scene.tones && { id: scene.id, values: fields.map((field) => scene.scene.strings[0][field]) };
  }, { before, fields: STIFFENED });
  return found.jsonValue();
}

test('all 27 trials of the experiment raise one value in one half, and right answers are counted as right', async () => {
  await page.click('[data-tab=experiment]');
  await page.fill('#experiment-seed', '7');
  let shown = { id: await page.evaluate(() => window.hapticd.model.scene.id) };
  await page.click('#experiment-begin');
  const raised = [];
  for (let trial = 1; trial <= TRIALS; ++trial) {
    await page.locator('h2', { hasText: `Trial ${trial} of ${TRIALS}` }).waitFor();
    const first = await presented(shown.id);
    await page.click('[data-half="1"]');
    shown = await presented(first.id);
    const ratios = shown.values.map((value, i) => value / first.values[i]);
    const changed = ratios.flatMap((ratio, i) => (Math.abs(ratio - 1) > 1e-6 ? [i] : []));
    assert.equal(changed.length, 1, `trial ${trial}: ${first.values} and ${shown.values}`);
    const ratio = ratios[changed[0]];
    raised.push(`${changed[0]} ${(100 * (Math.max(ratio, 1 / ratio) - 1)).toFixed(0)}`);
    await page.click(`[data-answer=${ratio > 1 ? 'second' : 'first'}]`);
  }
  await page.locator('#experiment-table').waitFor();
  const counts = new Map();
  for (const one of raised) counts.set(one, (counts.get(one) ?? 0) + 1);
  assert.deepEqual([...counts.keys()].sort(), [0, 1, 2].flatMap((i) => [30, 40, 50].map((percent) => `${i} ${percent}`)));
  assert.ok([...counts.values()].every((count) => count === 3));
  const cells = await page.locator('#experiment-table td').allTextContents();
  assert.equal(cells.filter((text) => text.startsWith('100 % (')).length, 9);
  const csv = decodeURIComponent((await page.locator('a[download]').getAttribute('href')).replace('data:text/csv,', ''));
  const rows = csv.trim().split('\n').filter((row) => /^\d/.test(row));
  assert.equal(rows.length, TRIALS);
  assert.ok(rows.every((row) => row.endsWith(',1')));
});
