// The time from the load of the page to its first picture, and pictures a second of the robot arm while it is turned.
//
//     node crates/superegg-web/page/bench.mjs
//
// The browser is headless Chromium, the server is on this machine, and nothing is kept from load to load. Seconds are those of the clock
// where the line does not say otherwise, so the machine should have nothing else to do; its load is printed.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { cpus, loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';
import { deflateRawSync } from 'node:zlib';
import { WorkerPool } from 'superegg';
import { root } from '../package/test/native.js';
import { launch, serve } from './test/browser.js';

const LOADS = 9;
const TURN_MS = 6000;
const program = process.env.SUPEREGG ?? join(root, 'target/release/superegg');
const folder = mkdtempSync(join(tmpdir(), 'superegg-'));
const median = (numbers) => [...numbers].sort((a, b) => a - b)[Math.floor(numbers.length / 2)];
const range = (numbers, digits = 0) => `median ${median(numbers).toFixed(digits)}, ${Math.min(...numbers).toFixed(digits)} to ${Math.max(...numbers).toFixed(digits)}`;

console.log(`${cpus()[0].model}, ${cpus().length} cores, load ${loadavg().map((x) => x.toFixed(1)).join(' ')}`);
execFileSync(program, ['bench', '--save', folder, 'robot']);
const robot = readFileSync(join(folder, 'robot.scn'), 'utf8');
rmSync(folder, { recursive: true });
const [server, browser] = await Promise.all([serve(), launch()]);
try {
  const pool = new WorkerPool(2);
  await pool.load(robot);
  const [whole, free] = [[], []];
  for (let i = 0; i < 12; i += 1) {
    const [begun, used] = [performance.now(), process.cpuUsage()];
    await pool.picture({ width: 800, height: 600, samples: 1 });
    const { user, system } = process.cpuUsage(used);
    // The first ones compile.
    if (i < 2) continue;
    whole.push(1000 / (performance.now() - begun));
    free.push(2e6 / (user + system));
  }
  pool.close();
  console.log(`robot arm 800 x 600, one sample a pixel, two workers in Node: ${range(whole, 1)} pictures a second`);
  console.log(`    on two cores that do nothing else, by processor seconds: ${range(free, 1)}`);

  const first = [];
  for (let i = 0; i < LOADS; i += 1) {
    const context = await browser.newContext({ viewport: { width: 1300, height: 680 }, serviceWorkers: 'block' });
    const page = await context.newPage();
    await page.goto(server.address);
    await page.waitForFunction(() => performance.getEntriesByName('first picture').length > 0);
    first.push(await page.evaluate(() => performance.getEntriesByName('first picture')[0].startTime));
    await context.close();
  }
  console.log(`first picture of the welcome scene after the navigation began: ${range(first)} ms`);

  const page = await browser.newPage({ viewport: { width: 1300, height: 680 } });
  await page.goto(`${server.address}#1.${deflateRawSync(Buffer.from(robot)).toString('base64url')}`);
  await page.waitForFunction(() => document.documentElement.dataset.pass === 'last', undefined, { timeout: 120_000 });
  const turned = await page.evaluate(async (milliseconds) => {
    const canvas = document.querySelector('#picture');
    const box = canvas.getBoundingClientRect();
    const kinds = { coarse: 0, full: 0, last: 0 };
    new MutationObserver((records) => records.forEach(() => {
      const { pass } = document.documentElement.dataset;
      if (pass in kinds) kinds[pass] += 1;
    })).observe(document.documentElement, { attributeFilter: ['data-pass'] });
    canvas.setPointerCapture = () => undefined;
    const send = (kind, angle) => canvas.dispatchEvent(new PointerEvent(kind, {
      pointerId: 1, button: 0, bubbles: true, clientX: box.left + box.width * (0.5 + 0.2 * Math.cos(angle)), clientY: box.top + box.height * (0.5 + 0.2 * Math.sin(angle)),
    }));
    send('pointerdown', 0);
    const begun = performance.now();
    let now = begun;
    while (now - begun < milliseconds) {
      send('pointermove', (now - begun) / 700);
      now = await new Promise(requestAnimationFrame);
    }
    send('pointerup', 0);
    return { kinds, seconds: (now - begun) / 1000, size: [canvas.width, canvas.height], workers: navigator.hardwareConcurrency };
  }, TURN_MS);
  const { kinds, seconds, size, workers } = turned;
  const count = kinds.coarse + kinds.full + kinds.last;
  console.log(`robot arm ${size.join(' x ')} while it is turned, ${workers} workers: ${(count / seconds).toFixed(1)} pictures a second, ${kinds.coarse} of ${count} of them coarse`);
  console.log(`load at the end ${loadavg().map((x) => x.toFixed(1)).join(' ')}`);
} finally {
  await browser.close();
  await server.stop();
}
