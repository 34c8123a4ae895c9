// The viewer in a browser without 3D drawing, as on remote desktops and old machines, with a real daemon: Stop by button and by Escape stops
// it, by hapticctl's word; what the link, the plots and the control of the page say is what the daemon does.
import assert from 'node:assert/strict';
import test, { after, before } from 'node:test';
import { banner, freePort, hapticctl, startBrowser, startDaemon, startGateway } from './programs.js';

let at, daemon, gateway, browser, page;

const ctl = (...words) => hapticctl('--server', at, ...words);

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at, ['--scene', 'single_string']);
  gateway = await startGateway(['--server', at]);
  browser = await startBrowser({ without3d: true });
  page = browser.page;
  await page.goto(gateway.url);
  await page.waitForFunction(() => document.getElementById('link').textContent === 'live' && !document.getElementById('stop').disabled);
});

after(async () => {
  await browser?.end();
  await gateway?.end();
  await daemon?.end();
});

/** Clears the fault in the page, as who controls. */
async function clear() {
  await page.click('[data-tab=control]');
  if (!(await page.evaluate(() => window.hapticd.session.controls))) await page.click('#lease');
  await page.waitForFunction(() => window.hapticd.session.controls);
  await page.locator('.banner[data-kind=loop] button', { hasText: 'Clear fault' }).click();
  await page.waitForFunction(() => document.getElementById('loop').textContent === 'engaged');
}

test('the picture’s place says that there is none, and what can be done', async () => {
  await page.waitForSelector('#no-picture', { state: 'visible' });
  assert.match(await page.textContent('#no-picture'), /WebGL 2.*hardware acceleration/s);
});

test('Stop by the button, and by Escape, is a fault of the daemon with its cause', async () => {
  for (const press of [() => page.click('#stop'), () => page.keyboard.press('Escape')]) {
    assert.doesNotMatch(ctl('status'), /fault/i);
    await press();
    await banner(page, 'loop', 'Fault: stopped');
    assert.match(ctl('status'), /fault.*stopped/is);
    await clear();
  }
});

test('plots advance, and a parameter set in the page is the daemon’s', async () => {
  await page.click('[data-tab=plots]');
  const before = await page.evaluate(() => window.hapticd.panels.progress('force'));
  await page.waitForFunction((n) => window.hapticd.panels.progress('force') > n, before);
  await page.waitForFunction(() => /N$/.test(document.querySelector('[data-plot=force] output').textContent));
  await page.click('[data-tab=control]');
  await page.waitForFunction(() => document.querySelectorAll('#scenes option').length > 1);
  const path = 'strings[0].tension_n';
  const wanted = Number((Number(ctl('get', path).match(/=\s*([0-9.e+-]+)/)[1]) * 1.25).toFixed(1));
  const result = await page.evaluate((assignment) => window.hapticd.session.ask({ set_parameter: { assignments: [assignment] } }), { path, number: wanted });
  assert.equal(result.code, 1, result.message);
  assert.equal(Number(ctl('get', path).match(/=\s*([0-9.e+-]+)/)[1]), wanted);
});
