// The page in a real browser, judged by what it draws: widths of strings in pixels, marks where independent projections say, two eyes, plots
// that advance, three viewers at once. The stream is scripted_session.js, every number of which is a closed form. Headless Chromium, software GL.
// usage: node --test browser_check.js, with the folder of the built page in HAPTICD_PAGE_OUT and that of its packages in HAPTICD_PAGE_SOURCE
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { CONTACT, DURATION_S, FINGER_RADIUS_M, fingerAt, RINGING, STRINGS } from '../scripted_session.js';

const source = process.env.HAPTICD_PAGE_SOURCE ?? new URL('../../../../clients/web/page/', import.meta.url).pathname;
const out = process.env.HAPTICD_PAGE_OUT ?? join(source, 'dist');
const { chromium } = createRequire(join(source, 'package.json'))('playwright-core');
const FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist', '--disable-background-networking', '--disable-quic',
  '--no-first-run', '--disable-sync'];

let mock, browser, page, profile, address;

before(async () => {
  const script = new URL('../mock_gateway.js', import.meta.url).pathname;
  mock = spawn(process.execPath, [script, '0', 'scripted', out, out], { env: { ...process.env, HAPTICD_PAGE_SOURCE: source }, stdio: ['ignore', 'pipe', 'inherit'] });
  address = await new Promise((resolve) => mock.stdout.once('data', (data) => resolve(String(data).trim())));
  profile = mkdtempSync(join(tmpdir(), 'hapticd-page-'));
  browser = await chromium.launchPersistentContext(profile, { executablePath: '/usr/bin/chromium', args: FLAGS, viewport: { width: 1280, height: 720 } });
  page = browser.pages()[0];
  await page.goto(address);
  await page.waitForFunction(() => window.hapticd?.picture.frames > 3 && window.hapticd.model.states.newest, null, { timeout: 60000 });
});

after(async () => {
  await browser?.close();
  mock?.kill();
  if (profile) rmSync(profile, { recursive: true, force: true });
});

/** Camera as numbers: position, axes of the picture in the world, focal length in pixels, size. */
const cameraOf = () => page.evaluate(() => {
  const { camera, renderer } = window.hapticd.picture.stage;
  const { clientWidth: width, clientHeight: height } = renderer.domElement;
  const e = camera.matrixWorld.elements;
  return { p: [e[12], e[13], e[14]], right: [e[0], e[1], e[2]], up: [e[4], e[5], e[6]], back: [e[8], e[9], e[10]], focalPx: height / 2 / Math.tan((camera.fov * Math.PI) / 360), width, height };
});

/** Flies to a camera preset and waits until it is there: how long that takes depends on how often the browser draws. */
async function lookFrom(view) {
  await page.click(`[data-view=${view}]`);
  await page.waitForFunction(() => !window.hapticd.picture.flight.flying, null, { timeout: 30000 });
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Pinhole by hand. */
function pixelOf(camera, at) {
  const d = at.map((value, i) => value - camera.p[i]);
  const depth = -dot(d, camera.back);
  return { x: camera.width / 2 + (camera.focalPx * dot(d, camera.right)) / depth, y: camera.height / 2 - (camera.focalPx * dot(d, camera.up)) / depth, depth };
}

test('a drawn string is as wide as its magnified R + r(t) at ten instants', async () => {
  await lookFrom('top');
  const camera = await cameraOf();
  const string = STRINGS[RINGING.index];
  const middle = string.p_wa_m.map((value, i) => (value + string.p_wb_m[i]) / 2);
  const at = pixelOf(camera, middle);
  for (let i = 0; i < 10; ++i) {
    const sinceS = 0.25 * i;
    const magnify = 3; // beyond it the envelopes of neighbours meet
    const rows = await page.evaluate(({ sinceS, magnify, x }) => {
      const { picture, model } = window.hapticd;
      const events = [];
      const { view, stage } = picture;
      // The instant of the newest release in this stream, then a frame as of `sinceS` after it, alone in the picture.
      const release = window.released;
      view.options.magnify = magnify;
      view.options.contacts = view.options.forces = view.options.depth = false;
      stage.table.visible = false;
      picture.draw(model.states.newest, release.t_ns + sinceS * 1e9);
      const gl = stage.renderer.getContext();
      const height = gl.drawingBufferHeight;
      const pixels = new Uint8Array(4 * height);
      gl.readPixels(Math.round(x), 0, 1, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      for (let row = 0; row < height; ++row) events.push([...pixels.subarray(4 * row, 4 * row + 3)]);
      return events.reverse();
    }, { sinceS, magnify, x: at.x, before: await remember() });
    const expected = (2 * magnify * (string.radius_m + RINGING.r_max_m * Math.exp(-sinceS / RINGING.decay_s)) * camera.focalPx) / at.depth;
    const width = litRows(rows, Math.round(at.y));
    assert.ok(Math.abs(width - expected) <= 2, `${width} px drawn, ${expected.toFixed(2)} px are R + r(${sinceS} s)`);
  }
  await page.evaluate(() => {
    const { picture } = window.hapticd;
    picture.stage.table.visible = true;
    document.getElementById('looks').oninput();
  });
});

/** A string that sounds from its place 0.25 on, as StringSounding tells it, and how far it swings at `s` of that part. */
const SOUNDING = { index: 1, from: 0.25, partialsM: [0.004, 0.002] };
const swingM = (s) => SOUNDING.partialsM[0] * Math.sin(Math.PI * s) + SOUNDING.partialsM[1] * Math.abs(Math.sin(2 * Math.PI * s));

test('a string that sounds has a band over its part alone, as wide at each place as its partials reach', async () => {
  await lookFrom('top');
  const camera = await cameraOf();
  const magnify = 1.5;
  const string = STRINGS[SOUNDING.index];
  const pointAt = (lambda) => string.p_wa_m.map((value, i) => value + (string.p_wb_m[i] - value) * lambda);
  const draw = (lambda) => page.evaluate(({ sounding, magnify, x }) => {
    const { picture, model } = window.hapticd;
    const { view, stage } = picture;
    view.options.magnify = magnify;
    view.options.contacts = view.options.forces = view.options.depth = false;
    stage.table.visible = false;
    for (const tool of view.tools) tool.solid.visible = tool.ghost.visible = false; // they would hide a string
    const { newest } = model.states;
    const told = { t_ns: newest.t_ns, string_index: sounding.index, number: 1, lambda_from: sounding.from, lambda_to: 1, frequency_hz: 98, cents_per_s: 0,
      partials_m: sounding.partialsM, decays_s: [1000, 1000] };
    const rings = { string_index: sounding.index, phase: 3, deflection_w_m: [], lambda: 0.3, radius_m: 0.003, sounding: told };
    const state = Object.assign(Object.create(newest), { tools: [], strings: [rings] });
    model.motion.soundings.clear();
    model.motion.soundings.addState(state);
    picture.draw(state, newest.t_ns);
    const gl = stage.renderer.getContext();
    const height = gl.drawingBufferHeight;
    const pixels = new Uint8Array(4 * height);
    gl.readPixels(Math.round(x), 0, 1, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return Array.from({ length: height }, (_, row) => [...pixels.subarray(4 * row, 4 * row + 3)]).reverse();
  }, { sounding: SOUNDING, magnify, x: pixelOf(camera, pointAt(lambda)).x });
  const widthPx = (radiusM, at) => (2 * magnify * radiusM * camera.focalPx) / at.depth;
  for (const s of [0.125, 0.25, 0.375, 0.5, 0.75, 0.875]) {
    const lambda = SOUNDING.from + (1 - SOUNDING.from) * s;
    const at = pixelOf(camera, pointAt(lambda));
    const width = litRows(await draw(lambda), Math.round(at.y));
    const expected = widthPx(string.radius_m + swingM(s), at);
    assert.ok(Math.abs(width - expected) <= 2, `${width} px drawn at ${s} of the part, ${expected.toFixed(2)} px are R + its swing`);
  }
  for (const lambda of [0.08, 0.2]) {
    const at = pixelOf(camera, pointAt(lambda));
    const width = litRows(await draw(lambda), Math.round(at.y));
    assert.ok(width >= 1 && width <= 2 + widthPx(string.radius_m, at), `${width} px drawn at ${lambda}, where nothing sounds`);
  }
  await page.evaluate(() => {
    const { picture, model } = window.hapticd;
    model.motion.soundings.clear();
    picture.stage.table.visible = true;
    for (const tool of picture.view.tools) tool.solid.visible = true;
    document.getElementById('looks').oninput();
  });
});

/** Notes the newest release as it arrives, in the page. */
async function remember() {
  await page.evaluate(() => {
    const { motion } = window.hapticd.model;
    if (window.released) return;
    const add = motion.add.bind(motion);
    motion.add = (event) => { window.released ??= event; add(event); };
  });
  await page.waitForFunction(() => window.released, null, { timeout: 30000 });
}

/** Rows around `y` that are not the background of the first row. */
function litRows(rows, y) {
  const lit = (row) => rows[row] && rows[row].some((value, i) => Math.abs(value - rows[0][i]) > 6);
  let above = y, below = y;
  while (lit(above - 1)) --above;
  while (lit(below + 1)) ++below;
  return lit(y) ? below - above + 1 : 0;
}

test('the contact is marked within 3 px of where a pinhole sees it', async () => {
  await lookFrom('player');
  const camera = await cameraOf();
  const expected = pixelOf(camera, CONTACT.point_um.map((value) => value * 1e-6));
  const found = await page.evaluate(({ x, y, far }) => {
    const { picture, model } = window.hapticd;
    picture.view.options.contacts = true;
    // Twice in a round the finger, or the arrow at the hand, is before the mark: here it is at the side.
    const newest = model.states.newest;
    const tool = Object.assign(Object.create(newest.tools[0]), { p_wg_m: far, p_wh_m: far });
    picture.draw(Object.assign(Object.create(newest), { tools: [tool] }), model.shownNs());
    const gl = picture.stage.renderer.getContext();
    const size = 60, left = Math.round(x) - size / 2, top = Math.round(y) - size / 2;
    const pixels = new Uint8Array(4 * size * size);
    gl.readPixels(left, gl.drawingBufferHeight - top - size, size, size, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    // Centre of all that has the yellow of a contact, #ffd54a.
    let count = 0, sumX = 0, sumY = 0;
    for (let row = 0; row < size; ++row) {
      for (let column = 0; column < size; ++column) {
        const [r, g, b] = pixels.subarray(4 * (row * size + column));
        if (Math.abs(r - 255) + Math.abs(g - 213) + Math.abs(b - 74) > 40) continue;
        ++count;
        sumX += column + 0.5;
        sumY += row + 0.5;
      }
    }
    return { count, x: left + sumX / count, y: top + size - sumY / count };
  }, { ...expected, far: fingerAt(DURATION_S / 4) });
  assert.ok(found.count >= 8, `${found.count} pixels have the colour of a contact`);
  assert.ok(Math.hypot(found.x - expected.x, found.y - expected.y) <= 3, `(${found.x}, ${found.y}) is not (${expected.x}, ${expected.y})`);
});

test('nearest string and its distance are the truth at 20 poses', async () => {
  for (let i = 0; i < 20; ++i) {
    const p = fingerAt((DURATION_S * i) / 20 + 0.01);
    const found = await page.evaluate((at) => {
      const { picture, model } = window.hapticd;
      const newest = model.states.newest;
      const tool = Object.assign(Object.create(newest.tools[0]), { p_wg_m: at });
      picture.draw(Object.assign(Object.create(newest), { strings: [], tools: [tool] }), model.shownNs() - 30e9);
      const [near] = picture.view.nearest;
      return { name: near.name, distanceM: near.distanceM };
    }, p);
    const truth = STRINGS.map((string) => ({ name: string.name, distanceM: distanceTo(string, p) - FINGER_RADIUS_M - string.radius_m })).sort((a, b) => a.distanceM - b.distanceM)[0];
    assert.equal(found.name, truth.name);
    assert.ok(Math.abs(found.distanceM - truth.distanceM) < 1e-6, `${found.distanceM} is not ${truth.distanceM}`);
  }
});

/** To the straight line through a string, |(p - a) x (b - a)| / |b - a|: all poses lie beside it, none beyond its ends. */
function distanceTo({ p_wa_m: a, p_wb_m: b }, p) {
  const u = b.map((value, i) => value - a[i]), v = p.map((value, i) => value - a[i]);
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  return Math.hypot(...n) / Math.hypot(...u);
}

test('what both eyes see is shifted less the farther away it is', async () => {
  const shifts = await page.evaluate(() => {
    const { picture } = window.hapticd;
    picture.setStereo('side');
    const { camera, renderer, scene } = picture.stage;
    const eyes = [];
    const render = renderer.render.bind(renderer);
    renderer.render = (what, eye) => {
      eye.updateMatrixWorld(true);
      eyes.push(eye.matrixWorldInverse.toArray(), eye.projectionMatrix.toArray());
    };
    picture.painter.draw(renderer, scene, camera, camera.position.distanceTo(picture.controls.target));
    renderer.render = render;
    picture.setStereo('off');
    const apply = (m, v) => [0, 1, 2, 3].map((row) => m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * v[3]);
    const seen = (view, projection, point) => { const c = apply(projection, apply(view, point)); return c[0] / c[3]; };
    const e = camera.matrixWorld.elements;
    return [0.4, 0.7, 1, 1.5, 3].map((depth) => {
      const point = [e[12] - e[8] * depth, e[13] - e[9] * depth, e[14] - e[10] * depth, 1];
      return seen(eyes[0], eyes[1], point) - seen(eyes[2], eyes[3], point);
    });
  });
  for (let i = 1; i < shifts.length; ++i) assert.ok(shifts[i] < shifts[i - 1], `${shifts}`);
  assert.ok(shifts[0] > 0 && shifts.at(-1) < 0, 'the focus lies between');
});

test('plots advance, and show what the stream says', async () => {
  for (const id of ['force', 'torque', 'margin', 'energy', 'ticks']) {
    const before = await page.evaluate((plot) => window.hapticd.panels.progress(plot), id);
    await page.waitForFunction(([plot, n]) => window.hapticd.panels.progress(plot) > n, [id, before], { timeout: 30000 });
  }
  const text = await page.textContent('[data-plot=margin] output');
  assert.match(text, /^1000 µm/);
  assert.match(await page.textContent('[data-plot=ticks] output'), /p50 30 · p99 35/);
});

test('three viewers at once all go on drawing', async () => {
  const pages = [page, await browser.newPage(), await browser.newPage()];
  await Promise.all(pages.slice(1).map((viewer) => viewer.goto(address)));
  for (const viewer of pages) {
    await viewer.bringToFront();
    const before = await viewer.evaluate(() => window.hapticd?.picture.frames ?? 0);
    await viewer.waitForFunction((n) => window.hapticd?.model.states.newest && window.hapticd.picture.frames > n + 2, before, { timeout: 60000 });
  }
  await Promise.all(pages.slice(1).map((viewer) => viewer.close()));
});
