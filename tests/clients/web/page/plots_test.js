// What a plot is drawn from: a line goes on while the stream does, at whatever pace, and breaks where a State is missing. The truth is the
// stream that the test makes: it knows which ticks it sent and which of them it lost. No browser.
import assert from 'node:assert/strict';
import test from 'node:test';
import { holesBefore, loneRows, sinceFirst, TimeSeries } from '../../../../clients/web/page/src/plots/series.js';

/** Uniform in [0, 1): mulberry32. */
function randomOf(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Ticks of a stream: `phases` of [divisor, count of States], each State of a tick that is a multiple of the divisor. */
function ticksOf(phases, first = 0) {
  const ticks = [];
  let tick = first;
  for (const [divisor, count] of phases) {
    for (let i = 0; i < count; ++i) {
      tick = (Math.floor(tick / divisor) + 1) * divisor;
      ticks.push(tick);
    }
  }
  return ticks;
}

/** A series that got `ticks`, with instants that jitter by up to a third of a millisecond. */
function seriesOf(ticks, random = () => 0.5) {
  const series = new TimeSeries(1, 4096);
  ticks.forEach((tick) => series.add(1000 + tick * 1e-3 + (random() - 0.5) * 0.6e-3, [tick], tick));
  return series;
}

/** Values of the window, null where there is a hole. */
const valuesOf = (ticks, random) => seriesOf(ticks, random).window(1e6)[1];

test('a stream that goes on has no hole, whatever its pace', () => {
  for (const divisor of [1, 2, 4, 7, 40, 1024]) {
    const ticks = ticksOf([[divisor, 50]]);
    assert.deepEqual(valuesOf(ticks, randomOf(divisor)), ticks);
  }
});

test('a lost State is a hole, and so are many, and a row between two holes stays', () => {
  const [a, b, c] = [[0, 4, 8], [12], [20, 24, 28]];
  assert.deepEqual(valuesOf([...a, 16, ...c]), [...a, null, 16, ...c]);
  assert.deepEqual(valuesOf([...a, 20, 24, 28, 32]), [...a, null, 20, 24, 28, 32]);
  assert.deepEqual(valuesOf([...a, 500, 1000, 1004, 1008]), [...a, null, 500, null, 1000, 1004, 1008]);
  assert.deepEqual(valuesOf([...a, ...b, 1e6, 1e6 + 4]), [...a, ...b, null, 1e6, null, 1e6 + 4].filter((value, i) => i !== 6));
});

test('a second without States is a hole also where only instants are known', () => {
  const series = new TimeSeries(1, 1000);
  for (let k = 0; k < 3; ++k) series.add(0.004 * k, [0]);
  for (let k = 0; k < 3; ++k) series.add(1 + 0.004 * k, [0.7]);
  const [times, values] = series.window(10);
  assert.deepEqual(values, [0, 0, 0, null, 0.7, 0.7, 0.7]);
  assert.ok(times.every((time, i) => i === 0 || time > times[i - 1]), 'the hole lies between its rows');
});

test('a link that slows the stream down, and lets it go faster again, makes no hole', () => {
  const ticks = ticksOf([[4, 60], [8, 40], [16, 30], [8, 30], [4, 60], [40, 20], [4, 20], [1, 100]]);
  assert.deepEqual(valuesOf(ticks, randomOf(3)), ticks);
});

test('of random streams that lose States, each loss is a hole and nothing else is', () => {
  const random = randomOf(20261);
  let lost = 0, found = 0, wrong = 0;
  for (let round = 0; round < 300; ++round) {
    const divisor = [1, 4, 4, 10, 25][Math.floor(random() * 5)];
    const factor = [1, 2, 2, 4][Math.floor(random() * 4)];
    const sent = ticksOf([[divisor, 60], [divisor * factor, 60], [divisor, 60]], Math.floor(random() * 1e9));
    const share = random() * 0.15;
    const kept = sent.filter(() => random() >= share);
    const missing = new Set(sent.filter((tick) => !kept.includes(tick)));
    const changes = [sent[59], sent[119]];
    const holes = holesBefore(kept);
    kept.forEach((tick, i) => {
      if (i === 0) return;
      // A State lost just where the pace changes cannot be told from the change.
      if (changes.some((change) => kept[i - 1] <= change && tick > change)) return;
      const truth = sent.some((other) => other > kept[i - 1] && other < tick && missing.has(other));
      lost += truth ? 1 : 0;
      found += truth && holes[i] ? 1 : 0;
      wrong += !truth && holes[i] ? 1 : 0;
    });
  }
  assert.ok(found >= 0.99 * lost, `${found} of ${lost} losses are holes`);
  assert.ok(wrong <= 0.005 * lost, `${wrong} holes where nothing was lost`);
});

test('a replay at another pace, in steps that vary, makes no hole, and a jump in it does', () => {
  const steps = [3, 3, 3, 2, 3, 3, 13, 13, 13, 13, 13, 13, 13, 13, 3, 3, 3, 4, 3];
  const ticks = steps.reduce((sum, step) => [...sum, sum.at(-1) + step], [100]);
  assert.deepEqual(valuesOf(ticks), ticks);
  const jump = ticks.map((tick) => tick + 5000);
  assert.deepEqual(valuesOf([...ticks, ...jump]), [...ticks, null, ...jump]);
});

test('ticks that begin anew while time goes on are another run: a hole', () => {
  const series = new TimeSeries(1, 100);
  [96, 100, 104].forEach((tick, i) => series.add(10 + 0.004 * i, [1], tick));
  [0, 4, 8].forEach((tick, i) => series.add(10.012 + 0.004 * i, [2], tick));
  assert.deepEqual(series.window(1)[1], [1, 1, 1, null, 2, 2, 2]);
});

test('two rows of one instant, and values that are no numbers, break nothing', () => {
  assert.deepEqual(valuesOf([0, 4, 4, 8, 12]), [0, 4, 4, 8, 12]);
  const series = new TimeSeries(2, 10);
  [[1, 2], [NaN, 3], [Infinity, 4], [5, undefined]].forEach((values, i) => series.add(i, values));
  assert.deepEqual(series.window(10).slice(1), [[1, null, null, 5], [2, 3, 4, null]]);
  assert.deepEqual(new TimeSeries(1, 4).window(1), [[], []]);
});

test('what has grown since the first row keeps its holes', () => {
  assert.deepEqual(sinceFirst([2, 3, null, 5]), [0, 1, null, 3]);
  assert.deepEqual(sinceFirst([null, 3, 4]), [null, 0, 1]);
  assert.deepEqual(sinceFirst([]), []);
});

test('rows that no line shows, alone or too short a run between holes, are dots, others are not', () => {
  const times = [0, 1, 2, 3, 4, 5];
  assert.deepEqual(loneRows(times, [1, null, 2, 3, null, 4], 0), [0, 5]);
  assert.deepEqual(loneRows(times, [1, null, 2, 3, null, 4], 1.5), [0, 2, 3, 5]);
  assert.deepEqual(loneRows(times, [1, 2, 3, null, 4, 5], 1.5), [4, 5]);
  assert.deepEqual(loneRows([0, 1, 2], [null, 1, null], 0), [1]);
  assert.deepEqual(loneRows([0, 1, 2], [1, 2, 3], 2), []);
  assert.deepEqual(loneRows([0], [7], 0), [0]);
  assert.deepEqual(loneRows([], [], 1), []);
});
