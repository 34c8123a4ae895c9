// The programs of the tests of the whole: hapticd, haptic-web and Chromium, each where it is wanted, here or in a network namespace, and all
// of them ended. By the environment: HAPTICD, HAPTICCTL, HAPTIC_WEB, HAPTICD_PAGE_OUT (the built page), HAPTICD_PAGE_SOURCE (its packages).
import { execFileSync, spawn } from 'node:child_process';
import { randomBytes } from 'node:crypto';
import { createSocket } from 'node:dgram';
import { chmodSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const CHROMIUM = '/usr/bin/chromium';
const FLAGS = ['--no-sandbox', '--disable-background-networking', '--disable-quic', '--no-first-run', '--disable-sync'];
const WITH_3D = ['--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist'];
const WITHOUT_3D = ['--disable-gpu', '--disable-3d-apis'];
const SKIPPED = 77; // SKIP_RETURN_CODE of every test
const START_MS = 60_000;
const END_MS = 20_000;

/** Ends this test as skipped, with the reason, where this system makes no network namespaces. */
export function skipWithoutNamespaces() {
  if (canMakeNamespaces()) return;
  console.log(`SKIPPED: ${process.getuid() === 0 ? 'this system makes no network namespaces (ip netns)' : 'only root can make network namespaces'}`);
  process.exit(SKIPPED);
}

function canMakeNamespaces() {
  try {
    new Namespaces().remove();
    return true;
  } catch {
    return false;
  }
}

const ip = (...words) => execFileSync('ip', words, { stdio: ['ignore', 'pipe', 'pipe'] });

/** Two machines and a cable: namespaces `daemon` (10.77.0.1) and `viewer` (10.77.0.2), joined by a pair of virtual Ethernet devices. */
export class Namespaces {
  constructor() {
    const unique = randomBytes(3).toString('hex');
    this.daemon = `hapticd-d-${unique}`;
    this.viewer = `hapticd-v-${unique}`;
    this.cable = `hv${unique}`;
    try {
      ip('netns', 'add', this.daemon);
      ip('netns', 'add', this.viewer);
      ip('-n', this.daemon, 'link', 'add', 'cable', 'type', 'veth', 'peer', 'name', this.cable);
      ip('-n', this.daemon, 'link', 'set', this.cable, 'netns', this.viewer, 'name', 'cable');
      ip('-n', this.daemon, 'address', 'add', '10.77.0.1/24', 'dev', 'cable');
      ip('-n', this.viewer, 'address', 'add', '10.77.0.2/24', 'dev', 'cable');
      for (const side of [this.daemon, this.viewer]) {
        ip('-n', side, 'link', 'set', 'lo', 'up');
        ip('-n', side, 'link', 'set', 'cable', 'up');
      }
    } catch (error) {
      this.remove();
      throw error;
    }
  }

  /** Pulls the cable at the viewer's end, or puts it in again. */
  plug(isIn) {
    ip('-n', this.viewer, 'link', 'set', 'cable', isIn ? 'up' : 'down');
  }

  remove() {
    for (const side of [this.daemon, this.viewer]) {
      try {
        ip('netns', 'delete', side);
      } catch {
        // it was never made
      }
    }
  }
}

/** A program that runs until end(); `log` has what it says. */
export class Program {
  log = '';
  #ended;

  constructor(command, args, { namespace = null, env = {} } = {}) {
    const words = namespace ? ['ip', 'netns', 'exec', namespace, command, ...args] : [command, ...args];
    this.process = spawn(words[0], words.slice(1), { env: { ...process.env, ...env }, stdio: ['ignore', 'pipe', 'pipe'] });
    for (const stream of [this.process.stdout, this.process.stderr]) stream.on('data', (data) => { this.log += data; });
    this.#ended = new Promise((resolve) => this.process.once('close', resolve));
  }

  /** The match of `pattern` in what it says, as soon as it says it. */
  async says(pattern) {
    const end = Date.now() + START_MS;
    while (Date.now() < end) {
      const match = this.log.match(pattern);
      if (match) return match;
      if (this.process.exitCode !== null) break;
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
    throw new Error(`${this.process.spawnargs.join(' ')} does not say ${pattern}; it said: ${this.log}`);
  }

  async end(signal = 'SIGTERM') {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    this.process.kill(signal);
    const late = setTimeout(() => this.process.kill('SIGKILL'), END_MS);
    await this.#ended;
    clearTimeout(late);
  }
}

/** A hapticd that listens at `listen`, HOST:PORT. */
export async function startDaemon(listen, args = [], options = {}) {
  const env = { XDG_STATE_HOME: '/nonexistent', ...options.env };
  const daemon = new Program(process.env.HAPTICD, ['--listen', listen, ...args], { ...options, env });
  await daemon.says(/listening on/);
  return daemon;
}

/** A haptic-web on a port of its own choice: {program, address, url (with the token, where there is one)}. */
export async function startGateway(args, { listen = '127.0.0.1:0', ...options } = {}) {
  const program = new Program(process.env.HAPTIC_WEB, ['--listen', listen, '--page', process.env.HAPTICD_PAGE_OUT, ...args], options);
  const [, url, port] = await program.says(/Open (https?:\/\/\S+?:(\d+)\/\S*)/);
  return { program, url, port: Number(port), token: url.split('#token=')[1] ?? '', end: () => program.end() };
}

/** What hapticctl prints. */
export function hapticctl(...words) {
  return execFileSync(process.env.HAPTICCTL, words, { encoding: 'utf8', timeout: START_MS });
}

/** A port of UDP that was free a moment ago. */
export function freePort() {
  const socket = createSocket('udp4');
  return new Promise((resolve) => socket.bind(0, '127.0.0.1', () => {
    const { port } = socket.address();
    socket.close(() => resolve(port));
  }));
}

/** Headless Chromium with a profile of its own, in `namespace` if there is one, with or without 3D drawing: {page, newPage(), end()}. */
export async function startBrowser({ namespace = null, without3d = false } = {}) {
  const { chromium } = createRequire(join(process.env.HAPTICD_PAGE_SOURCE, 'package.json'))('playwright-core');
  const folder = mkdtempSync(join(tmpdir(), 'hapticd-viewer-'));
  let executablePath = CHROMIUM;
  if (namespace) {
    executablePath = join(folder, 'chromium');
    writeFileSync(executablePath, `#!/bin/sh\nexec ip netns exec ${namespace} ${CHROMIUM} "$@"\n`);
    chmodSync(executablePath, 0o755);
  }
  const browser = await chromium.launchPersistentContext(join(folder, 'profile'),
    { executablePath, args: [...FLAGS, ...(without3d ? WITHOUT_3D : WITH_3D)], viewport: { width: 1280, height: 720 }, ignoreHTTPSErrors: true, timeout: START_MS });
  browser.setDefaultTimeout(START_MS);
  const end = async () => {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
  };
  return { page: browser.pages()[0], newPage: () => browser.newPage(), end };
}

/** Waits until States arrive at `page` and frames are drawn of them. */
export async function playing(page) {
  await page.waitForFunction(() => window.hapticd?.model.states.newest && window.hapticd.picture.frames > 3);
}

/** The text of the banner `kind` of `page`, once it holds `words`. */
export async function banner(page, kind, words) {
  const shown = page.locator(`.banner[data-kind=${kind}]`, { hasText: words });
  await shown.waitFor();
  return shown.textContent();
}
