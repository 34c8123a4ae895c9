// The panels' reasoning: parameters, plots, banners, the page's address. None of it needs a browser.
import assert from 'node:assert/strict';
import test from 'node:test';
import { loopBanner, linkBanner, lossBanner } from '../../../../clients/web/page/src/controls/banners.js';
import { labelOf, parameterRows, shortNumber, sliderScale } from '../../../../clients/web/page/src/controls/parameter_paths.js';
import { pauseMs, subprotocols } from '../../../../clients/web/stream/src/connection.js';
import { viewOf } from '../../../../clients/web/page/src/drawing/camera_views.js';
import { contactsOf, forceVector } from '../../../../clients/web/page/src/drawing/marks.js';
import { readAddress } from '../../../../clients/web/page/src/page_address.js';
import { LogHistogram, TimeSeries } from '../../../../clients/web/page/src/plots/series.js';
import { exampleOf } from '../stream/examples.js';

test('parameters come by string, with unit and range of their pattern', () => {
  const info = exampleOf('scene_event').item.scene_info;
  const [row] = parameterRows(info.parameters, [{ path: 'strings[0].tension_n', number: 30 }, { path: 'tones.level', text: 'X' }], info.scene);
  assert.deepEqual([row.group, row.label, row.unit, row.minimum, row.maximum], ['string C2', 'tension', 'N', 0, 1e6]);
  assert.deepEqual(labelOf('solver.margin_m', info.scene), { group: 'scene', label: 'solver margin' });
});

test('a slider goes from a tenth to ten times the value and back to where it was', () => {
  for (const row of [{ value: 30, minimum: 0, maximum: 1e6 }, { value: 1.9e11, minimum: 0, maximum: 1e13 }, { value: 0, minimum: 0, maximum: 1 }]) {
    const scale = sliderScale(row);
    assert.ok(Math.abs(scale.toValue(scale.toSlider(row.value)) - row.value) <= 1e-9 * row.value);
  }
  const scale = sliderScale({ value: 30, minimum: 0, maximum: 1e6 });
  assert.ok(Math.abs(scale.toValue(0) - 3) < 1e-9 && Math.abs(scale.toValue(1) - 300) < 1e-9);
  assert.deepEqual([0, 1.9e11, 0.00034, 30, 0.5].map(shortNumber), ['0', '1.9e+11', '3.4e-4', '30', '0.5']);
});

test('a plot keeps the last seconds, oldest first, and begins anew when time is set back', () => {
  const series = new TimeSeries(1, 8);
  for (let i = 0; i < 20; ++i) series.add(100 + i, [i]);
  assert.deepEqual(series.window(3), [[-3, -2, -1, 0], [16, 17, 18, 19]]);
  assert.equal(series.window(100)[0].length, 8);
  series.add(5, [1]);
  assert.deepEqual(series.window(100), [[0], [1]]);
});

test('the histogram holds the last values only, each in the bin whose edges enclose it', () => {
  const histogram = new LogHistogram({ least: 1, most: 4096, capacity: 10 });
  for (let i = 0; i < 50; ++i) histogram.add(1 + 7 * i);
  assert.equal(histogram.counts.reduce((sum, count) => sum + count, 0), 10);
  for (const value of [1, 3.3, 40, 999, 4000]) {
    const bin = histogram.binOf(value);
    assert.ok(histogram.edge(bin) <= value && value < histogram.edge(bin + 1));
  }
  assert.deepEqual([0.001, 1e9].map((value) => histogram.binOf(value)), [0, histogram.bins - 1]);
});

test('a fault names its cause and its remedy, and only who may clears it', () => {
  const state = { loop_state: 6, cause: 6 };
  const banner = loopBanner(state, { message: 'processor busy' }, () => {});
  assert.match(banner.title, /overrun/);
  assert.equal(banner.text, 'processor busy');
  assert.equal(banner.action[0], 'Clear fault');
  assert.ok(!loopBanner(state, null, null).action);
  assert.match(loopBanner(state, null, null).text, /doctor/);
  assert.equal(loopBanner({ loop_state: 4, cause: 0 }, null, null), null);
});

test('each way a link can fail has its own words, and loss is told from 2 % on', () => {
  const titles = [3, 4, 5, 6, 7].map((state) => linkBanner({ state, message: 'm' }).title);
  assert.equal(new Set(titles).size, 5);
  assert.equal(linkBanner({ state: 2 }), null);
  assert.equal(lossBanner({ loss: 0.019 }), null);
  assert.match(lossBanner({ loss: 0.2 }).title, /20 %/);
});

test('the address gives token and socket, and refuses a token that is none', () => {
  const address = readAddress('https://host:47880/haptic/?lod=high&magnify=10#token=abc_1-2');
  assert.deepEqual([address.token, address.high, address.magnify, address.socket], ['abc_1-2', true, 10, 'wss://host:47880/haptic/stream']);
  assert.deepEqual(subprotocols('abc'), ['hapticd.v1.abc']);
  assert.equal(readAddress('http://h/#token=a%20b').token, '');
  assert.equal(readAddress('http://h/').socket, 'ws://h/stream');
});

test('the page tries again ever more slowly, at least every 5 s', () => {
  assert.deepEqual([0, 1, 2, 4, 5, 50].map(pauseMs), [250, 500, 1000, 4000, 5000, 5000]);
});

test('contacts come out of their columns in metres and newtons, and crooked columns not at all', () => {
  const [patch] = exampleOf('contact_event').state.contacts;
  const contacts = contactsOf(patch);
  assert.deepEqual(contacts[0].point.map((value) => Number(value.toFixed(9))), [-0.25, 0.500001, 0]);
  assert.deepEqual([contacts[1].normal, contacts[0].forceN], [[-0.6, 0.8, 0], 1.5]);
  assert.equal(contactsOf({ ...patch, force_mn: [1] }).length, 0);
});

test('force arrows grow with the force up to a length, and keep its direction', () => {
  const [x, y] = forceVector([3, -4, 0]);
  assert.ok(Math.abs(x / y + 0.75) < 1e-12 && Math.abs(Math.hypot(x, y) - 0.1) < 1e-12);
  assert.ok(Math.hypot(...forceVector([0, 22, 0])) <= 0.2 + 1e-12);
});

test('in every preset the whole scene is before the eye, within the picture', () => {
  const box = { lower: [-0.6, -0.07, -0.1], upper: [0.6, 0.06, 0.1], centre: [0, -0.005, 0], size: 1.23 };
  for (const name of ['player', 'top']) {
    const { eye, target } = viewOf(name, { box, focus: [0, 0, 0], aspect: 1.4, fovDeg: 38 });
    const half = Math.tan((19 * Math.PI) / 180);
    const away = Math.hypot(...eye.map((value, i) => value - target[i]));
    assert.ok(half * 1.4 * away > 0.55, name);
    assert.ok(eye[1] > box.upper[1], name);
  }
});
