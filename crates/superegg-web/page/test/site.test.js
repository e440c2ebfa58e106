// The gallery's links open their scenes, and the published folder has the book beside the page.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { root } from '../../package/test/native.js';
import { launch, needsBrowser, serve } from './browser.js';

const PAGE = '../crates/superegg-web/page/index.html';
const gallery = readFileSync(join(root, 'docs/gallery.md'), 'utf8');
const names = [...gallery.matchAll(/\]\(([^)?]*)\?scene=([^)]*)\)/g)].map(([, page, name]) => {
  assert.equal(page, PAGE);
  return name;
});
const needsBook = spawnSync('mdbook', ['--version']).error ? { skip: 'mdbook is not on this machine' } : {};
let browser;

before(async () => {
  if (!needsBrowser.skip) browser = await launch();
});
after(() => browser?.close());

test('every scene has a link from its picture', () => {
  const scenes = (folder) => readdirSync(join(root, 'scenes', folder)).filter((name) => name.endsWith('.scn')).map((name) => join(folder, name.slice(0, -4)));
  assert.deepEqual([...names].sort(), [...scenes('.'), ...scenes('features')].sort());
});

test('every link of the gallery opens its scene with its pictures', needsBrowser, async () => {
  const server = await serve();
  const context = await browser.newContext({ viewport: { width: 500, height: 300 }, serviceWorkers: 'block' });
  try {
    for (const name of names) {
      const page = await context.newPage();
      const errors = [];
      page.on('pageerror', (error) => errors.push(error.message));
      page.on('console', (line) => line.type() === 'error' && errors.push(line.text()));
      await page.goto(`${server.address}index.html?scene=${name}`);
      await page.waitForFunction(() => ['coarse', 'full', 'last'].includes(document.documentElement.dataset.pass), undefined, { timeout: 120_000 });
      const [summary, status, problems, text] = await Promise.all([
        page.locator('#summary').textContent(), page.locator('#status').textContent(), page.locator('#problems').textContent(),
        page.locator('.cm-line').first().textContent(),
      ]);
      assert.match(summary, /^[\d,]+ instance/, name);
      assert.equal(`${status}${problems.replace(/\d+ warnings?/, 'no errors')}`, 'no errors', name);
      assert.equal(text, readFileSync(join(root, 'scenes', `${name}.scn`), 'utf8').split('\n')[0], name);
      assert.deepEqual(errors, [], name);
      await page.close();
    }
  } finally {
    await context.close();
    await server.stop();
  }
});

test('a scene that is not there is an error in words', needsBrowser, async () => {
  const server = await serve();
  const page = await browser.newPage();
  try {
    for (const name of ['nothing', '../secret', 'https://example.org/a']) {
      await page.goto(`${server.address}index.html?scene=${encodeURIComponent(name)}`);
      await page.locator('#status:not(:empty)').waitFor();
      assert.match(await page.locator('#status').textContent(), /there is no/);
      // The page is there as without a link.
      await page.getByText('primitive egg').waitFor();
    }
  } finally {
    await page.close();
    await server.stop();
  }
});

test('the published folder: the book beside the page, and its links', { ...needsBrowser, ...needsBook }, async () => {
  const site = mkdtempSync(join(tmpdir(), 'superegg-site-'));
  const server = await serve(`${site}/`);
  const page = await browser.newPage();
  try {
    execFileSync(join(root, 'tools/site.sh'), [site], { stdio: ['ignore', 'ignore', 'inherit'] });
    const book = `${server.address}book/`;
    const broken = [];
    const pages = readdirSync(join(site, 'book'), { recursive: true }).filter((name) => name.endsWith('.html') && !/^(print|toc|404)\.html$/.test(name));
    for (const name of pages) {
      const html = readFileSync(join(site, 'book', name), 'utf8').replace(/<code.*?<\/code>/gs, '');
      for (const [, target] of html.matchAll(/(?:href|src)="([^"#?]+)[^"]*"/g)) {
        if (/^[a-z]+:/i.test(target)) continue;
        const path = new URL(target, `${book}${name}`).pathname;
        if (!existsSync(join(site, decodeURIComponent(path)))) broken.push(`${name}: ${target}`);
      }
    }
    assert.deepEqual(broken, []);
    await page.goto(`${book}gallery.html`);
    await page.locator('a[href="../index.html?scene=snowman"]').click();
    await page.locator('#summary', { hasText: /^\d+ instances$/ }).waitFor();
    assert.match(await page.locator('.cm-content').innerText(), /snowman/i);
    await page.waitForFunction(() => ['coarse', 'full', 'last'].includes(document.documentElement.dataset.pass));
  } finally {
    await page.close();
    await server.stop();
    rmSync(site, { recursive: true });
  }
});
