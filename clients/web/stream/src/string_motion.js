// How a string looks at an instant: the events StringRadius say from when on it decays how, exactly; States say how it is bent. The radius
// that is drawn is R + r(t), the paper's cylinder. Of a string that is told to sound (StringSounding) the band that it swings in is known
// instead, place by place.
import { soundingAt, StringSoundings, swingAt } from './string_sounding.js';
import { v1 } from './wire.js';

const SLEEP_M = 2e-6; // thinner envelopes than this are not seen; the string is drawn at rest
const LOOKS = 48; // places at which the widest of a band is looked for: four for each loop of its 12th partial

export class StringMotion {
  soundings = new StringSoundings();
  #events = new Map(); // string index -> the events that may still be shown, oldest first

  clear() {
    this.#events.clear();
    this.soundings.clear();
  }

  /** Takes a StringRadius. */
  add(event) {
    const events = this.#events.get(event.string_index) ?? [];
    events.push(event);
    events.sort((a, b) => a.t_ns - b.t_ns);
    this.#events.set(event.string_index, events.slice(-16));
  }

  /**
   * Envelope r(t) of string `index` at `ns`, m, by its newest event that has happened; null where no event says anything, or a finger
   * holds the string and States have its course.
   */
  envelope(index, ns) {
    const events = this.#events.get(index);
    const event = events?.findLast((candidate) => candidate.t_ns <= ns);
    if (!event || event.phase === v1.StringRadiusPhase.STRING_RADIUS_PHASE_PRESS) return null;
    const r = decayed(event, ns);
    return r > SLEEP_M ? r : 0;
  }
}

/** r_max exp(-(t - t0) / T_d), m. */
export function decayed(event, ns) {
  if (!(event.decay_s > 0)) return 0;
  return event.r_max_m * Math.exp(-((ns - event.t_ns) * 1e-9) / event.decay_s);
}

/**
 * The band that string `index` swings in at `ns`: {from, to, partialsM, widestM}, the part that sounds, in lambda, and the amplitudes of its
 * partials (see swingAt); widestM is 0 where they are too small to be seen. null where nothing tells of a sound.
 */
function bandOf(index, motion, ns) {
  const sounding = motion.soundings.at(index, ns);
  if (!sounding?.partials_m.length || !(sounding.lambda_to > sounding.lambda_from)) return null;
  const { partialsM } = soundingAt(sounding, ns);
  const swings = Array.from({ length: LOOKS + 1 }, (_, k) => swingAt(partialsM, k / LOOKS));
  const widestM = Math.max(...swings);
  return { from: sounding.lambda_from, to: sounding.lambda_to, partialsM, widestM: widestM > SLEEP_M ? widestM : 0 };
}

/**
 * What to draw of one string: {radiusM, envelopeM, deflection, lambda, phase, band}. `state` is its StringState, or undefined when asleep;
 * radiusM = R + envelopeM. `band`: it rings where and as far as that says (as bandOf), and envelopeM is the widest of it; null: the envelope
 * is the same all along.
 */
export function stringShape(string, index, state, motion, ns) {
  const Phase = v1.StringPhase;
  const held = state && (state.phase === Phase.STRING_PHASE_TOUCHED || state.phase === Phase.STRING_PHASE_PRESSED);
  const band = state ? bandOf(index, motion, ns) : null; // what States do not list is silent
  const told = band ? band.widestM : held ? null : motion.envelope(index, ns);
  const envelopeM = told ?? Math.max(0, (state?.radius_m ?? string.radiusM) - string.radiusM);
  const bent = state?.deflection_w_m?.length === 3 && state.phase !== Phase.STRING_PHASE_RINGING;
  return {
    radiusM: string.radiusM + envelopeM,
    envelopeM,
    deflection: bent ? state.deflection_w_m : [0, 0, 0],
    lambda: state?.lambda ?? 0.5,
    phase: state?.phase ?? (envelopeM > 0 ? Phase.STRING_PHASE_RINGING : 0),
    band: band?.widestM > 0 ? band : null,
  };
}
