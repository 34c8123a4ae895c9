// The archive for npm as people use it: installed into an empty folder where no registry answers, it hears haptic-web and types a script. Tones are
// compared with equal temperament. By the environment: HAPTICD, HAPTIC_WEB, HAPTICD_PAGE_OUT, HAPTICD_STREAM_PACKAGE, HAPTICD_VERSION.
import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

const { HAPTICD, HAPTIC_WEB, HAPTICD_PAGE_OUT, HAPTICD_STREAM_PACKAGE, HAPTICD_VERSION } = process.env;
const START_MS = 60_000;
const COMPILER = fileURLToPath(new URL('compiler/node_modules/typescript/bin/tsc', import.meta.url));
const STRICT = ['--noEmit', '--strict', '--target', 'es2022', '--module', 'node16', '--moduleResolution', 'node16', '--lib', 'es2022,dom'];

// A script of a user, which has to be without an error, and lines of which each has to have one.
const TYPED = `
import { Connection, StreamModel, stringShape, streamOf, v1 } from 'hapticd-stream';
import type { SceneModel } from 'hapticd-stream';
import { nodeSocket } from 'hapticd-stream/node';
import { length, type Vector } from 'hapticd-stream/vector';

const model = new StreamModel({ handlers: { scene: (scene: SceneModel) => console.log(scene.strings.map((string) => string.frequencyHz)) } });
const connection = new Connection({ ...streamOf('http://127.0.0.1:8080/'), makeSocket: nodeSocket, handlers: { event: (event) => model.take(event) } });
connection.open();
const result: v1.Result = await connection.call({ set_parameter: { assignments: [{ path: 'strings[0].tension_n', number: 41.5 }] } });
if (result.code !== v1.ResultCode.RESULT_CODE_OK) console.log(result.path);
const ns = model.shownNs();
if (ns !== null) {
  const state: v1.State | null = model.states.at(ns);
  const wrench: number[] | undefined = state?.tools[0]?.wrench_h_w;
  for (const tone of model.dueTones(ns)) console.log(tone.frequency_hz.toFixed(1), wrench);
  const scene = model.scene;
  if (scene) console.log(scene.strings.map((string, i) => stringShape(string, i, state?.strings[i], model.motion, ns).radiusM));
}
const force: Vector = [0, 1, 0];
const bytes: Uint8Array = v1.PageRequest.encode({ id: 1, ping: { sent_s: 2 } }).finish();
console.log(length(force), v1.PageRequest.decode(bytes).ping?.sent_s);
connection.close();
`;
const MISTAKES = [
  "connection.call({ set_parameters: {} });",
  "new Connection({ token: 'a' });",
  "model.scene.strings;",
  "const text: string = model.tones[0]!.frequency_hz;",
  "v1.ResultCode.RESULT_CODE_FINE;",
  "model.take(result);",
  "const touched: number = v1.Contact.decode(bytes).string_index;",
];

let folder;
const running = [];

before(() => {
  folder = mkdtempSync(join(tmpdir(), 'hapticd-stream-'));
  writeFileSync(join(folder, 'package.json'), '{"private": true, "type": "module"}');
  const archive = join(HAPTICD_STREAM_PACKAGE, `hapticd-stream-${HAPTICD_VERSION}.tgz`);
  const offline = ['--offline', '--registry', 'http://127.0.0.1:9/', '--cache', join(folder, 'cache'), '--no-audit', '--no-fund', '--silent'];
  execFileSync('npm', ['install', ...offline, archive], { cwd: folder, stdio: 'inherit', env: { ...process.env, HOME: folder } });
});

after(() => {
  for (const each of running) each.kill();
  rmSync(folder, { recursive: true, force: true });
});

/** Starts a program and resolves to the match of `pattern` in what it says. */
function started(command, args, pattern) {
  const program = spawn(command, args, { cwd: folder, env: { ...process.env, XDG_STATE_HOME: '/nonexistent' } });
  running.push(program);
  let log = '';
  return new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error(`${command} does not say ${pattern}: ${log}`)), START_MS);
    const hear = (data) => {
      log += data;
      const match = log.match(pattern);
      if (match) {
        clearTimeout(late);
        resolve({ match, program });
      }
    };
    program.stdout.on('data', hear);
    program.stderr.on('data', hear);
    program.once('error', reject);
  });
}

function freePort() {
  const socket = createSocket('udp4');
  return new Promise((resolve) => socket.bind(0, '127.0.0.1', () => {
    const { port } = socket.address();
    socket.close(() => resolve(port));
  }));
}

test('it is one package of the version of the project, with all that it exports and nothing to fetch', () => {
  const installed = join(folder, 'node_modules/hapticd-stream');
  const manifest = JSON.parse(readFileSync(join(installed, 'package.json'), 'utf8'));
  assert.equal(manifest.version, HAPTICD_VERSION);
  assert.deepEqual([manifest.dependencies, manifest.devDependencies, manifest.scripts], [undefined, undefined, undefined]);
  assert.deepEqual(readdirSync(join(folder, 'node_modules')).filter((name) => !name.startsWith('.')), ['hapticd-stream']);
  for (const { types, default: code } of Object.values(manifest.exports)) for (const path of [types, code]) readFileSync(join(installed, path));
});

test('what is exported and what has a type are the same names', async () => {
  for (const name of ['index', 'node', 'vector']) {
    const path = join(folder, `node_modules/hapticd-stream/src/${name}`);
    const exported = Object.keys(await import(pathToFileURL(`${path}.js`)));
    const types = readFileSync(`${path}.d.ts`, 'utf8');
    const typed = [...types.matchAll(/^export (?:function|class|const) (\w+)/gm)].map((match) => match[1]);
    if (name === 'index') typed.push('v1');
    assert.deepEqual([...new Set(typed)].sort(), exported.sort(), name);
  }
});

test('every message and enum has a type, and every field of it', async () => {
  const { v1 } = await import(pathToFileURL(join(folder, 'node_modules/hapticd-stream/src/index.js')));
  const types = readFileSync(join(folder, 'node_modules/hapticd-stream/src/generated/v1.d.ts'), 'utf8');
  let fields = 0;
  for (const [name, value] of Object.entries(v1)) {
    const body = types.match(new RegExp(`^export (?:interface|enum) ${name} \\{\n(.*?)^\\}`, 'ms'))?.[1];
    assert.ok(body !== undefined, name);
    const named = [...body.matchAll(/^ {2}(\w+)(?::| =)/gm)].map((match) => match[1]).sort();
    const own = typeof value === 'function' ? Object.keys(value.prototype) : Object.keys(value).filter((key) => Number.isNaN(Number(key)));
    // The prototype has the oneofs too, by accessors.
    const plain = own.filter((key) => typeof value !== 'function' || !Object.getOwnPropertyDescriptor(value.prototype, key).get);
    assert.deepEqual(named, plain.filter((key) => key !== 'constructor').sort(), name);
    fields += named.length;
    // What a decoder leaves out is null exactly where the type says so.
    for (const key of typeof value === 'function' ? named : []) {
      assert.equal(new RegExp(`^ {2}${key}: .*\\| null;$`, 'm').test(body), value.prototype[key] === null, `${name}.${key}`);
    }
  }
  assert.ok(fields > 400, `${fields} fields`);
});

test('a script of a user is typed, and each of its mistakes is found', () => {
  writeFileSync(join(folder, 'user.ts'), TYPED + MISTAKES.map((line) => `${line}\n`).join(''));
  const done = spawnSync(process.execPath, [COMPILER, ...STRICT, 'user.ts'], { cwd: folder, encoding: 'utf8' });
  const lines = [...done.stdout.matchAll(/^user\.ts\((\d+),/gm)].map((match) => Number(match[1]));
  const first = TYPED.split('\n').length;
  assert.deepEqual([...new Set(lines)], MISTAKES.map((_, i) => first + i), done.stdout);
});

test('its example hears what haptic-web sends', async () => {
  const port = await freePort();
  await started(HAPTICD, ['--listen', `127.0.0.1:${port}`], /listening on/);
  const { match } = await started(HAPTIC_WEB, ['--listen', '127.0.0.1:0', '--page', HAPTICD_PAGE_OUT, '--server', `127.0.0.1:${port}`], /Open (http:\/\/\S+)/);
  const example = join(folder, 'node_modules/hapticd-stream/print_tones.js');
  const said = execFileSync(process.execPath, [example, match[1], '3'], { cwd: folder, encoding: 'utf8', timeout: START_MS });
  const lines = said.trimEnd().split('\n');
  assert.match(lines[0], /^the scene is \w+$/);
  assert.ok(lines.some((line) => /^tool 0 touches$/.test(line)));
  const tones = [...said.matchAll(/ sounds at ([\d.]+) Hz, level [\d.]+$/gm)].map((each) => Number(each[1]));
  assert.equal(tones.length, 3);
  // Strings are tuned to notes; C2 is 33 semitones below A4 of 440 Hz.
  for (const hz of tones) {
    const note = 12 * Math.log2(hz / 440);
    assert.ok(Math.abs(note - Math.round(note)) < 0.1, `${hz} Hz is no note`);
  }
});
