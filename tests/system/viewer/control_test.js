// What a player or a study does in the page, from its beginning to its end: a recording is made and replayed, and the experiment of the
// paper's Table 1 is gone through. Truth: what the daemon says of itself to hapticctl.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { freePort, hapticctl, playing, requireOrSkip, startBrowser, startDaemon, startGateway } from './programs.js';

requireOrSkip();

const TRIALS = 27;
const STIFFENED = ['tension_n', 'youngs_modulus_pa', 'radius_m'];
const folder = mkdtempSync(join(tmpdir(), 'hapticd-control-'));
let at, daemon, gateway, browser, page;

const ctl = (...words) => hapticctl('--server', at, ...words);
const said = (text) => page.waitForFunction((wanted) => document.getElementById('said').textContent === wanted, text);

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at, [], { env: { XDG_STATE_HOME: folder } });
  gateway = await startGateway(['--server', at]);
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

test('what is recorded from the page is offered there, and plays again in a viewer with a slider', async () => {
  await page.click('#record');
  await page.locator('#recorder-note', { hasText: 'Writing' }).waitFor();
  const begun = await page.evaluate(() => window.hapticd.model.states.newest.tick);
  await page.waitForFunction((tick) => window.hapticd.model.states.newest.tick > Number(tick) + 2000, begun);
  await page.click('#record');
  await page.locator('#recorder-note', { hasText: 'Written' }).waitFor();
  const offered = await (await page.waitForFunction(() => document.getElementById('recordings').value)).jsonValue();
  assert.equal(ctl('record', 'list').trim(), offered);
  const [, file] = (await page.textContent('#replay-how')).match(/haptic-web --replay (\S+?)\. /);
  const again = await startGateway(['--replay', join(folder, 'hapticd/recordings', file)]);
  const other = await browser.newPage();
  await other.goto(again.url);
  await playing(other);
  const pausing = await other.evaluate(() => window.hapticd.model.playback.playing);
  if (pausing) await other.click('#playback-run');
  await other.waitForFunction(() => !window.hapticd.model.playback.playing);
  for (const place of [750, 250]) {
    await other.fill('#playback-time', String(place));
    await other.waitForFunction((share) => {
      const { position_s, duration_s } = window.hapticd.model.playback;
      return duration_s > 1.5 && Math.abs(position_s / duration_s - share) < 0.01;
    }, place / 1000);
  }
  await other.close();
  await again.end();
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
