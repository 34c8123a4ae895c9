// What a screen of the experiment asks for, and the keys that answer it.
import { v1 } from 'hapticd-stream';

const PREFIX = 'EXPERIMENT_STAGE_';
const OVER = ['done', 'stopped', 'unspecified', ''];

/** Keys of a comparison; Enter and Space go on elsewhere, by the button that has the focus. */
export const CHOICE_KEYS = { a: 'FIRST', 1: 'FIRST', b: 'SECOND', 2: 'SECOND', e: 'EQUAL', '=': 'EQUAL', r: 'AGAIN' };

/** The stage of a screen in lower case, such as touch; empty without one. */
export function stageOf(screen) {
  const name = screen ? Object.keys(v1.ExperimentStage).find((each) => v1.ExperimentStage[each] === screen.stage) : undefined;
  return name ? name.slice(PREFIX.length).toLowerCase() : '';
}

/** Something is asked. */
export const isRunning = (screen) => !OVER.includes(stageOf(screen));
