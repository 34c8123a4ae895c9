// What a player or a study does in the page, from its beginning to its end: a recording is made and replayed there.
// Truth: what the daemon says of itself to hapticctl.
import assert from 'node:assert/strict';
import { mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { freePort, hapticctl, playing, startBrowser, startDaemon, startGateway } from './programs.js';

const RINGING = 3; // STRING_PHASE_RINGING
const folder = mkdtempSync(join(tmpdir(), 'hapticd-control-'));
const recordings = join(folder, 'hapticd/recordings');
let at, daemon, gateway, browser, page;

const ctl = (...words) => hapticctl('--server', at, ...words);
const said = (text) => page.waitForFunction((wanted) => document.getElementById('said').textContent === wanted, text);

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at, [], { env: { XDG_STATE_HOME: folder } });
  gateway = await startGateway(['--server', at, '--recordings', recordings, '--experiments', join(folder, 'experiments')]);
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
  const begun = await page.evaluate(() => window.hapticd.model.states.newest.tick);
  await page.click('#record');
  await page.locator('#recorder-note', { hasText: 'Writing' }).waitFor();
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
  await other.waitForFunction(() => document.getElementById('playback-run').disabled && document.getElementById('playback-time').disabled);
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
  await page.fill('#experiment-participant', 'P1');
  await page.click('#experiment-begin');
  await recorded(page, false);
  await page.locator('#trial h2').waitFor();
  for (let presses = 0; presses < 2; ++presses) await page.click('#trial .end');
  await page.locator('#experiment-last', { hasText: 'P1: interrupted; 0 of 27 trials are kept' }).waitFor();
  await page.click('[data-tab=control]');
  await page.click('#lease');
  await page.waitForFunction(() => window.hapticd.session.controls);
});

test('a recording that is gone is named with what to do, and the daemon is shown on', async () => {
  const [file] = readdirSync(recordings);
  rmSync(join(recordings, file));
  await page.click('#replay');
  await page.waitForFunction((name) => document.getElementById('said').textContent.startsWith(`replay: ${name}: no such file`), file);
  assert.match(await page.textContent('#said'), /--recordings/);
  assert.equal(await page.evaluate(() => window.hapticd.model.recorded), false);
});
