// Two machines: hapticd with keys on one, haptic-web with only view.key and Chromium on the other. Who looks sees what is played and cannot
// change it; and when nothing is seen the page says which of the ways it cannot be seen it is. Needs root: the machines are network namespaces.
import assert from 'node:assert/strict';
import { copyFileSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { banner, hapticctl, Namespaces, playing, Program, skipWithoutNamespaces, startBrowser, startDaemon, startGateway } from './programs.js';

skipWithoutNamespaces();

const DAEMON = '10.77.0.1:47800';
const folder = mkdtempSync(join(tmpdir(), 'hapticd-remote-'));
const viewKey = join(folder, 'viewer', 'view.key');
let machines, daemon, browser, page;

before(async () => {
  machines = new Namespaces();
  for (const name of ['keys', 'others']) hapticctl('keygen', join(folder, name));
  // The viewer's machine has this one file and no other.
  rmSync(join(folder, 'viewer'), { recursive: true, force: true });
  hapticctl('keygen', join(folder, 'viewer'));
  rmSync(join(folder, 'viewer', 'control.key'));
  copyFileSync(join(folder, 'keys', 'view.key'), viewKey);
  daemon = await startDaemon(DAEMON, ['--keys', join(folder, 'keys')], { namespace: machines.daemon });
  browser = await startBrowser({ namespace: machines.viewer });
  page = browser.page;
});

after(async () => {
  await browser?.end();
  await daemon?.end();
  machines?.remove();
  rmSync(folder, { recursive: true, force: true });
});

/** Shows `look` a page of a gateway that was started in the viewer's namespace. */
async function through(args, look) {
  const gateway = await startGateway(args, { namespace: machines.viewer });
  try {
    await page.goto(gateway.url);
    await look(gateway);
  } finally {
    await gateway.end();
  }
}

test('a contact and a pluck are seen on the other machine', async () => {
  await through(['--server', DAEMON, '--key', viewKey], async () => {
    await playing(page);
    await page.click('[data-view=close]');
    // The ring of a tone, put into the page at the instant the string is let go.
    await page.waitForSelector('#tones i.tone', { state: 'attached' });
    // A contact in the newest State, and its yellow dot, #ffd54a, around where it is.
    const yellow = await page.waitForFunction(() => {
      const { model, picture } = window.hapticd;
      const state = model.states.newest;
      const contact = state?.contacts[0];
      if (!contact) return 0;
      picture.draw(state, model.shownNs());
      const at = picture.project([...contact.p_wc_um].slice(0, 3).map((value) => value * 1e-6));
      if (!at) return 0;
      const gl = picture.stage.renderer.getContext();
      const size = 40;
      const pixels = new Uint8Array(4 * size * size);
      gl.readPixels(Math.round(at.x) - size / 2, gl.drawingBufferHeight - Math.round(at.y) - size / 2, size, size, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let count = 0;
      for (let i = 0; i < pixels.length; i += 4) {
        if (Math.abs(pixels[i] - 255) + Math.abs(pixels[i + 1] - 213) + Math.abs(pixels[i + 2] - 74) <= 40) ++count;
      }
      return count;
    });
    assert.ok(await yellow.jsonValue() >= 1);
    assert.equal(await page.textContent('#link'), 'live');
  });
});

test('who has only view.key is refused control, by the page and by the gateway', async () => {
  await through(['--server', DAEMON, '--key', viewKey], async (gateway) => {
    assert.equal(gateway.token, '', 'there is no token to be had');
    // Where only the fragment changed, the page would load itself anew, at an instant of its own.
    await page.goto('about:blank');
    await page.goto(`${gateway.url}#token=0123456789abcdef0123456789abcdef`);
    await playing(page);
    await page.click('[data-tab=control]');
    assert.ok(await page.isDisabled('#lease') && await page.isDisabled('#stop') && await page.isDisabled('#load'));
    assert.match(await page.textContent('#lease-note'), /may only look/);
    for (const wanted of [{ acquire: { holder: 'intruder' } }, { stop: {} }, { load_scene: { name: 'sphere' } }]) {
      const result = await page.evaluate((item) => window.hapticd.session.ask(item, { quiet: true }), wanted);
      assert.notEqual(result.code, 1, `${JSON.stringify(wanted)} is refused`);
      assert.match(result.message, /look|control|token/i);
    }
    assert.equal(await page.evaluate(() => window.hapticd.model.scene.name), 'guqin');
    assert.equal(await page.locator('.banner[data-kind=loop]').count(), 0, 'nothing was stopped');
  });
});

test('wrong key, no route, another version and no daemon each have their own message in the page', async () => {
  const messages = {};
  await through(['--server', DAEMON, '--key', join(folder, 'others', 'view.key')], async () => {
    messages.key = await banner(page, 'link', 'The key is refused');
    assert.match(messages.key, /hapticd --keys/);
  });
  await through(['--server', '10.77.0.1:47804', '--key', viewKey], async () => {
    messages.gone = await banner(page, 'link', 'The daemon is gone');
    assert.match(messages.gone, /Start hapticd/);
  });
  const other = new Program(process.execPath, [new URL('other_major.js', import.meta.url).pathname, '10.77.0.1', '47802'], { namespace: machines.daemon });
  try {
    await other.says(/listening/);
    await through(['--server', '10.77.0.1:47802', '--key', viewKey], async () => {
      messages.version = await banner(page, 'link', 'The daemon speaks another version');
      assert.match(messages.version, /wire major 2.*speaks 1/);
    });
  } finally {
    await other.end();
  }
  machines.plug(false);
  try {
    await through(['--server', DAEMON, '--key', viewKey], async () => {
      messages.route = await banner(page, 'link', 'No route to the daemon');
      assert.match(messages.route, /network of this machine/);
      machines.plug(true);
      await playing(page);
      await page.waitForFunction(() => document.querySelector('.banner[data-kind=link]') === null);
    });
  } finally {
    machines.plug(true);
  }
  assert.equal(new Set(Object.values(messages)).size, 4);
});
