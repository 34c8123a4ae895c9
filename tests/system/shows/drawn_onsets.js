// When the page draws the ring of each tone, in headless Chromium: for one_clock.py. Writes a line when it watches, and at the end of its input
// the instants as JSON, [[string, ns of CLOCK_MONOTONIC], ...], with the frames it drew and the error of the clocks' relation.
// usage: node drawn_onsets.js URL, with the folder of the page's packages in HAPTICD_PAGE_SOURCE
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const { chromium } = createRequire(join(process.env.HAPTICD_PAGE_SOURCE, 'package.json'))('playwright-core');
const FLAGS = ['--no-sandbox', '--use-gl=angle', '--use-angle=gl-egl', '--ignore-gpu-blocklist', '--disable-background-networking', '--disable-quic',
  '--no-first-run', '--disable-sync'];
const profile = mkdtempSync(join(tmpdir(), 'hapticd-page-'));
const browser = await chromium.launchPersistentContext(profile, { executablePath: '/usr/bin/chromium', args: FLAGS, viewport: { width: 640, height: 360 } });

/** process.hrtime, which is CLOCK_MONOTONIC, minus the page's clock, ms: of the shortest of many looks. */
async function clockOf(page) {
  let best = { tookMs: Infinity };
  for (let look = 0; look < 200; ++look) {
    const before = process.hrtime.bigint();
    const pageMs = await page.evaluate(() => performance.now());
    const after = process.hrtime.bigint();
    const tookMs = Number(after - before) / 1e6;
    if (tookMs < best.tookMs) best = { tookMs, minusMs: Number(before) / 1e6 + tookMs / 2 - pageMs };
  }
  return best;
}

try {
  const page = browser.pages()[0];
  await page.goto(process.argv[2]);
  await page.waitForFunction(() => window.hapticd?.picture.frames > 3 && window.hapticd.model.scene?.name === 'seven_strings', null, { timeout: 60000 });
  await page.waitForTimeout(3000); // clocks are exchanged
  await page.evaluate(() => {
    // The observer runs right after the function that drew the frame.
    window.drawn = [];
    new MutationObserver((changes) => {
      const nowMs = performance.now();
      for (const change of changes) change.addedNodes.forEach((ring) => window.drawn.push([Number(ring.dataset.string), nowMs]));
    }).observe(document.getElementById('tones'), { childList: true });
  });
  const frames = () => page.evaluate(() => [window.hapticd.picture.frames, performance.now()]);
  const [firstFrame, firstMs] = await frames();
  console.log('watches');
  for await (const _ of process.stdin);
  await page.waitForTimeout(1000);
  const [lastFrame, lastMs] = await frames();
  const clock = await clockOf(page);
  const drawn = await page.evaluate(() => window.drawn);
  console.log(JSON.stringify({ onsets: drawn.map(([string, ms]) => [string, Math.round((ms + clock.minusMs) * 1e6)]),
    frames_per_s: ((lastFrame - firstFrame) * 1000) / (lastMs - firstMs), clock_error_ms: clock.tookMs / 2 }));
} finally {
  await browser.close();
  rmSync(profile, { recursive: true, force: true });
}
