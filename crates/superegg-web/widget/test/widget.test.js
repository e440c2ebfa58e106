// The widget in a page without a server for its files, as a notebook: a stub in place of the kernel's half.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { decodePng, difference, native, nativeFile, needsNative, root } from '../../package/test/native.js';
import { launch, needsBrowser, screens } from '../../page/test/browser.js';

const dist = fileURLToPath(new URL('../dist/', import.meta.url));
const needs = needsBrowser.skip ? needsBrowser : existsSync(join(dist, 'widget.js')) ? {} : { skip: 'the widget is not built' };
const EGG = 'up z\ncamera 0 -5 2 0 0 0 40\ncameraUp 0 0 1\nlight a 3 -4 5\nsky .9 .9 .9\nprm egg\ncoeff 1 1 1.3\nexp 1 .8\ncolor orange\n';
let [browser, script, module] = [];

before(async () => {
  if (needs.skip) return;
  browser = await launch();
  script = readFileSync(join(dist, 'widget.js'), 'utf8');
  module = readFileSync(join(dist, 'superegg.wasm.gz')).toString('base64');
});
after(() => browser?.close());

/** A page with a widget, as a notebook shows it: the script comes from a blob, and so must all else. */
async function withWidget(traits, work, options = {}) {
  const context = await browser.newContext({ viewport: { width: 640, height: 480 } });
  const page = await context.newPage();
  const errors = [];
  const requests = [];
  page.on('pageerror', (error) => errors.push(error.stack ?? String(error)));
  page.on('console', (line) => line.type() === 'error' && errors.push(line.text()));
  page.on('request', (request) => /^https?:/.test(request.url()) && requests.push(request.url()));
  await context.route('http://notebook/**', (route) => {
    if (route.request().url().endsWith('.gz')) return route.fulfill({ body: readFileSync(join(dist, 'superegg.wasm.gz')) });
    return route.fulfill({ contentType: 'text/html', body: '<!doctype html><title>Notebook</title><div id="a"></div><div id="b"></div>' });
  });
  try {
    await page.goto('http://notebook/');
    await page.evaluate(async ({ script, module, traits, answers }) => {
      const empty = () => new DataView(new ArrayBuffer(0));
      const bytes = (letters) => new DataView(Uint8Array.from(atob(letters), (c) => c.charCodeAt(0)).buffer);
      globalThis.asked = 0;
      globalThis.makeModel = (more) => {
        const listeners = new Map();
        const values = {
          text: '', binary: empty(), files: {}, frame: null, size: [320, 240], output: 'light', camera: null, hit: null, note: '', module: '', ...more,
        };
        const call = (event, ...given) => listeners.get(event)?.forEach((hear) => hear(...given));
        return {
          values, listeners, saved: 0,
          get: (key) => values[key],
          /** As Backbone does: equal values are no change. */
          set(key, value) {
            const isEqual = JSON.stringify(values[key]) === JSON.stringify(value);
            values[key] = value;
            if (!isEqual) call(`change:${key}`);
          },
          save_changes() { this.saved += 1; },
          on: (event, hear) => listeners.set(event, (listeners.get(event) ?? new Set()).add(hear)),
          off: (event, hear) => listeners.get(event)?.delete(hear),
          send(content) {
            globalThis.asked += 1;
            if (answers) setTimeout(() => call('msg:custom', content, [bytes(module)]), 10);
          },
        };
      };
      globalThis.load = async () => (await import(URL.createObjectURL(new Blob([script], { type: 'text/javascript' })))).default;
      const { files = {}, ...others } = traits;
      globalThis.model = globalThis.makeModel({ ...others, files: Object.fromEntries(Object.entries(files).map(([name, letters]) => [name, bytes(letters)])) });
      globalThis.end = (await globalThis.load()).render({ model: globalThis.model, el: document.querySelector('#a') });
    }, { script, module, traits, answers: options.answers ?? true });
    await work(page);
    assert.deepEqual(errors, []);
    assert.deepEqual(requests.filter((url) => url !== 'http://notebook/'), options.requests ?? []);
  } finally {
    await context.close();
  }
}

const finished = (page, of = '#a') => page.locator(`${of} canvas[data-pass="last"]`).waitFor({ timeout: 120_000 });

/** Waits for the picture of what is changed by `work`. */
async function picture(page, work) {
  await page.evaluate(() => { document.querySelector('#a canvas').dataset.pass = 'test'; });
  await work?.();
  await finished(page);
  return pixels(page);
}

async function pixels(page, of = '#a') {
  const [data, width, height] = await page.evaluate((of) => {
    const canvas = document.querySelector(`${of} canvas`);
    const { data, width, height } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return [Array.from(data), width, height];
  }, of);
  return { data: Uint8ClampedArray.from(data), width, height };
}

const value = (page, key) => page.evaluate((key) => globalThis.model.values[key], key);
const set = (page, key, value) => page.evaluate(([key, value]) => globalThis.model.set(key, value), [key, value]);

function expected({ width, height }, text, files = {}, flags = []) {
  return decodePng(nativeFile(['render', 'a.scn', '--size', `${width}x${height}`, ...flags, '-o', 'a.png'], 'a.png', { 'a.scn': text, ...files }));
}

test('the picture is that of the native program, and nothing is fetched', { ...needs, ...needsNative }, () => withWidget({ text: EGG }, async (page) => {
  await finished(page);
  const made = await pixels(page);
  assert.deepEqual([made.width, made.height], [320, 240]);
  assert.equal(difference(made, expected(made, EGG)).count, 0);
  await page.screenshot({ path: join(screens, 'widget.png') });
}));

test('drags, keys and Python turn the view, and the model has its camera', needs, () => withWidget({ text: EGG }, async (page) => {
  await finished(page);
  const home = await pixels(page);
  const before = await value(page, 'camera');
  assert.deepEqual(before.slice(0, 6), [0, -5, 2, 0, 0, 0]);
  const turned = await picture(page, async () => {
    await page.mouse.move(160, 120);
    await page.mouse.down();
    await page.mouse.move(230, 90, { steps: 4 });
    await page.mouse.up();
  });
  assert.ok(difference(home, turned, 8).count > 100);
  await page.waitForFunction((before) => globalThis.model.values.camera[0] !== before[0], before);
  const after = await value(page, 'camera');
  const distance = ([x, y, z]) => Math.hypot(x, y, z);
  assert.ok(Math.abs(distance(after) - distance(before)) < 1e-9);
  // Python sets the camera that the scene had.
  const back = await picture(page, () => set(page, 'camera', before));
  assert.equal(difference(home, back, 0).count, 0);
  await page.locator('#a canvas').focus();
  const keyed = await picture(page, () => page.keyboard.press('ArrowLeft'));
  assert.ok(difference(home, keyed, 8).count > 100);
  await page.waitForFunction((before) => globalThis.model.values.camera[0] !== before[0], before);
  // A second view of the model begins where the first one is.
  await page.evaluate(async () => (await globalThis.load()).render({ model: globalThis.model, el: document.querySelector('#b') }));
  await finished(page, '#b');
  assert.equal(difference(await pixels(page), await pixels(page, '#b'), 0).count, 0);
  // One module serves all widgets of a page.
  assert.equal(await page.evaluate(() => globalThis.asked), 1);
}));

test('a click sets the hit, as the native program reports it', { ...needs, ...needsNative }, () => withWidget({ text: EGG }, async (page) => {
  await finished(page);
  await page.locator('#a canvas').click({ position: { x: 160, y: 120 } });
  await page.waitForFunction(() => globalThis.model.values.hit !== null);
  const hit = await value(page, 'hit');
  const reported = Number(/at t = ([\d.]+)/.exec(native(['intersect', 'a.scn'], { 'a.scn': EGG }))[1]);
  assert.ok(Math.abs(hit.t - reported) < 0.02, `${hit.t} ${reported}`);
  assert.deepEqual([hit.path, hit.primitive, hit.point.length, hit.normal.length], ['egg', 'egg', 3, 3]);
  await page.locator('#a canvas').click({ position: { x: 5, y: 5 } });
  await page.waitForFunction(() => globalThis.model.values.hit === null);
}));

test('text, frame, size, output and files follow the model', { ...needs, ...needsNative }, () => withWidget({ text: EGG }, async (page) => {
  await finished(page);
  const keyed = `${EGG}obj b\nap egg\nkey 0 rotate x 0\nkey 10 rotate x 60\n`;
  await picture(page, () => set(page, 'text', keyed));
  const at7 = await picture(page, () => set(page, 'frame', 7));
  assert.equal(difference(at7, expected(at7, keyed, {}, ['--frame', '7'])).count, 0);
  const wide = await picture(page, () => set(page, 'size', [400, 200]));
  assert.deepEqual([wide.width, wide.height], [400, 200]);
  const normals = await picture(page, () => set(page, 'output', 'normal'));
  assert.ok(difference(wide, normals, 8).count > 1000);
  await set(page, 'text', 'prm a\nsetColr 1');
  await page.waitForFunction(() => /line 2/.test(globalThis.model.values.note));
  await set(page, 'text', 'prm a\nsetTexture color b.png');
  await page.waitForFunction(() => /'b.png' is missing/.test(globalThis.model.values.note));
}));

test('files of the model lie on surfaces', { ...needs, ...needsNative }, async () => {
  const tile = readFileSync(join(root, 'scenes/tile.png'));
  const text = `${EGG}setTexture color tile.png .5\n`;
  await withWidget({ text, files: { 'tile.png': tile.toString('base64') } }, async (page) => {
    await finished(page);
    const made = await pixels(page);
    assert.equal(difference(made, expected(made, text, { 'tile.png': tile })).count, 0);
  });
});

test('the module comes from an address, too', needs, () => withWidget({ text: EGG, module: 'http://notebook/superegg.wasm.gz' }, async (page) => {
  await finished(page);
  assert.equal(await page.evaluate(() => globalThis.asked), 0);
}, { requests: ['http://notebook/superegg.wasm.gz'] }));

test('the end of a view ends its workers and its listeners', needs, () => withWidget({ text: EGG }, async (page) => {
  await finished(page);
  assert.ok(page.workers().length > 0);
  await page.evaluate(() => globalThis.end());
  for (let tries = 0; page.workers().length > 0; tries += 1) {
    assert.ok(tries < 100, 'a worker goes on');
    await page.waitForTimeout(50);
  }
  assert.equal(await page.evaluate(() => [...globalThis.model.listeners.values()].reduce((sum, set) => sum + set.size, 0)), 0);
  await set(page, 'text', 'prm b');
}));
