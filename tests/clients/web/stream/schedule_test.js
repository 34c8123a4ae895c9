// When the page shows a tone, in virtual time: scripted clocks and ways of a message, through the page's estimate of the daemon's clock. The
// instant at which it would be drawn, were there a frame, is held against the tone's own instant + D: at most 1 ms off, as haptic-audio's
// schedule_test.cpp asserts of the sound.
import assert from 'node:assert/strict';
import test from 'node:test';
import { DaemonClock, shownNs } from '../../../../clients/web/stream/src/clock.js';

const PING_S = 1; // connection.js
const DELAY_S = 0.008;
const TONES = 500;

function randomOf(seed) {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

/**
 * Errors, s, of `TONES` tones that are shown by a page whose clock stands `offsetS` behind the daemon's, runs slower by `skew`, and whose
 * exchanges take up to `wayS` each way, at least a tenth of it.
 */
function errorsOf({ offsetS = 1234.5, skew, wayS, seed }) {
  const random = randomOf(seed);
  const clock = new DaemonClock();
  const daemonS = (pageS) => pageS * (1 + skew) + offsetS;
  const errors = [];
  let pingS = 0.1;
  let toneS = 3; // by the page's clock; by then a few exchanges are done
  for (let i = 0; i < TONES; ++i) {
    toneS += 0.15 + 0.1 * random();
    for (; pingS < toneS; pingS += PING_S) {
      const outS = wayS * (0.1 + 0.9 * random());
      const backS = wayS * (0.1 + 0.9 * random());
      clock.heard(pingS, daemonS(pingS + outS) * 1e9, pingS + outS + backS);
    }
    const eventNs = daemonS(toneS) * 1e9;
    const shown = (pageS) => shownNs({ clock, pageS, delayS: DELAY_S, newestNs: eventNs, steady: true }) >= eventNs;
    let [before, after] = [toneS - 0.1, toneS + 0.1];
    assert.ok(!shown(before) && shown(after));
    while (after - before > 1e-7) {
      const middle = (before + after) / 2;
      if (shown(middle)) after = middle;
      else before = middle;
    }
    errors.push(after - (toneS + DELAY_S));
  }
  return errors;
}

const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);
const worst = (values) => Math.max(...values.map(Math.abs));

for (const [name, script] of Object.entries({
  'on one machine': { skew: 0, wayS: 0.0005, seed: 1 },
  'with clocks that drift by 50 ppm': { skew: 50e-6, wayS: 0.001, seed: 2 },
  'with clocks that drift by -50 ppm and ways up to 2 ms': { skew: -50e-6, wayS: 0.002, seed: 3 },
})) {
  test(`a tone is shown at t_ns + D within 1 ms ${name}`, () => {
    const errors = errorsOf(script);
    console.log(`rms ${(rms(errors) * 1e3).toFixed(3)} ms, worst ${(worst(errors) * 1e3).toFixed(3)} ms`);
    assert.ok(worst(errors) <= 1e-3);
  });
}
