// Who may control over a network: with the token, and only by TLS. Two machines, hapticd and haptic-web on one, browsers on both: what is
// refused over plain HTTP from the other machine is done from the gateway's own, and by HTTPS from both. Needs root: namespaces.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { Namespaces, playing, skipWithoutNamespaces, startBrowser, startDaemon, startGateway } from './programs.js';

skipWithoutNamespaces();

const PERMITTED = 1; // RESULT_CODE_OK
const folder = mkdtempSync(join(tmpdir(), 'hapticd-tls-'));
const [certificate, privateKey] = ['cert.pem', 'key.pem'].map((name) => join(folder, name));
let machines, daemon, here, there;

before(async () => {
  execFileSync('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', '-subj', '/CN=haptic-web', '-addext', 'subjectAltName=IP:10.77.0.1',
    '-keyout', privateKey, '-out', certificate], { stdio: 'ignore' });
  machines = new Namespaces();
  daemon = await startDaemon('127.0.0.1:47800', [], { namespace: machines.daemon });
  [here, there] = await Promise.all([machines.daemon, machines.viewer].map((namespace) => startBrowser({ namespace })));
});

after(async () => {
  await Promise.all([here, there].map((browser) => browser?.end()));
  await daemon?.end();
  machines?.remove();
  rmSync(folder, { recursive: true, force: true });
});

/** A gateway that listens on every address of the daemon's machine. */
const start = (...args) => startGateway(['--server', '127.0.0.1:47800', ...args], { listen: '0.0.0.0:0', namespace: machines.daemon });

/** What a page at `url` was told of control, whether Take control can be pressed, and the code of an answer to it. */
async function attempt({ page }, url) {
  await page.goto('about:blank');
  await page.goto(url);
  await playing(page);
  const code = await page.evaluate(async () => {
    const { session } = window.hapticd;
    const { code } = await session.ask({ acquire: { holder: 'test' } }, { quiet: true });
    if (session.lease?.yours || code === 1) await session.ask({ release: {} }, { quiet: true });
    return code;
  });
  await page.click('[data-tab=control]');
  return { told: await page.evaluate(() => window.hapticd.model.welcome.control), button: await page.isEnabled('#lease'), code };
}

const mayControl = (seen) => seen.told === true && seen.button && seen.code === PERMITTED;
const mayOnlyLook = (seen) => seen.told === false && !seen.button && seen.code !== PERMITTED;

test('over plain HTTP only the machine of the gateway may control, with the token', async () => {
  const gateway = await start();
  try {
    assert.match(gateway.program.log, /From another machine: http:\S+ to look; control from there needs --cert and --key-file/);
    const { port, token } = gateway;
    assert.ok(token.length >= 32);
    assert.ok(mayControl(await attempt(here, `http://127.0.0.1:${port}/#token=${token}`)), 'loopback with the token');
    assert.ok(mayOnlyLook(await attempt(here, `http://127.0.0.1:${port}/`)), 'loopback without it');
    assert.ok(mayOnlyLook(await attempt(there, `http://10.77.0.1:${port}/#token=${token}`)), 'the other machine with the token');
  } finally {
    await gateway.end();
  }
});

test('by TLS the other machine may control too, with the token and not with another', async () => {
  const gateway = await start('--cert', certificate, '--key-file', privateKey);
  try {
    const { port, token } = gateway;
    const address = `https://10.77.0.1:${port}/`;
    assert.ok(mayControl(await attempt(there, `${address}#token=${token}`)), 'the token');
    assert.ok(mayOnlyLook(await attempt(there, `${address}#token=${token.replace(/./g, '0')}`)), 'another token');
    assert.ok(mayOnlyLook(await attempt(there, address)), 'no token');
    await assert.rejects(there.page.goto(`http://10.77.0.1:${port}/`), /ERR_/, 'plain HTTP is not spoken at this port');
  } finally {
    await gateway.end();
  }
});
