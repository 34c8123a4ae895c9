// The page put together: stream in, picture and panels out. Frames follow the screen; texts and plots change eight times a second. Stop is wired
// first, and each part is made by itself: a browser that lacks what one of them needs has all the others.
import { Connection, nameOf, StreamModel, v1 } from 'hapticd-stream';
import { Banners, daemonBanner, linkBanner, loopBanner, lossBanner } from './controls/banners.js';
import { ConnectionPanel } from './controls/connection_panel.js';
import { ControlPanel } from './controls/control_panel.js';
import { ExperimentPanel } from './controls/experiment_panel.js';
import { KEYS, listen } from './controls/keyboard.js';
import { PlaybackBar } from './controls/playback_bar.js';
import { Session } from './controls/session.js';
import { stopBanner, wireStop } from './controls/stop.js';
import { Film } from './film.js';
import { NoPicture, noPictureWords } from './no_picture.js';
import { readAddress } from './page_address.js';
import { Parts } from './parts.js';
import { Panels } from './plots/panels.js';
import { ViewControls } from './view_controls.js';

const TEXT_MS = 125;
const RATE_COUNTS = 5; // looks, a second apart, that rates are taken over
const FOLLOW_S = 0.27; // in a film the camera goes after the tool within this time, as it does at 60 frames/s
const SHOWN_STATES_S = 2; // without a State for this long the picture says that nothing moves
const find = (id) => document.getElementById(id);
const pageS = () => performance.now() / 1000;

// Stop comes first, and the link that it needs. Everything after it is a part that may fail by itself.
const address = readAddress(location.href);
const connection = new Connection({ address: address.socket, token: address.token, pageS,
  handlers: { event: (event) => model.take(event), opened: () => {}, closed: () => lost() } });
const session = new Session(connection);
wireStop({ button: find('stop'), session, told: (result) => banners.set('stop', stopBanner(result)) });
const banners = new Banners(find('banners'));
const parts = new Parts(tellFailure);
const model = new StreamModel({ session, pageS, handlers: {
  scene: (scene) => parts.run('scene', () => setScene(scene)), state: (state) => parts.run('plots', () => takeState(state)),
  playback: (playback) => parts.run('recording', () => takePlayback(playback)), shown: () => parts.run('recording', takeShown) } });
connection.open();

const counted = [{ atS: pageS(), states: 0, frames: 0, bytes: 0 }];
let lastStateS = -Infinity;
let picture = new NoPicture();
const panels = parts.run('plots', () => new Panels(find('plots')), null);
parts.load('plots', () => panels.open());
const control = parts.run('control', () => new ControlPanel(find('control'), session), null);
const connectionPanel = parts.run('connection', () => new ConnectionPanel(find('connection')), null);
const experiment = parts.run('experiment', () => new ExperimentPanel(find('experiment'), find('trial'), session, banners), null);
const playbackBar = parts.run('recording', () => new PlaybackBar(session), null);
const looks = parts.run('switches', () => new ViewControls(picture, address), null);
const pictureOpened = openPicture();
let drawn = pictureOpened; // the scene, with its files
const film = new Film({ model, session, panels, draw: drawForFilm, scene: () => drawn });

/** Fetches what draws and draws with it; where the browser does not let it, the picture's place says so. */
async function openPicture() {
  const fetched = await import('./picture.js').catch((error) => tellNoPicture('fetched', error));
  if (!fetched) return;
  try {
    picture = new fetched.Picture(find('canvas'), find('labels'), { high: address.high, motion: model.motion, nowS: pageS,
      lost: (isLost) => tellNoPicture(isLost ? 'lost' : '') });
  } catch (error) {
    tellNoPicture('opened', error);
    return;
  }
  picture.viewName = address.view;
  parts.run('switches', () => looks.use(picture));
}

/** Words in the place of the picture; with an empty `why` there is one again. */
function tellNoPicture(why, error) {
  const words = why ? noPictureWords(why, error) : null;
  document.body.classList.toggle('no-picture', words !== null);
  find('no-picture').hidden = words === null;
  if (words === null) return;
  find('no-picture-title').textContent = words.title;
  find('no-picture-why').textContent = words.text;
  if (error) console.warn(error);
}

function tellFailure(part, error) {
  banners.set(`part ${part}`, { title: `This page is incomplete: ${part}`, text: `${error?.message ?? error}. Everything else works, Stop too. Load the page again, or use another browser.`, warn: true });
}

function setScene(scene) {
  find('scene-name').textContent = scene.description || scene.name;
  document.title = `${scene.name} · hapticd`;
  panels?.clear();
  drawn = pictureOpened.then(() => picture.setScene(scene)).catch((error) => banners.set('scene', { title: 'The scene cannot be drawn', text: String(error) }));
  if (session.mayControl && !experiment?.running && !model.recorded) parts.load('control', () => control?.list());
}

function takeState(state) {
  lastStateS = pageS();
  panels?.add(state, state.tools[0]?.tool_id ?? 0);
}

function takePlayback(playback) {
  playbackBar?.show(playback);
  film.heard(playback);
}

/** A recording comes in place of the daemon, or the daemon again. */
function takeShown() {
  lastStateS = pageS();
  panels?.clear();
  if (!model.recorded) playbackBar?.show(null);
}

function lost() {
  model.lost();
  playbackBar?.show(null);
}

function frame() {
  if (film.rolling) return;
  requestAnimationFrame(frame);
  parts.run('picture', drawNewest);
}

function drawForFilm(elapsedS) {
  picture.followShare = 1 - Math.exp(-elapsedS / FOLLOW_S);
  drawNewest();
  picture.followShare = 0;
  drawNewest(); // shadows may follow at half the pace
  showTexts();
}

function drawNewest() {
  if (experiment?.covers) return;
  const ns = model.shownNs();
  const state = ns === null ? null : model.states.at(ns);
  picture.draw(state, ns);
  if (ns !== null) model.dueTones(ns).forEach(showTone);
}

/** A ring where a string was let go, at the instant it is heard. */
function showTone(tone) {
  const string = model.scene?.strings[tone.string_index];
  if (!string) return;
  const [a, b] = [string.points[0], string.points.at(-1)];
  const at = picture.project(a.map((value, i) => value + (b[i] - value) * tone.lambda));
  if (!at) return;
  const ring = document.createElement('i');
  ring.className = 'tone';
  ring.dataset.string = tone.string_index;
  ring.style.left = `${at.x}px`;
  ring.style.top = `${at.y}px`;
  ring.style.borderWidth = `${1 + 3 * tone.level}px`;
  ring.onanimationend = () => ring.remove();
  find('tones').append(ring);
}

function emptyText() {
  if (!connection.isOpen && connection.goodbye) return `The gateway closed this page: ${connection.goodbye}. It tries again by itself.`;
  if (!connection.isOpen) return 'The gateway does not answer; the page tries again by itself. Start it with: haptic-web';
  if (!model.scene) return model.link?.message || 'The gateway waits for hapticd. Start it with: hapticd';
  // While the link is down its banner says why, over the last picture there was.
  const standing = model.link?.state === v1.PageLinkState.PAGE_LINK_STATE_LIVE && pageS() - lastStateS > SHOWN_STATES_S;
  return standing && !model.playback ? 'The daemon is there, but no State arrives: time stands still.' : '';
}

const LOOP_LOOK = { engaged: 'good', fault: 'bad', releasing: 'warn', ready: 'warn', zeroing: 'warn' };

/** Each by itself: what cannot be shown keeps nothing else from being shown. */
function showTexts() {
  const state = model.states.newest;
  parts.run('state', () => showState(state));
  parts.run('link', showLink);
  parts.run('switches', () => looks?.show());
  parts.run('recording', () => playbackBar?.tell(model.shown, session));
  if (state && !model.recorded) parts.run('control', () => control?.show(state));
  parts.run('plots', () => panels?.draw(state));
}

function showState(state) {
  const loop = state ? nameOf(v1.LoopState, 'LOOP_STATE_', state.loop_state) : '';
  setPill(find('loop'), loop, LOOP_LOOK[loop] ?? '');
  const clear = experiment?.engage ?? (session.controls && !model.recorded ? () => session.ask({ clear: {} }) : null);
  banners.set('loop', loopBanner(state, model.fault, clear));
  banners.set('daemon', daemonBanner(model.shown, session.mayControl ? () => session.show('') : null));
}

function showLink() {
  const live = model.link?.state === v1.PageLinkState.PAGE_LINK_STATE_LIVE;
  const lossy = model.link?.loss >= 0.02;
  const linkText = !connection.isOpen ? 'no gateway' : model.recorded ? 'recording' : live ? (lossy ? 'lossy' : 'live') : 'no daemon';
  setPill(find('link'), linkText, !connection.isOpen || (!live && !model.recorded) ? 'bad' : lossy ? 'warn' : 'good');
  banners.set('link', connection.isOpen ? linkBanner(model.link) : null);
  banners.set('loss', lossBanner(model.link));
  const why = emptyText();
  find('empty').hidden = why === '';
  if (find('empty-why').textContent !== why) find('empty-why').textContent = why;
  find('empty').querySelector('h2').textContent = model.scene && connection.isOpen ? 'Nothing moves' : 'Nothing is connected';
}

function setPill(pill, text, look) {
  if (pill.textContent !== text) pill.textContent = text;
  if (pill.className !== `pill ${look}`) pill.className = `pill ${look}`;
}

/** About once a second: what arrived and was drawn in the last seconds, a second of them. A page that is busy counts late, and in bursts. */
function countRates() {
  const now = { atS: pageS(), states: model.received.states, frames: picture.frames, bytes: connection.bytes };
  counted.push(now);
  if (counted.length > RATE_COUNTS) counted.shift();
  const perS = (name) => Math.round((now[name] - counted[0][name]) / (now.atS - counted[0].atS));
  const rates = { states: perS('states'), frames: perS('frames'), bytes: perS('bytes') };
  find('rate').textContent = model.scene ? `${rates.states} States/s${picture.frames ? ` · ${rates.frames} fps` : ''}` : '';
  connectionPanel?.show({ welcome: model.welcome, shown: model.shown, link: model.link, clock: model.clock, connection, rates, scene: model.scene,
    drawn: { triangles: picture.triangles, missing: picture.assets.missing } });
}

function chooseTab(name) {
  document.querySelectorAll('[role=tab]').forEach((tab) => tab.setAttribute('aria-selected', String(tab.dataset.tab === name)));
  document.querySelectorAll('[role=tabpanel]').forEach((panel) => { panel.hidden = panel.id !== name; });
}

function toggleSide() {
  const hidden = document.body.classList.toggle('wide');
  find('side-toggle').setAttribute('aria-expanded', String(!hidden));
}

function showKeys() {
  chooseTab('connection');
  const list = find('keys') ?? document.createElement('dl');
  list.id = 'keys';
  list.innerHTML = KEYS.map(([key, text]) => `<dt><kbd>${key}</kbd></dt><dd>${text}</dd>`).join('');
  find('connection').append(list);
}

document.querySelectorAll('[role=tab]').forEach((tab) => { tab.onclick = () => chooseTab(tab.dataset.tab); });
find('side-toggle').onclick = toggleSide;
listen({ ...looks?.keys(), p: toggleSide, '?': showKeys, ' ': () => playbackBar?.shown && playbackBar.toggle() });
// The address of a restarted gateway differs in its token alone, for which a browser does not load the page again.
window.addEventListener('hashchange', () => location.reload());
setInterval(showTexts, TEXT_MS);
setInterval(() => parts.run('rates', countRates), 1000);
requestAnimationFrame(frame);

// For tests and for people at the console: what is known and drawn.
window.hapticd = { model, panels, session, connection, experiment, film, get picture() { return picture; } };
