// The page in browsers that lack something: no 3D drawing, 3D drawing that goes and comes again, no storage, and other things that parts of it
// need. Whatever is missing, Stop reaches the gateway by button and by Escape, and what does not need it works. And what a plot draws of a
// stream that lost States, in pixels. Headless Chromium, the stream of scripted_session.js.
// usage: node --test parts_check.js, with the folder of the built page in HAPTICD_PAGE_OUT and that of its packages in HAPTICD_PAGE_SOURCE
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';

const source = process.env.HAPTICD_PAGE_SOURCE ?? new URL('../../../../clients/web/page/', import.meta.url).pathname;
const out = process.env.HAPTICD_PAGE_OUT ?? join(source, 'dist');
const { chromium } = createRequire(join(source, 'package.json'))('playwright-core');
const FLAGS = ['--no-sandbox', '--disable-background-networking', '--disable-quic', '--no-first-run', '--disable-sync'];
const WITH_3D = [...FLAGS, '--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist'];
const WITHOUT_3D = [...FLAGS, '--disable-gpu', '--disable-3d-apis'];

let mock, address;

before(async () => {
  const script = new URL('../mock_gateway.js', import.meta.url).pathname;
  mock = spawn(process.execPath, [script, '0', 'scripted', out, out], { env: { ...process.env, HAPTICD_PAGE_SOURCE: source }, stdio: ['ignore', 'pipe', 'inherit'] });
  address = await new Promise((resolve) => mock.stdout.once('data', (data) => resolve(String(data).trim())));
});

after(() => mock?.kill());

/** A browser started with `flags`, for as long as `use` uses it. */
async function inBrowser(flags, use) {
  const profile = mkdtempSync(join(tmpdir(), 'hapticd-parts-'));
  const browser = await chromium.launchPersistentContext(profile, { executablePath: '/usr/bin/chromium', args: flags, viewport: { width: 1280, height: 720 } });
  browser.setDefaultTimeout(60000);
  try {
    await use(browser);
  } finally {
    await browser.close();
    rmSync(profile, { recursive: true, force: true });
  }
}

/** Presses Stop by `press`, sees the fault that the gateway answers with, and clears it. */
async function stops(page, press) {
  await press();
  await page.locator('.banner[data-kind=loop]', { hasText: 'Fault: stopped' }).waitFor();
  await page.evaluate(() => window.hapticd.session.ask({ clear: {} }));
  await page.waitForFunction(() => document.getElementById('loop').textContent === 'engaged');
}

async function stopsBothWays(page) {
  await page.waitForFunction(() => document.getElementById('link').textContent === 'live' && !document.getElementById('stop').disabled);
  await stops(page, () => page.click('#stop'));
  await stops(page, () => page.keyboard.press('Escape'));
}

/** Pixels of the canvas of a plot that have the colour `rgb`, by their column. */
const columnsOf = (page, id, rgb) => page.evaluate(([plot, colour]) => {
  const canvas = document.querySelector(`[data-plot=${plot}] canvas`);
  const { data, width, height } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const counts = new Array(width).fill(0);
  for (let i = 0; i < width * height; ++i) {
    if (colour.every((value, k) => Math.abs(data[4 * i + k] - value) < 24) && data[4 * i + 3] > 200) ++counts[i % width];
  }
  return counts;
}, [id, rgb]);

const WHITE = [0xf1, 0xf3, 0xf5]; // of |F|
const lit = (counts) => counts.filter((count) => count > 0).length;

async function plotsDraw(page) {
  await page.waitForSelector('[data-plot=force] canvas');
  const before = await page.evaluate(() => window.hapticd.panels.progress('force'));
  await page.waitForFunction((n) => window.hapticd.panels.progress('force') > n + 0.5, before);
  await page.waitForFunction(() => /N$/.test(document.querySelector('[data-plot=force] output').textContent));
  assert.ok(lit(await columnsOf(page, 'force', WHITE)) > 5, 'the plot of the force has a line');
}

test('without 3D drawing the picture’s place says so, and everything else works, Stop first', async () => {
  await inBrowser(WITHOUT_3D, async (browser) => {
    const page = browser.pages()[0];
    const errors = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.goto(address);
    await stopsBothWays(page);
    await page.waitForSelector('#no-picture', { state: 'visible' });
    assert.match(await page.textContent('#no-picture'), /No picture.*WebGL 2.*Plots, control, the experiment and Stop work.*hardware acceleration/s);
    assert.equal(await page.isVisible('#empty'), false);
    assert.equal(await page.textContent('#scene-name'), 'Seven strings, made up');
    await plotsDraw(page);
    await page.click('[data-tab=control]');
    await page.click('#lease');
    await page.waitForFunction(() => window.hapticd.session.controls);
    await page.waitForFunction(() => document.querySelectorAll('#scenes option').length === 3);
    await page.click('[data-tab=experiment]');
    await page.fill('#experiment-participant', 'P1');
    assert.ok(await page.isEnabled('#experiment-begin'));
    await page.click('[data-tab=connection]');
    await page.waitForFunction(() => /[1-9]/.test(document.querySelector('[data-name="to this page"]')?.textContent ?? ''));
    // Keys of the picture do no harm, and Escape stops while somebody types.
    for (const key of ['1', 'f', 'c', 's', 'm']) await page.keyboard.press(key);
    await page.click('[data-tab=experiment]');
    await page.focus('#experiment-participant');
    await stops(page, () => page.keyboard.press('Escape'));
    assert.deepEqual(errors, []);
  });
});

test('control that another client has is taken over with a reason that is asked for, and not without one', async () => {
  await inBrowser(WITHOUT_3D, async (browser) => {
    const page = browser.pages()[0];
    let reason = null;
    page.on('dialog', (dialog) => (reason === null ? dialog.dismiss() : dialog.accept(reason)));
    await page.goto(address);
    await page.click('[data-tab=control]');
    const says = (text) => page.waitForFunction((wanted) => document.getElementById('lease-note').textContent === wanted, text);
    await page.click('#lease');
    await says('This page controls.');
    await page.click('#lease');
    await says('Held by desk.');
    assert.equal(await page.textContent('#lease'), 'Take over…');
    for (reason of [null, '  ']) await page.click('#lease');
    await says('Held by desk.');
    reason = 'the desk was left';
    await page.click('#lease');
    await says('This page controls. Taken over from desk: the desk was left');
    assert.equal(await page.textContent('#lease'), 'Give back');
  });
});

// What a browser may lack or refuse, as a script that runs before the page's.
const LACKS = {
  'local storage': () => Object.defineProperty(window, 'localStorage', { get() { throw new DOMException('refused', 'SecurityError'); } }),
  ResizeObserver: () => { delete window.ResizeObserver; },
  matchMedia: () => { delete window.matchMedia; },
  WebAssembly: () => { delete window.WebAssembly; },
  Path2D: () => { delete window.Path2D; },
  'the canvas of plots and picture': () => { HTMLCanvasElement.prototype.getContext = () => { throw new Error('no canvas'); }; },
  'a canvas that gives nothing': () => { HTMLCanvasElement.prototype.getContext = () => null; },
  'WebGL 2': () => {
    const getContext = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function get(kind, ...more) { return kind === 'webgl2' ? null : getContext.call(this, kind, ...more); };
  },
  'sound and fonts': () => {
    delete window.AudioContext;
    Object.defineProperty(document, 'fonts', { get() { throw new Error('no fonts'); } });
  },
  'elements of the side': () => document.addEventListener('readystatechange', () => ['plots', 'control', 'experiment', 'trial', 'playback', 'looks'].forEach((id) => document.getElementById(id)?.remove())),
};

test('whatever else a browser lacks, Stop reaches the gateway by button and by Escape', async () => {
  await inBrowser(WITHOUT_3D, async (browser) => {
    for (const [what, take] of Object.entries(LACKS)) {
      const page = await browser.newPage();
      await page.addInitScript(take);
      await page.goto(address);
      await assert.doesNotReject(stopsBothWays(page), what);
      await page.close();
    }
  });
});

test('3D drawing that is taken away is said, and comes back with the picture; Stop works in between', async () => {
  await inBrowser(WITH_3D, async (browser) => {
    const page = browser.pages()[0];
    await page.goto(`${address.replace('#', '?lod=high#')}`);
    await page.waitForFunction(() => window.hapticd?.picture.frames > 3 && window.hapticd.model.states.newest);
    for (let round = 0; round < 2; ++round) {
      await page.evaluate(() => {
        const gl = window.hapticd.picture.stage.renderer.getContext();
        window.lose ??= gl.getExtension('WEBGL_lose_context');
        window.lose.loseContext();
      });
      await page.waitForSelector('#no-picture', { state: 'visible' });
      assert.match(await page.textContent('#no-picture'), /The picture is gone.*comes back by itself/s);
      const frames = await page.evaluate(() => window.hapticd.picture.frames);
      await stopsBothWays(page);
      await plotsDraw(page);
      assert.equal(await page.evaluate(() => window.hapticd.picture.frames), frames);
      await page.evaluate(() => window.lose.restoreContext());
      await page.waitForFunction((n) => window.hapticd.picture.frames > n + 3, frames);
      assert.equal(await page.isVisible('#no-picture'), false);
      const colours = await page.evaluate(() => {
        const { picture, model } = window.hapticd;
        picture.draw(model.states.newest, model.shownNs());
        const gl = picture.stage.renderer.getContext();
        const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
        gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return new Set(new Uint32Array(pixels.buffer)).size;
      });
      assert.ok(colours > 100, `${colours} colours are drawn`);
    }
  });
});

test('a plot has no line where States were lost, and a dot where one stands alone', async () => {
  await inBrowser(WITHOUT_3D, async (browser) => {
    const page = browser.pages()[0];
    await page.goto(address);
    await page.waitForSelector('[data-plot=force] canvas');
    for (const perS of [250, 1000 / 3, 25]) {
      const spans = [[0, 2], [4, 4], [5, 5.02], [7, 10]]; // s with States; between them they were lost
      const counts = await drawn(page, spans, perS);
      // |F| is 1 N throughout, so its colour stands in a row of pixels; the axis takes the left of the canvas.
      const first = counts.findIndex((count) => count > 0), last = counts.length - 1 - [...counts].reverse().findIndex((count) => count > 0);
      const column = (s) => first + ((last - first) * s) / 10;
      const isLit = (s, by = 0) => counts.slice(Math.round(column(s)) - by, Math.round(column(s)) + by + 1).some((count) => count > 0);
      for (let s = 0.1; s < 9.95; s += 0.05) {
        const inside = spans.some(([from, to]) => s >= from && s <= to);
        const near = spans.some(([from, to]) => Math.abs(s - from) < 0.08 || Math.abs(s - to) < 0.08);
        if (!near) assert.equal(isLit(s), inside, `${perS} States/s, ${s.toFixed(2)} s`);
      }
      assert.ok(isLit(4, 2) && isLit(5, 2), 'what stands alone is seen');
    }
  });
});

/** Columns of the plot of the force for States of 1 N in the given spans of time. */
async function drawn(page, spans, perS) {
  await page.evaluate(({ given, rate }) => {
    const { panels, model } = window.hapticd;
    model.handlers.state = () => {};
    panels.clear();
    for (const [from, to] of given) {
      for (let s = from; s <= to + 1e-9; s += 1 / rate) {
        panels.add({ tick: Math.round(s * 1000), t_ns: (1000 + s) * 1e9, part_index: 0, tools: [{ tool_id: 0, wrench_h_w: [0, 1, 0, 0, 0, 0], minimum_gap_m: 0 }] }, 0);
      }
    }
  }, { given: spans, rate: perS });
  await page.evaluate(() => new Promise((resolve) => setTimeout(resolve, 500)));
  return columnsOf(page, 'force', WHITE);
}
