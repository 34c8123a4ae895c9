// The experiment of the paper's Table 1 gone through in the page, as a person does it, at a real daemon with a simulated device: familiarisation,
// 27 trials with keys and buttons, five sliders; the page is reloaded and the gateway killed in the middle. Truth: what hapticd-lab run alone
// plans of the same seed, and what it reads of the files.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { banner, freePort, playing, startBrowser, startDaemon, startGateway } from './programs.js';

const TRIALS = 27;
const SEED = 7;
const RELOADED_IN = 9; // the trial in which the page is reloaded, while B is felt
const KILLED_IN = 18; // and that in which the gateway is killed, when it was just answered
const SCORES = [90, 85, 70, 0, 100];
const ANSWERS = [['a', 'first'], ['e', 'equal'], ['b', 'second'], ['1', 'first'], ['=', 'equal'], ['2', 'second']];
const folder = mkdtempSync(join(tmpdir(), 'hapticd-experiment-'));
const place = join(folder, 'P1');
const pictures = process.env.HAPTICD_PICTURES;
const recordings = join(folder, 'hapticd/recordings');
const answerOf = (trial) => ANSWERS[trial % ANSWERS.length];
let at, daemon, gateway, browser, page;

const lab = (...words) => execFileSync(process.env.HAPTICD_LAB, words, { encoding: 'utf8', timeout: 120_000 });
// At the same address again, as a person starts it: a browser remembers by address.
const start = () => startGateway(['--server', at, '--experiments', folder, '--recordings', recordings], { listen: `127.0.0.1:${gateway?.port ?? 0}` });
const heading = (text) => page.locator('#trial h2', { hasText: text }).waitFor();
const rows = (name) => readFileSync(join(place, name), 'utf8').trim().split('\n').map((line) => line.split(','));

before(async () => {
  at = `127.0.0.1:${await freePort()}`;
  daemon = await startDaemon(at, ['--device', 'simulated', '--scene', 'wall'], { env: { XDG_STATE_HOME: folder } });
  gateway = await start();
  browser = await startBrowser();
  page = browser.page;
  await page.goto(gateway.url);
  await playing(page);
  await page.click('[data-tab=experiment]');
});

after(async () => {
  await browser?.end();
  await gateway?.end();
  await daemon?.end();
  rmSync(folder, { recursive: true, force: true });
});

const picture = async (name) => { if (pictures) await page.screenshot({ path: join(pictures, `${name}.png`) }); };

/** Waits for the screen of a trial, `label` A or B, or the question. */
async function trialShown(trial, text) {
  await page.locator('#trial-number', { hasText: `Trial ${trial} of ${TRIALS}` }).waitFor();
  await heading(text);
}

async function goOn() {
  await page.keyboard.press('Enter');
}

/** A and B of a trial are felt. */
async function feel(trial) {
  for (const label of ['A', 'B']) {
    await trialShown(trial, `String ${label}`);
    await goOn();
  }
  await trialShown(trial, 'Which one was stiffer?');
}

async function answer(trial) {
  await feel(trial);
  await page.keyboard.press(answerOf(trial)[0]);
}

/** Presses what the banner of an interrupted experiment offers, and the instructions' button. */
async function resume(kept) {
  await banner(page, 'experiment', 'P1 has stopped');
  await page.locator('.banner[data-kind=experiment] button').click();
  await page.locator('#trial-onward', { hasText: `${kept} trials are answered already` }).waitFor();
  await goOn();
}

test('a name that is no folder is refused, with what is one', async () => {
  await page.fill('#experiment-participant', '../P1');
  await page.click('#experiment-begin');
  await page.waitForFunction(() => document.getElementById('said').textContent.includes('letters, digits'));
});

test('wall and sphere come first, and are seen', async () => {
  await page.fill('#experiment-participant', 'P1');
  await page.fill('#experiment-seed', String(SEED));
  await page.click('#experiment-begin');
  await heading('Which string is stiffer?');
  await picture('instruct');
  await goOn();
  for (const scene of ['wall', 'sphere']) {
    await page.locator('#trial p', { hasText: `Here is a ${scene}.` }).waitFor();
    await page.waitForFunction((name) => window.hapticd.model.scene.name === name, scene);
    await picture(scene);
    await goOn();
  }
  await trialShown(1, 'String A');
});

test('while strings are compared nothing of them is drawn, and another page only looks', async () => {
  assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector('aside')).display), 'none');
  const covered = await page.evaluate(() => {
    const { x, y, width, height } = document.getElementById('canvas').getBoundingClientRect();
    return [[0.1, 0.1], [0.5, 0.05], [0.9, 0.9]].every(([u, v]) => document.elementFromPoint(x + u * width, y + v * height).closest('#trial'));
  });
  assert.ok(covered);
  const other = await browser.newPage();
  await other.goto(gateway.url);
  await other.click('[data-tab=experiment]');
  await other.locator('#experiment-status', { hasText: `P1: 0 of ${TRIALS}` }).waitFor();
  assert.equal(await other.isVisible('#trial'), false);
  await other.close();
});

test('both are felt once more when that is asked for, a key that is held answers once', async () => {
  await picture('touch');
  await feel(1);
  await picture('compare');
  await page.keyboard.press('r');
  await trialShown(1, 'String A');
  await page.keyboard.down('Enter');
  await page.keyboard.down('Enter');
  await trialShown(1, 'String B');
  await page.keyboard.down('Enter');
  await page.keyboard.up('Enter');
  await page.waitForFunction(() => window.hapticd.session.experimentScreen.object === 'B');
  await goOn();
  await trialShown(1, 'Which one was stiffer?');
  await page.keyboard.press(answerOf(1)[0]);
});

test('a string that Stop cut off does not count before the fault is cleared', async () => {
  await trialShown(2, 'String A');
  await page.keyboard.press('Escape');
  await banner(page, 'loop', 'Fault: stopped');
  await goOn();
  await page.locator('#trial [role=alert]', { hasText: 'a fault is latched' }).waitFor();
  await picture('fault');
  await trialShown(2, 'String A');
  await page.click('#trial [data-reply=ENGAGE]');
  await page.locator('.banner[data-kind=loop]').waitFor({ state: 'detached' });
  await page.waitForFunction(() => !document.querySelector('#trial [role=alert]'));
});

test('a page that is reloaded in a trial goes on with that trial', async () => {
  for (let trial = 2; trial < RELOADED_IN; ++trial) await answer(trial);
  await trialShown(RELOADED_IN, 'String A');
  await goOn();
  await trialShown(RELOADED_IN, 'String B');
  await page.reload();
  await resume(RELOADED_IN - 1);
  await answer(RELOADED_IN);
  await trialShown(RELOADED_IN + 1, 'String A');
  assert.equal(rows('trials.csv').length, 1 + RELOADED_IN);
});

test('a gateway that is killed after an answer loses none', async () => {
  for (let trial = RELOADED_IN + 1; trial < KILLED_IN; ++trial) await answer(trial);
  await answer(KILLED_IN);
  await trialShown(KILLED_IN + 1, 'String A');
  await gateway.program.end('SIGKILL');
  gateway = await start();
  await page.goto(gateway.url);
  await playing(page);
  await resume(KILLED_IN);
});

test('a daemon that ends in a trial stops the experiment aloud, and what was felt then does not count', async () => {
  await trialShown(KILLED_IN + 1, 'String A');
  await daemon.end();
  daemon = await startDaemon(at, ['--device', 'simulated', '--scene', 'wall'], { env: { XDG_STATE_HOME: folder } });
  await banner(page, 'experiment', 'P1 has stopped');
  assert.match(await page.textContent('.banner[data-kind=experiment]'), new RegExp(`${KILLED_IN} of ${TRIALS} trials are kept`));
  await picture('lost');
  await page.waitForFunction(() => window.hapticd.model.link?.state === 2);
  await resume(KILLED_IN);
});

test('27 trials and five sliders are on the disk, each once, as the same seed plans them in the terminal', async () => {
  for (let trial = KILLED_IN + 1; trial <= TRIALS; ++trial) await answer(trial);
  for (const score of SCORES) {
    await page.waitForFunction((kept) => window.hapticd.session.experimentScreen?.stage === 5 && window.hapticd.session.experimentScreen.object !== kept, page.rated);
    page.rated = await page.textContent('#trial h2');
    assert.equal(await page.isDisabled('#trial .go'), true); // nobody has moved it yet
    await page.fill('#trial input[type=range]', String(score));
    if (score === SCORES[0]) await picture('rate');
    await page.click('#trial .go');
  }
  await heading('Thank you!');
  assert.equal(await page.textContent('#trial-folder'), place);
  await page.click('#trial summary');
  await picture('done');
  await page.click('#trial-close');
  assert.equal(await page.isVisible('#trial'), false);
  const [head, ...trials] = rows('trials.csv');
  const column = (name) => trials.map((cells) => cells[head.indexOf(name)]);
  assert.deepEqual(column('trial').map(Number), Array.from({ length: TRIALS }, (_, i) => i + 1));
  assert.deepEqual(column('answer'), trials.map((_, i) => answerOf(i + 1)[1]));
  assert.ok(column('answer_s').every((text) => Number(text) >= 0) && column('answered_utc').every((text) => /^\d{4}-\d\d-\d\dT/.test(text)));
  assert.deepEqual(rows('questionnaire.csv').slice(1).map((cells) => Number(cells.at(-1))), SCORES);
  const ticks = ['sphere.csv', 'wall.csv', ...trials.flatMap((_, i) => ['A', 'B'].map((label) => `${String(i + 1).padStart(3, '0')}_${label}.csv`))];
  assert.deepEqual(readdirSync(join(place, 'ticks')).sort(), ticks.sort());
  // The same seed, run by hapticd-lab alone: what was presented is the same, trial by trial, and so are columns and codebook.
  const alone = join(folder, 'alone');
  lab('experiment', '--output', alone, '--seed', String(SEED));
  const [headAlone, ...planned] = readFileSync(join(alone, 'trials.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  assert.deepEqual(head, headAlone);
  const presented = ['trial', 'parameter', 'increment', 'repetition', 'stiffer', 'reference_value', 'test_value'];
  const of = (cells) => presented.map((name) => cells[head.indexOf(name)]);
  assert.deepEqual(trials.map(of), planned.map(of));
  const columns = (name) => readFileSync(join(name, 'ticks/001_A.csv'), 'utf8').split('\r\n')[0].split(',').filter((each) => !/_of_/.test(each));
  assert.deepEqual(columns(place), columns(alone));
  assert.equal(readFileSync(join(place, 'codebook.md'), 'utf8'), readFileSync(join(alone, 'codebook.md'), 'utf8'));
  assert.match(lab('group', place, alone, '--output', join(folder, 'all')), /2 participants, 54 trials/);
});

test('afterwards control is free and the strings are plain again', async () => {
  await page.waitForFunction(() => window.hapticd.session.lease && window.hapticd.session.lease.holder === '');
  const string = await page.evaluate(() => window.hapticd.session.scene.scene.strings[0]);
  assert.deepEqual([string.tension_n, string.youngs_modulus_pa, string.radius_m], [30, 1.9e11, 3.4e-4]);
});
