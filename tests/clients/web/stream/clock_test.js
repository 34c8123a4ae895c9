// The daemon's clock and the instant that is shown, in virtual time.
import assert from 'node:assert/strict';
import test from 'node:test';
import { DaemonClock, shownNs } from '../../../../clients/web/stream/src/clock.js';

/** A link whose way out takes `outS` and whose way back takes `backS`; the daemon's clock is `offsetS` ahead of the page's. */
function exchange(clock, sentS, { offsetS, outS, backS }) {
  clock.heard(sentS, (sentS + outS + offsetS) * 1e9, sentS + outS + backS);
}

test('equal ways give the offset exactly', () => {
  const clock = new DaemonClock();
  exchange(clock, 10, { offsetS: 1234.5, outS: 0.002, backS: 0.002 });
  assert.ok(Math.abs(clock.daemonNs(20) - 1254.5e9) < 1000);
});

test('the offset is never wrong by more than half the round trip, whatever the ways', () => {
  let seed = 7;
  const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  const clock = new DaemonClock();
  for (let i = 0; i < 200; ++i) {
    exchange(clock, i, { offsetS: -77, outS: 0.03 * random(), backS: 0.03 * random() });
    assert.ok(Math.abs(clock.daemonNs(i) * 1e-9 - (i - 77)) <= clock.errorS + 1e-9);
  }
});

test('of the last eight exchanges the fastest counts, and an old one is forgotten', () => {
  const clock = new DaemonClock();
  exchange(clock, 0, { offsetS: 5, outS: 0.0001, backS: 0.0001 });
  exchange(clock, 1, { offsetS: 5, outS: 0.03, backS: 0.001 });
  assert.ok(clock.errorS < 0.00011);
  for (let i = 2; i < 10; ++i) exchange(clock, i, { offsetS: 6, outS: 0.001, backS: 0.001 });
  assert.ok(Math.abs(clock.daemonNs(10) * 1e-9 - 16) < 1e-6);
});

test('a pong without a daemon says nothing about its clock', () => {
  const clock = new DaemonClock();
  clock.heard(1, 0, 1.001);
  assert.equal(clock.errorS, null);
});

test('an instant t is shown when the daemon reads t + D', () => {
  const clock = new DaemonClock();
  exchange(clock, 0, { offsetS: 100, outS: 0.001, backS: 0.001 });
  const eventNs = 103.25e9, delayS = 0.008;
  const at = (pageS) => shownNs({ clock, pageS, delayS, newestNs: 103.3e9, steady: true });
  assert.ok(at(3.2579) < eventNs);
  assert.ok(at(3.2581) > eventNs);
});

test('where time does not run with ours, the newest State is shown', () => {
  const clock = new DaemonClock();
  exchange(clock, 0, { offsetS: 100, outS: 0.001, backS: 0.001 });
  assert.equal(shownNs({ clock, pageS: 1, delayS: 0.008, newestNs: 100.5e9, steady: false }), 100.5e9);
  assert.equal(shownNs({ clock, pageS: 1, delayS: 0.008, newestNs: 42, steady: true }), 42);
  assert.equal(shownNs({ clock: new DaemonClock(), pageS: 1, delayS: 0.008, newestNs: 9, steady: true }), 9);
});
