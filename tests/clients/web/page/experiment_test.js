// The experiment's screens as far as they need no browser: which stage asks, which key answers, how the stream brings them, and the summary.
// tests/system/viewer/experiment_test.js goes through all of it in one.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Session } from '../../../../clients/web/page/src/controls/session.js';
import { CHOICE_KEYS, isRunning, stageOf } from '../../../../clients/web/page/src/controls/experiment_stage.js';
import { summaryBlocks } from '../../../../clients/web/page/src/controls/summary.js';
import { StreamModel } from '../../../../clients/web/stream/src/stream_model.js';
import { v1 } from '../../../../clients/web/stream/src/wire.js';
import { exampleOf } from '../stream/examples.js';

test('a screen asks until it is the last one', () => {
  const running = Object.keys(v1.ExperimentStage).filter((name) => isRunning({ stage: v1.ExperimentStage[name] }));
  assert.deepEqual(running.map((name) => name.slice('EXPERIMENT_STAGE_'.length)), ['INSTRUCT', 'FAMILIARISE', 'TOUCH', 'COMPARE', 'RATE']);
  assert.equal(isRunning(null), false);
  assert.equal(stageOf({ stage: v1.ExperimentStage.EXPERIMENT_STAGE_TOUCH }), 'touch');
  assert.equal(stageOf({ stage: 99 }), '');
});

test('every key of a comparison is an answer that the protocol has', () => {
  assert.deepEqual([...new Set(Object.values(CHOICE_KEYS))].sort(), ['AGAIN', 'EQUAL', 'FIRST', 'SECOND']);
  for (const reply of Object.values(CHOICE_KEYS)) assert.ok(v1.ExperimentReply[`EXPERIMENT_REPLY_${reply}`] > 0);
});

test('a screen reaches the panels, and is forgotten with the connection', () => {
  const said = [];
  const session = new Session({ experiment: async () => ({ code: v1.ResultCode.RESULT_CODE_BUSY, message: 'one runs' }) });
  session.addEventListener('said', ({ detail }) => said.push(detail.text));
  const model = new StreamModel({ session, pageS: () => 0, handlers: {} });
  model.take(exampleOf('page_experiment_screen'));
  assert.deepEqual([session.experimentScreen.participant, session.experimentScreen.kept, session.experimentScreen.yours], ['P1', 27, true]);
  assert.equal(stageOf(session.experimentScreen), 'rate');
  session.lost();
  assert.equal(session.experimentScreen, null);
  return session.experiment({ begin: { participant: 'P2' } }).then(() => assert.deepEqual(said, ['begin experiment: one runs']));
});

test('a summary has its headings, tables, lists and lines', () => {
  const blocks = summaryBlocks('# Title\n\n27 trials.\n\n| raised | +30 % |\n|---|---|\n| T | 66.7 % |\n\n- one\n- two\n');
  assert.deepEqual(blocks, [{ kind: 'heading', text: 'Title' }, { kind: 'text', text: '27 trials.' },
    { kind: 'table', rows: [['raised', '+30 %'], ['T', '66.7 %']] }, { kind: 'list', items: ['one', 'two'] }]);
});
