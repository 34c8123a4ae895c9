// The viewer as a whole on one machine: hapticd, haptic-web and Chromium. What the page asks for is what the daemon does, by hapticctl's word;
// faults, restarts and many viewers; and scenes the viewer has never seen.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, readlinkSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { banner, freePort, hapticctl, playing, startBrowser, startDaemon, startGateway } from './programs.js';

const folder = mkdtempSync(join(tmpdir(), 'hapticd-live-'));
// What is installed beside hapticd, and so what haptic-web has by itself.
const INSTALLED = join(process.env.HAPTICD, '../../share/hapticd');
const FRAMES_WITHIN_MS = 60_000;
let at, daemon, gateway, browser, page;

const ctl = (...words) => hapticctl('--server', at, ...words);

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at);
  gateway = await startGateway(['--server', at]);
  browser = await startBrowser();
  page = browser.page;
  await page.goto(gateway.url);
  await playing(page);
  await page.click('[data-tab=control]');
});

after(async () => {
  await browser?.end();
  await gateway?.end();
  await daemon?.end();
  rmSync(folder, { recursive: true, force: true });
});

async function takeControl() {
  await page.click('#lease');
  await page.waitForFunction(() => window.hapticd.session.controls);
}

async function giveBack() {
  await page.click('#lease');
  await page.waitForFunction(() => !window.hapticd.session.controls);
}

test('a parameter set in the page is the one the daemon plays with', async () => {
  await takeControl();
  const path = 'strings[0].tension_n';
  const before = Number(ctl('get', path).match(/=\s*([0-9.e+-]+)/)[1]);
  const wanted = Number((before * 1.25).toFixed(1));
  const group = await page.locator('#parameter-group option', { hasText: /^string C2/ }).first().getAttribute('value');
  await page.selectOption('#parameter-group', group);
  const field = page.locator(`[data-path="${path}"]`);
  await field.fill(String(wanted));
  await field.press('Enter');
  await page.waitForFunction(() => /set parameter/.test(document.getElementById('said').textContent));
  assert.match(await page.textContent('#said'), /done/);
  assert.equal(Number(ctl('get', path).match(/=\s*([0-9.e+-]+)/)[1]), wanted);
  // What the daemon refuses is said, and the old value stands in the field again.
  await field.fill('-5');
  await field.press('Enter');
  await page.waitForFunction(() => document.getElementById('said').classList.contains('bad'));
  assert.equal(Number(await field.inputValue()), wanted);
  assert.equal(Number(ctl('get', path).match(/=\s*([0-9.e+-]+)/)[1]), wanted);
  await giveBack();
});

test('a fault has a banner with its cause, and goes when it is cleared there', async () => {
  await page.click('#stop');
  assert.match(await banner(page, 'loop', 'Fault: stopped'), /No force/);
  assert.match(ctl('status'), /fault/i);
  await takeControl();
  await page.locator('.banner[data-kind=loop] button', { hasText: 'Clear fault' }).click();
  await page.waitForFunction(() => document.querySelector('.banner[data-kind=loop]') === null && document.getElementById('loop').textContent === 'engaged');
  assert.doesNotMatch(ctl('status'), /fault/i);
  await giveBack();
});

test('after a restart of the daemon the page goes on, without being loaded again', async () => {
  await page.evaluate(() => { window.neverLoadedAgain = true; });
  await daemon.end('SIGKILL');
  await banner(page, 'link', 'The daemon is gone');
  daemon = await startDaemon(at);
  await page.waitForFunction(() => document.querySelector('.banner[data-kind=link]') === null && document.getElementById('link').textContent === 'live');
  const tick = await page.evaluate(() => window.hapticd.model.states.newest?.tick ?? 0);
  await page.waitForFunction((then) => window.hapticd.model.states.newest?.tick > then, tick);
  assert.equal(await page.evaluate(() => window.neverLoadedAgain), true);
});

test('three viewers at once all go on drawing new States, and one subscription feeds them', async (context) => {
  const pages = [page, await browser.newPage(), await browser.newPage()];
  for (const viewer of pages.slice(1)) await viewer.goto(gateway.url);
  for (const viewer of pages) {
    await viewer.bringToFront();
    await playing(viewer);
    const seen = await viewer.evaluate(() => ({ frames: window.hapticd.picture.frames, tick: window.hapticd.model.states.newest.tick }));
    await viewer.waitForFunction(({ frames, tick }) => window.hapticd.picture.frames > frames + 2 && window.hapticd.model.states.newest?.tick > tick, seen,
      { timeout: FRAMES_WITHIN_MS });
  }
  const metrics = await readMetrics();
  assert.equal(metrics.get('haptic_web_viewers'), 3);
  assert.equal(metrics.get('haptic_web_link_state'), 2, 'live');
  assert.equal(metrics.get('hapticd_loop_state'), 4, 'engaged');
  // States go on being counted; a counter that stands still ends in the test's timeout.
  const states = 'haptic_web_states_total';
  while ((await readMetrics()).get(states) <= metrics.get(states)) await page.waitForTimeout(20);
  assert.equal(udpSockets(gateway.program.process.pid), 1);
  await page.bringToFront();
  await page.click('[data-tab=connection]');
  await page.waitForFunction(() => /[1-9]/.test(document.querySelector('[data-name="to this page"]')?.textContent ?? ''));
  context.diagnostic(`to each page: ${await page.textContent('[data-name="to this page"]')}; from the daemon: ${await page.textContent('[data-name="from the daemon"]')}`);
  await Promise.all(pages.slice(1).map((viewer) => viewer.close()));
});

/** Sockets of UDP that a process has open, by the system's word: one session with a daemon each. */
function udpSockets(pid) {
  const own = new Set(readdirSync(`/proc/${pid}/fd`).map((fd) => readlinkSync(`/proc/${pid}/fd/${fd}`).match(/^socket:\[(\d+)\]/)?.[1]));
  return readFileSync('/proc/net/udp', 'utf8').trim().split('\n').slice(1).filter((line) => own.has(line.trim().split(/\s+/)[9])).length;
}

async function readMetrics() {
  const text = await page.evaluate(() => fetch('metrics').then((answer) => answer.text()));
  return new Map(text.split('\n').filter((line) => line && !line.startsWith('#')).map((line) => [line.split(/[ {]/)[0], Number(line.split(' ').at(-1))]));
}

/** A scene with a mesh that nobody ships: a plate with another comment in its file, and so another hash. */
function unknownScene() {
  const models = join(INSTALLED, 'models');
  const made = join(folder, 'scene');
  mkdirSync(made, { recursive: true });
  const plate = readFileSync(join(models, 'plate.ply'));
  const header = plate.indexOf('\n') + 1;
  const format = plate.indexOf('\n', header) + 1;
  writeFileSync(join(made, 'raft.ply'), Buffer.concat([plate.subarray(0, format), Buffer.from('comment a raft that was never shipped\n'), plate.subarray(format)]));
  copyFileSync(join(models, 'plate_1000um.tree'), join(made, 'raft.tree'));
  writeFileSync(join(made, 'raft.textproto'), `name: "raft"
tools { name: "finger" parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 0.05, 0] } }
bodies { name: "raft" shape { tree: "raft.tree" mesh: "raft.ply" } pose_wb { p_m: [0, -0.01, 0] } }
`);
  return made;
}

test('a mesh the viewer never had comes by its hash from --assets, or its sphere tree is drawn', async () => {
  const made = unknownScene();
  const port = await freePort();
  const other = await startDaemon(`127.0.0.1:${port}`, ['--scene', join(made, 'raft.textproto')]);
  try {
    for (const [args, drawnAs, missing] of [[['--assets', made], 'mesh', 'none'], [[], 'spheres', /^1: drawn as spheres/]]) {
      const shows = await startGateway(['--server', `127.0.0.1:${port}`, ...args], { env: { HAPTICD_DATA: INSTALLED } });
      try {
        await page.goto(shows.url);
        await page.waitForFunction(() => window.hapticd?.picture.drawnAs.length > 0);
        assert.equal(await page.evaluate(() => window.hapticd.picture.drawnAs[0]), drawnAs);
        assert.ok(await page.evaluate(() => window.hapticd.picture.stage.things.getObjectByName('raft')?.geometry.getAttribute('position').count > 8));
        await page.click('[data-tab=connection]');
        await page.waitForSelector('[data-name="files missing"]');
        assert.match(await page.textContent('[data-name="files missing"]'), new RegExp(missing));
      } finally {
        await shows.end();
      }
    }
  } finally {
    await other.end();
  }
});
