// The page in a real browser.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { deflateRawSync } from 'node:zlib';
import { DUMP, decodePng, difference, native, nativeFile, needsNative, root } from '../../package/test/native.js';
import { launch, needsBrowser, screens, serve } from './browser.js';

const EGG = 'primitive egg\ncoeff 1 1 1.3\nexp 1 .8\ncolor orange\n';
const TEXTURED = 'environment studio.hdr -90\nprm a\ncoeff 1 1 .8\nexp .5 .5\nsetTexture color tile.png .5\n';
const KEYED = 'prm a\ncoeff 1 .5 .3\nexp .3 .3\ncolor orange\nobj b\nap a\nkey 0 rotate z 0\nkey 12 rotate z 80\n';
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
let [server, browser] = [undefined, undefined];

before(async () => {
  if (needsBrowser.skip) return;
  [server, browser] = await Promise.all([serve(), launch()]);
});
after(async () => {
  await browser?.close();
  await server?.stop();
});

/** A page, and the errors of its scripts, which fail the test at its end. */
async function withPage(work, { path = '', ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 440 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.stack ?? String(error)));
  page.on('console', (line) => {
    if (line.type() === 'error') errors.push(line.text());
  });
  try {
    await page.goto(server.address + path);
    await work(page, context);
    assert.deepEqual(errors, []);
  } finally {
    await context.close();
  }
}

const finished = (page) => page.waitForFunction(() => document.documentElement.dataset.pass === 'last', undefined, { timeout: 120_000 });

/** Waits for the picture of what is changed by `work`. */
async function picture(page, work) {
  await page.evaluate(() => { document.documentElement.dataset.pass = 'test'; });
  await work?.();
  await finished(page);
  return pixels(page);
}

/** Waits until the page shows this picture: one of an earlier text, or without the last file, may come first. */
async function becomes(page, expected) {
  let count;
  for (let i = 0; i < 150; i += 1) {
    ({ count } = difference(await pixels(page), expected));
    if (count === 0) return;
    await page.waitForTimeout(200);
  }
  assert.equal(count, 0);
}

/** The pixels of the picture, as a PNG file would have them. */
async function pixels(page) {
  const [text, width, height] = await page.evaluate(() => {
    const canvas = document.querySelector('#picture');
    const { data, width, height } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let letters = '';
    for (let at = 0; at < data.length; at += 4096) letters += String.fromCharCode(...data.subarray(at, at + 4096));
    return [btoa(letters), width, height];
  });
  return { data: Buffer.from(text, 'base64'), width, height };
}

async function type(page, text) {
  await page.locator('.cm-content').click();
  await page.keyboard.press('Control+a');
  await page.keyboard.insertText(text);
}

const fragment = (text) => `#1.${deflateRawSync(Buffer.from(text)).toString('base64url')}`;
const problems = (page) => page.locator('#problems').textContent();

test('a typed scene has the picture of the native program', { ...needsBrowser, ...needsNative }, () => withPage(async (page) => {
  // The first picture would otherwise be taken for that of the text.
  await finished(page);
  const made = await picture(page, () => type(page, EGG));
  const { width, height } = made;
  const expected = decodePng(nativeFile(['render', 'egg.scn', '--size', `${width}x${height}`, '-o', 'a.png'], 'a.png', { 'egg.scn': EGG }));
  assert.equal(difference(made, expected).count, 0);
}, { path: fragment('prm a') }));

test('a drag turns the scene, and Home brings it back to the bit', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  const home = await pixels(page);
  const box = await page.locator('#picture').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const turned = await picture(page, async () => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 30, { steps: 5 });
    await page.mouse.up();
  });
  assert.ok(difference(home, turned, 8).count > 100);
  const back = await picture(page, async () => {
    await page.locator('#picture').focus();
    await page.keyboard.press('Home');
  });
  assert.equal(difference(home, back, 0).count, 0);
  const zoomed = await picture(page, async () => {
    await page.mouse.move(x, y);
    await page.mouse.wheel(0, -300);
  });
  assert.ok(difference(home, zoomed, 8).count > 100);
}, { path: fragment(EGG) }));

test('a click reads the hit, as the native program reports it', { ...needsBrowser, ...needsNative }, () => withPage(async (page) => {
  await finished(page);
  const box = await page.locator('#picture').boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const hit = page.locator('#hit');
  await hit.getByText('egg').waitFor();
  const words = await hit.innerText();
  const said = native(['intersect', 'egg.scn'], { 'egg.scn': EGG });
  const t = Number(/^t\s+([\d.]+)/.exec(words)[1]);
  const expected = Number(/at t = ([\d.]+)/.exec(said)[1]);
  assert.ok(Math.abs(t - expected) < 0.02, `${words} | ${said}`);
  assert.match(words, /Newton/);
  // The click selects the primitive, whose slider changes the text.
  await page.locator('#exponents').waitFor();
  await picture(page, () => page.locator('#n').fill('0.3'));
  assert.match(await page.locator('.cm-content').innerText(), /exp 1 0\.3/);
}, { path: fragment(EGG) }));

test('a broken line is underlined with its text, and mended', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  await type(page, `${EGG}setColr 1 0 0`);
  await page.locator('.cm-lintRange-error').waitFor();
  assert.equal(await problems(page), '1 error');
  await page.locator('.cm-lintRange-error').hover();
  await page.getByText("did you mean 'setColor'?").waitFor();
  await picture(page, () => type(page, `${EGG}setColor 1 0 0`));
  assert.equal(await page.locator('.cm-lintRange-error').count(), 0);
  const { data, width, height } = await pixels(page);
  const middle = 4 * (Math.floor(height / 2) * width + Math.floor(width / 2));
  assert.ok(data[middle] > 100 && data[middle + 1] < 90, `${[...data.subarray(middle, middle + 4)]}`);
  await picture(page, () => page.keyboard.press('Control+z'));
  assert.match(await page.locator('.cm-content').innerText(), /setColr/);
}, { path: fragment(EGG) }));

test('completion and help come from the table of commands', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  await type(page, `${EGG}setGl`);
  await page.locator('.cm-tooltip-autocomplete').getByText('setGloss').waitFor();
  await page.keyboard.press('Escape');
  await type(page, `${EGG}xs `);
  await page.locator('.se-hint').waitFor();
  assert.match(await page.locator('.se-hint').innerText(), /x/);
}, { path: fragment(EGG) }));

test('a link opens as it was sent, and hostile ones are refused', needsBrowser, async () => {
  await withPage(async (page, context) => {
    await context.grantPermissions(['clipboard-read', 'clipboard-write']);
    await finished(page);
    await picture(page, () => type(page, EGG));
    await page.getByRole('button', { name: 'Copy link' }).click();
    await page.getByText('the link is copied').waitFor();
    const link = await page.evaluate(() => navigator.clipboard.readText());
    const other = await context.newPage();
    await other.goto(link);
    await finished(other);
    assert.match(await other.locator('.cm-content').innerText(), /exp 1 \.8/);
  });
  const bomb = `#1.${deflateRawSync(Buffer.alloc(50_000_000, 'a')).toString('base64url')}`;
  const hostile = ['#1.<script>', '#1.AAAA', '#2.abc', '#1.', bomb, fragment('\u0000').slice(0, -1), `#1.${'A'.repeat(200_000)}`];
  for (const link of hostile) {
    await withPage(async (page) => {
      await page.locator('#status:not(:empty)').waitFor();
      assert.match(await page.locator('#status').innerText(), /link/);
      // The page is there as without a link.
      assert.match(await page.locator('.cm-content').innerText(), /primitive egg/);
    }, { path: link });
  }
});

test('a scene without end does not hold up the page', needsBrowser, () => withPage(async (page) => {
  const slow = 'set light path\nset samples 4096\nset size 30000x30000\nsky 1 1 1 1 1 1\nfloor -1\nprm a\nobj f\nap a\nao f\nscale .9 .9 .9\ntranslate .1 0 0\nao f g\nscale .9 .9 .9\ntranslate 0 .1 0\n';
  await page.evaluate((text) => { location.hash = text; }, fragment(slow));
  await page.getByText('ao f g').waitFor();
  await picture(page, () => type(page, EGG));
  assert.equal(await problems(page), 'no errors');
}, { path: fragment(EGG) }));

/** Drops files: their names, and each a text or bytes. */
async function drop(page, files) {
  const sent = Object.entries(files).map(([name, content]) => [name, Buffer.from(content).toString('base64')]);
  const data = await page.evaluateHandle((sent) => {
    const transfer = new DataTransfer();
    for (const [name, letters] of sent) transfer.items.add(new File([Uint8Array.from(atob(letters), (c) => c.charCodeAt(0))], name));
    return transfer;
  }, sent);
  await page.dispatchEvent('main', 'drop', { dataTransfer: data });
}

/** The native program's picture of a scene in a folder with further files, of the size of another picture. */
function nativePicture({ width, height }, text, { files = {}, flags = [] } = {}) {
  const args = ['render', 'a.scn', '--size', `${width}x${height}`, ...flags, '-o', 'a.png'];
  return decodePng(nativeFile(args, 'a.png', { 'a.scn': text, ...files }));
}

test('a dump of another program is dropped', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  await picture(page, () => drop(page, { 'grains.dump': DUMP }));
  await page.getByText('2 instances').waitFor();
  assert.match(await page.locator('.cm-content').innerText(), /LIGGGHTS/);
  await drop(page, { 'junk.bin': '\u0000\u0001\ufffd' });
  await page.locator('#status:not(:empty)').waitFor();
}, { path: fragment(EGG) }));

test('dropped pictures lie on surfaces and light the scene as in the native program', { ...needsBrowser, ...needsNative }, () => withPage(async (page) => {
  await finished(page);
  await page.getByText("drop 'studio.hdr', 'tile.png' here").waitFor();
  const files = { 'tile.png': readFileSync(join(root, 'scenes/tile.png')), 'studio.hdr': readFileSync(join(root, 'scenes/studio.hdr')) };
  const plain = await pixels(page);
  const made = await picture(page, () => drop(page, files));
  // The scene is shown anew with each of them.
  await page.getByText("'studio.hdr' is a picture of this scene").waitFor();
  await page.waitForFunction(() => document.documentElement.dataset.pass === 'last');
  const shown = await pixels(page);
  await becomes(page, nativePicture(made, TEXTURED, { files }));
  assert.ok(difference(plain, shown, 8).count > 1000);
  // A JPEG that this browser wrote, by another name.
  const jpeg = Buffer.from(await page.evaluate(async () => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 40, height: 24 });
    const context = canvas.getContext('2d');
    for (let i = 0; i < 15; i += 1) {
      context.fillStyle = ['#c33', '#3c3', '#33c', '#cc3'][i % 4];
      context.fillRect(8 * (i % 5), 8 * Math.floor(i / 5), 8, 8);
    }
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, 'image/jpeg', 0.9));
    return btoa(String.fromCharCode(...new Uint8Array(await blob.arrayBuffer())));
  }), 'base64');
  await drop(page, { 'squares.jpg': jpeg });
  await page.getByText("'setTexture color squares.jpg' shows it").waitFor();
  const text = 'prm a\nsetTexture color squares.jpg\nexp .5 .5\n';
  const other = await picture(page, () => type(page, text));
  await becomes(page, nativePicture(other, text, { files: { 'squares.jpg': jpeg } }));
  await drop(page, { 'squares.jpg': jpeg.subarray(0, 50) });
  await page.getByText("'squares.jpg' is no texture").waitFor();
}, { path: fragment(TEXTURED) }));

test('frames of keys: the slider, the keys, and playing', { ...needsBrowser, ...needsNative }, () => withPage(async (page) => {
  await finished(page);
  assert.equal(await page.locator('#frames').isVisible(), false);
  await picture(page, () => type(page, KEYED));
  await page.locator('#frames').waitFor();
  const at9 = await picture(page, () => page.locator('#frame').fill('9'));
  assert.equal(difference(at9, nativePicture(at9, KEYED, { flags: ['--frame', '9'] })).count, 0);
  await page.locator('#picture').focus();
  await picture(page, () => page.keyboard.press('.'));
  await picture(page, () => page.keyboard.press('.'));
  await picture(page, () => page.keyboard.press(','));
  assert.equal(await page.locator('#frame').inputValue(), '10');
  await page.keyboard.press('Space');
  await page.getByRole('button', { name: 'Stop' }).waitFor();
  await page.waitForFunction(() => document.querySelector('#frame').value !== '10');
  await page.keyboard.press('Space');
  await page.getByRole('button', { name: 'Play' }).waitFor();
  // A scene without keys has no frames.
  await picture(page, () => type(page, EGG));
  await page.locator('#frames').waitFor({ state: 'hidden' });
}, { path: fragment(EGG) }));

test('m, p and q: the next quantity, stop and go on, the text', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  await page.locator('#picture').focus();
  const light = await pixels(page);
  const normals = await picture(page, () => page.keyboard.press('m'));
  assert.equal(await page.locator('#output').inputValue(), 'normal');
  assert.ok(difference(light, normals, 8).count > 1000);
  for (let i = 0; i < 4; i += 1) await picture(page, () => page.keyboard.press('m'));
  assert.equal(await page.locator('#output').inputValue(), 'light');
  await page.keyboard.press('p');
  await page.getByText('the picture is finished').waitFor();
  await page.keyboard.press('q');
  assert.ok(await page.evaluate(() => document.activeElement.classList.contains('cm-content')));
  // A picture of minutes.
  await page.evaluate(() => { document.documentElement.dataset.pass = 'test'; });
  await type(page, `set light path\nset samples 4096\nsky 1 1 1 1 1 1\n${EGG}`);
  await page.waitForFunction(() => document.documentElement.dataset.pass === 'full');
  await page.locator('#picture').focus();
  await page.keyboard.press('p');
  await page.getByText('paused').waitFor();
  await page.keyboard.press('p');
  await page.getByText('4096 samples ...').or(page.locator('#refine[hidden]')).first().waitFor({ state: 'attached' });
  assert.equal(await page.locator('#refine').isVisible(), false);
}, { path: fragment(EGG) }));

test('files are downloaded', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  for (const ending of ['scn', 'png', 'stl', 'glb']) {
    const [file] = await Promise.all([page.waitForEvent('download'), page.locator('#download').selectOption(ending)]);
    assert.equal(file.suggestedFilename(), `egg.${ending}`);
    assert.ok(readFileSync(await file.path()).length > 40);
  }
}, { path: fragment(EGG) }));

test('the page goes on without a network, and opens again', needsBrowser, () => withPage(async (page) => {
  // A server that goes away.
  const leaving = await serve();
  await page.goto(leaving.address);
  await finished(page);
  // The page itself and all that it has loaded are kept. waitForFunction does not await a promise: it takes one as true.
  const isKept = () => page.evaluate(async () => {
    const loaded = performance.getEntriesByType('resource').map((entry) => entry.name);
    const own = [location.href, ...loaded].filter((address) => new URL(address).origin === location.origin);
    const kept = await Promise.all(own.map((address) => caches.match(address, { ignoreSearch: true })));
    return navigator.serviceWorker.controller?.state === 'activated' && own.length > 4 && kept.every(Boolean);
  });
  for (let tries = 0; !(await isKept()); tries += 1) {
    assert.ok(tries < 600, 'the page is not kept');
    await page.waitForTimeout(100);
  }
  await leaving.stop();
  await picture(page, () => type(page, EGG));
  await page.reload();
  await finished(page);
}));

test('by keyboard alone: text, picture, tests, help', needsBrowser, () => withPage(async (page) => {
  await finished(page);
  await page.locator('#picture').focus();
  const home = await pixels(page);
  const turned = await picture(page, () => page.keyboard.press('ArrowLeft'));
  assert.ok(difference(home, turned, 8).count > 50);
  const overlay = () => page.evaluate(() => {
    const canvas = document.querySelector('#overlay');
    return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value > 0);
  });
  for (const key of ['o', 'i', 't', 'a']) {
    await page.keyboard.press(key);
    await page.waitForFunction(() => {
      const canvas = document.querySelector('#overlay');
      return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value > 0);
    });
    await page.keyboard.press(key);
    await page.waitForFunction(() => {
      const canvas = document.querySelector('#overlay');
      return !canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value > 0);
    });
    assert.equal(await overlay(), false, key);
  }
  await page.keyboard.press('?');
  await page.getByRole('dialog').getByText('inside-outside test', { exact: true }).waitFor();
  await page.keyboard.press('Escape');
  await page.keyboard.press('c');
  await page.getByText('the view is the camera of the scene now').waitFor();
  assert.match(await page.locator('.cm-content').innerText(), /^camera /m);
  // Tab leaves the text.
  await page.locator('.cm-content').focus();
  await page.keyboard.press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement.closest('.cm-editor')), null);
}, { path: fragment(EGG) }));

for (const colorScheme of ['light', 'dark']) {
  test(`axe finds no serious fault, ${colorScheme}`, needsBrowser, () => withPage(async (page) => {
    await finished(page);
    const faults = async () => {
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => globalThis.axe.run());
      return violations.filter(({ impact }) => impact === 'serious' || impact === 'critical').map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html)}`);
    };
    assert.deepEqual(await faults(), []);
    await page.locator('#help').click();
    assert.deepEqual(await faults(), []);
  }, { colorScheme }));
}

for (const [width, height] of [[1440, 900], [900, 700], [390, 844]]) {
  test(`nothing is cut off at ${width} x ${height}`, needsBrowser, () => withPage(async (page) => {
    await finished(page);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${wide} pixels too wide`);
    for (const id of ['share', 'help', 'picture', 'examples']) {
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box.x >= 0 && box.x + box.width <= width + 0.5 && box.width > 20, id);
    }
    await page.screenshot({ path: join(screens, `page-${width}.png`) });
    // Files can be opened at every width.
    const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.locator('#examples').selectOption({ label: 'Open files ...' })]);
    await picture(page, () => chooser.setFiles({ name: 'egg.scn', mimeType: 'text/plain', buffer: Buffer.from(EGG) }));
    assert.equal(await page.locator('#summary').textContent(), '1 instance');
  }, { viewport: { width, height } }));
}

test('a page embeds two scenes, and three.js draws a mesh', needsBrowser, async () => {
  await withPage(async (page) => {
    await page.waitForFunction(() => [...document.querySelectorAll('superegg-scene')].length === 2);
    const loaded = page.evaluate(() => Promise.all([...document.querySelectorAll('superegg-scene')].map((scene) => {
      scene.scrollIntoView();
      const canvas = scene.shadowRoot.querySelector('canvas');
      return new Promise((resolve) => {
        const look = () => {
          const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
          if (data.some((value) => value > 0 && value < 255)) resolve(canvas.getAttribute('aria-label'));
          else setTimeout(look, 50);
        };
        look();
      });
    })));
    assert.match((await loaded).join(), /An egg.*A snowman/);
    await page.screenshot({ path: join(screens, 'embed.png'), fullPage: true });
  }, { path: 'embed.html' });
  await withPage(async (page) => {
    await page.waitForFunction(() => Number(document.documentElement.dataset.triangles) > 1000);
    await page.screenshot({ path: join(screens, 'three.png') });
  }, { path: 'three.html' });
});
