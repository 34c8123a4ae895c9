// Takes a picture of the page in headless Chromium, as CLIENTS of the project has it: software GL, a fresh profile, no network of its own.
// usage: node take_picture.js URL FILE.png [WIDTHxHEIGHT] [SECONDS] [KEY OR #SELECTOR TO CLICK]...
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const [url, file, size = '1280x720', seconds = '4', ...actions] = process.argv.slice(2);
const source = process.env.HAPTICD_PAGE_SOURCE ?? new URL('../../../clients/web/page/', import.meta.url).pathname;
const { chromium } = createRequire(join(source, 'package.json'))('playwright-core');
const [width, height] = size.split('x').map(Number);
const profile = mkdtempSync(join(tmpdir(), 'hapticd-page-'));
const flags = ['--no-sandbox', '--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist', '--disable-background-networking',
  '--disable-quic', '--no-first-run', '--disable-sync'];
const browser = await chromium.launchPersistentContext(profile, { executablePath: '/usr/bin/chromium', args: flags, viewport: { width, height } });
try {
  const page = browser.pages()[0];
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && console.log(message.type(), message.text()));
  page.on('pageerror', (error) => console.log('pageerror', error.stack));
  await page.goto(url);
  await page.waitForTimeout(Number(seconds) * 1000);
  for (const action of actions) {
    if (action.startsWith('#') || action.startsWith('[')) await page.click(action);
    else if (action.startsWith('wait:')) await page.waitForTimeout(1000 * Number(action.slice(5)));
    else await page.keyboard.press(action);
    await page.waitForTimeout(1200);
  }
  await page.screenshot({ path: file });
  console.log(await page.textContent('#rate'), 'triangles', await page.evaluate(() => window.hapticd.picture.triangles));
} finally {
  await browser.close();
  rmSync(profile, { recursive: true, force: true });
}
