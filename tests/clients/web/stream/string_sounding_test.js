// What a string sounds like and where it swings, against closed forms: decays and glides written out, and the triangle of a plucked string, whose
// partials are known.
import assert from 'node:assert/strict';
import test from 'node:test';
import { StreamModel } from '../../../../clients/web/stream/src/stream_model.js';
import { StringMotion, stringShape } from '../../../../clients/web/stream/src/string_motion.js';
import { soundingAt, StringSoundings, swingAt } from '../../../../clients/web/stream/src/string_sounding.js';

const RINGING = 3, PRESSED = 2, RELEASE = 2, RECORDING = 2;
const T0 = 5e12;
const string = { radiusM: 0.0004, points: [[0, 0, 0], [1, 0, 0]] };
const told = (fields = {}) => ({ t_ns: T0, string_index: 1, number: 1, cause: 1, lambda_from: 0, lambda_to: 1, frequency_hz: 98, cents_per_s: 0,
  inharmonicity: 0, partials_m: [0.003, 0.001], decays_s: [2, 0.5], phases_rad: [], ...fields });
const rings = (fields = {}) => ({ string_index: 1, phase: RINGING, deflection_w_m: [], lambda: 0.3, radius_m: 0.0017, ...fields });
const near = (value, wanted, error) => assert.ok(Math.abs(value - wanted) <= error, `${value} is not ${wanted}`);
const motionOf = (...soundings) => {
  const motion = new StringMotion();
  for (const sounding of soundings) motion.soundings.add(sounding);
  return motion;
};

test('each partial falls by its own decay, and the pitch glides for 100 ms and then stays', () => {
  const sounding = told({ cents_per_s: -240 });
  for (const [since, cents] of [[0, 0], [0.05, -12], [0.1, -24], [0.7, -24]]) {
    const { frequencyHz, partialsM } = soundingAt(sounding, T0 + since * 1e9);
    near(frequencyHz, 98 * Math.exp((cents / 1200) * Math.LN2), 1e-9);
    near(partialsM[0], 0.003 * Math.exp(-since / 2), 1e-15);
    near(partialsM[1], 0.001 * Math.exp(-since / 0.5), 1e-15);
  }
});

test('the newest number counts among those whose instant has come, in whatever order they arrive', () => {
  const soundings = new StringSoundings();
  for (const [number, t] of [[3, 30e6], [1, 0], [2, 10e6], [3, 30e6]]) soundings.add(told({ number, t_ns: T0 + t }));
  const newest = (t) => soundings.at(1, T0 + t)?.number;
  assert.deepEqual([newest(-1), newest(0), newest(15e6), newest(29e6), newest(30e6), newest(9e9)], [undefined, 1, 2, 2, 3, 3]);
  assert.equal(soundings.at(0, T0), null);
});

test('numbers count through 32 bits', () => {
  const soundings = new StringSoundings();
  for (const number of [0, 4294967295, 1]) soundings.add(told({ number }));
  assert.equal(soundings.at(1, T0).number, 1);
});

test('the swing of two partials is the sum of their shapes', () => {
  near(swingAt([0.003, 0.001], 1 / 4), 0.003 * Math.SQRT1_2 + 0.001, 1e-15);
  near(swingAt([0.003, 0.001], 1 / 2), 0.003, 1e-15);
  near(swingAt([0.003, 0.001], 3 / 4), 0.003 * Math.SQRT1_2 + 0.001, 1e-15);
  near(swingAt([0.003, 0.001], 0), 0, 1e-15);
});

test('the partials of a string that was drawn aside by h at a place reach h there', () => {
  const h = 0.004;
  for (const place of [0.5, 0.25, 0.125]) {
    const partials = Array.from({ length: 4000 }, (_, k) => (2 * h * Math.sin((k + 1) * Math.PI * place)) / (((k + 1) * Math.PI) ** 2 * place * (1 - place)));
    // What is beyond 4000 partials is less than the integral of 2 h / (pi^2 n^2 place (1 - place)).
    near(swingAt(partials, place), h, (2 * h) / (Math.PI ** 2 * 4000 * place * (1 - place)));
    assert.ok(swingAt(partials, place) < h);
  }
});

test('a string that is told to sound has the band of its part, whatever radius is told', () => {
  const motion = motionOf(told({ lambda_from: 0.25, lambda_to: 1, partials_m: [0.003], decays_s: [2] }));
  motion.add({ string_index: 1, phase: RELEASE, t_ns: T0, r_max_m: 0.009, decay_s: 9 });
  const shape = stringShape(string, 1, rings(), motion, T0 + 0.5e9);
  assert.deepEqual([shape.band.from, shape.band.to], [0.25, 1]);
  near(shape.band.partialsM[0], 0.003 * Math.exp(-0.25), 1e-15);
  near(shape.envelopeM, 0.003 * Math.exp(-0.25), 1e-12); // the widest of a half wave is its amplitude
  near(shape.radiusM, 0.0004 + shape.envelopeM, 1e-15);
});

test('while a finger stops the string, the part beyond it rings and the axis is bent', () => {
  const motion = motionOf(told({ lambda_from: 0.25 }));
  const shape = stringShape(string, 1, rings({ phase: PRESSED, deflection_w_m: [0, -0.002, 0], lambda: 0.25, radius_m: 0.0024 }), motion, T0);
  assert.deepEqual([shape.deflection, shape.lambda, shape.band.from], [[0, -0.002, 0], 0.25, 0.25]);
});

test('a band is gone once it is too narrow to be seen, or States do not list the string', () => {
  const motion = motionOf(told());
  assert.equal(stringShape(string, 1, rings(), motion, T0 + 30e9).envelopeM, 0);
  assert.equal(stringShape(string, 1, rings(), motion, T0 + 30e9).band, null);
  assert.equal(stringShape(string, 1, undefined, motion, T0 + 1e6).band, null);
});

test('where nothing is told of a sound, or that it is silent, the radius is drawn as States and StringRadius say', () => {
  for (const motion of [motionOf(), motionOf(told({ partials_m: [], decays_s: [] }))]) {
    near(stringShape(string, 1, rings(), motion, T0 + 1e6).envelopeM, 0.0013, 1e-15);
    motion.add({ string_index: 1, phase: RELEASE, t_ns: T0, r_max_m: 0.002, decay_s: 1 });
    const shape = stringShape(string, 1, rings(), motion, T0 + 0.5e9);
    near(shape.envelopeM, 0.002 * Math.exp(-0.5), 1e-15);
    assert.equal(shape.band, null);
  }
});

/** A model that shows the daemon's scene 1 with two strings. */
function joined() {
  const model = new StreamModel();
  model.take({ welcome: { source: 1, control: false, presentation_delay_s: 0.008 } });
  const scene = { name: 'two', tools: [], bodies: [], lines: [], strings: [0, 1].map(() => ({ name: '', p_wa_m: [0, 0, 0], p_wb_m: [1, 0, 0], radius_m: 0.0004 })) };
  model.take({ item: { scene_info: { scene_id: 1, scene, hash: new Uint8Array(32), assets: [], parameters: [], rate_hz: 1000, clock: 1 } } });
  return model;
}
const stateOf = (t_ns, ...strings) => ({ state: { tick: 0, t_ns, scene_id: 1, part_count: 0, tools: [], contacts: [], strings } });

test('who joins while a string rings learns from a State what it sounds like, carried on from its instant', () => {
  const model = joined();
  model.take(stateOf(T0 + 0.4e9, rings({ sounding: told({ number: 9 }) })));
  const shape = stringShape(string, 1, rings(), model.motion, T0 + 0.5e9);
  near(shape.band.partialsM[0], 0.003 * Math.exp(-0.25), 1e-15);
  // The event that it repeats changes nothing, a newer one does, and so does one of another State.
  model.take({ item: { string_sounding: told({ number: 9, partials_m: [0.1] }) } });
  near(stringShape(string, 1, rings(), model.motion, T0 + 0.5e9).band.partialsM[0], 0.003 * Math.exp(-0.25), 1e-15);
  model.take({ item: { string_sounding: told({ number: 10, t_ns: T0 + 0.45e9, partials_m: [0.001], decays_s: [1] }) } });
  near(stringShape(string, 1, rings(), model.motion, T0 + 0.5e9).band.partialsM[0], 0.001 * Math.exp(-0.05), 1e-15);
});

test('another scene, a recording that is moved back, and a lost connection end what was told', () => {
  const band = (model) => stringShape(string, 1, rings(), model.motion, T0 + 0.5e9).band;
  const ends = [
    (model) => model.take(stateOf(T0 + 0.3e9, rings())),
    (model) => model.lost(),
    (model) => model.take({ shown: { source: RECORDING, recording: 'a.mcap', tools_only: false } }),
  ];
  for (const end of ends) {
    const model = joined();
    model.take(stateOf(T0 + 0.4e9, rings({ sounding: told() })));
    assert.notEqual(band(model), null);
    end(model);
    assert.equal(band(model), null);
  }
});
