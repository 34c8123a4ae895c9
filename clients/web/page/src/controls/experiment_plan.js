// The experiment of the paper's Table 1 as a plan: for each of T, E and R and each increment of 30, 40 and 50 %, three pairs of reference and
// raised value in random order; the player says which one is stiffer. 27 trials. The same seed gives the same order.

export const PARAMETERS = ['T', 'E', 'R'];
export const INCREMENTS = [0.3, 0.4, 0.5];
export const REPETITIONS = 3;
export const REFERENCE = { T: 30, E: 1.9e11, R: 3.4e-4 };
/** Rates of correct answers as published, %, by parameter and increment. */
export const PUBLISHED = { T: [47.7, 52.4, 66.7], E: [38.0, 42.9, 42.9], R: [23.7, 33.3, 62.1] };

const FIELDS = { T: 'tension_n', E: 'youngs_modulus_pa', R: 'radius_m' };

/** [{parameter, increment, raisedFirst}] in random order. */
export function makePlan(seed) {
  const random = generator(seed);
  const trials = [];
  for (const parameter of PARAMETERS) {
    for (const increment of INCREMENTS) {
      for (let i = 0; i < REPETITIONS; ++i) trials.push({ parameter, increment, raisedFirst: random() < 0.5 });
    }
  }
  for (let i = trials.length - 1; i > 0; --i) {
    const j = Math.floor(random() * (i + 1));
    [trials[i], trials[j]] = [trials[j], trials[i]];
  }
  return trials;
}

/** Mulberry32: 32 bits of state are plenty for an order of 27. */
function generator(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/**
 * Scene of one half of a trial, `half` 0 or 1: `scene` with every string at the reference and, in one half, one parameter raised. Both
 * halves and all parameters come by the same way, a change of scene, so that nothing but the string tells them apart. The tuning goes
 * with neither: the sound must not give the answer, so there are no tones.
 */
export function trialScene(scene, trial, half) {
  const raised = trial.raisedFirst === (half === 0);
  const values = { ...REFERENCE };
  if (raised) values[trial.parameter] *= 1 + trial.increment;
  const strings = scene.strings.map((string) => {
    const changed = { ...string };
    delete changed.linear_density_kg_per_m; // it would contradict the tuning once T has changed
    for (const [parameter, field] of Object.entries(FIELDS)) changed[field] = values[parameter];
    return changed;
  });
  const changed = { ...scene, strings };
  delete changed.tones;
  return changed;
}

/** Was 'first', 'second' or 'same' right? The raised half is stiffer, always. */
export const isCorrect = (trial, answer) => answer === (trial.raisedFirst ? 'first' : 'second');

/** {T: [{asked, correct}, ...by increment], E, R} of the answers to the first trials of a plan. */
export function tally(plan, answers) {
  const table = Object.fromEntries(PARAMETERS.map((name) => [name, INCREMENTS.map(() => ({ asked: 0, correct: 0 }))]));
  answers.forEach((answer, i) => {
    const cell = table[plan[i].parameter][INCREMENTS.indexOf(plan[i].increment)];
    ++cell.asked;
    if (isCorrect(plan[i], answer)) ++cell.correct;
  });
  return table;
}

/** Everything about a run as CSV, for a study. */
export function resultCsv(seed, plan, answers) {
  const rows = answers.map((answer, i) => [i + 1, plan[i].parameter, plan[i].increment, plan[i].raisedFirst ? 'first' : 'second', answer,
    isCorrect(plan[i], answer) ? 1 : 0].join(','));
  return [`# seed ${seed}`, 'trial,parameter,increment,stiffer,answer,correct', ...rows, ''].join('\n');
}
