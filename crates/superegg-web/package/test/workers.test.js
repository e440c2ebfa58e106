// The workers of a page: the latest picture wins, and nothing holds it up.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from './native.js';
import { Superseded, WorkerPool, blit, render } from 'superegg';

const BALL = 'prm ball\ncolor 1 0 0';
/** A picture of minutes: every tile takes thousands of paths. */
const SLOW = 'set light path\nset samples 4096\nsky 1 1 1 1 1 1\nprm ball\ncolor .5 .5 .5\nfloor -1';

async function withPool(size, work) {
  const pool = new WorkerPool(size);
  try {
    await work(pool);
  } finally {
    pool.close();
  }
}

test('a new picture takes the place of the one in the making', () => withPool(2, async (pool) => {
  await pool.load(SLOW);
  const old = pool.picture({ width: 200, height: 150 });
  const small = await pool.picture({ width: 32, height: 16, samples: 1 });
  assert.equal(await old, undefined);
  assert.ok(small.rays >= 512);
}));

test('a worker that is deep in a tile is replaced by one that has the scene', () => withPool(2, async (pool) => {
  await pool.load(SLOW);
  const old = pool.picture({ width: 64, height: 32 });
  await new Promise((resolve) => setTimeout(resolve, 200));
  const info = await pool.load(BALL);
  assert.equal(info.summary.root, 'ball');
  assert.equal(await old, undefined);
  const data = new Uint8ClampedArray(4 * 64 * 48);
  await pool.picture({ width: 64, height: 48, samples: 1 }, { onTiles: (tiles, pixels) => blit(data, 64, tiles, pixels) });
  const middle = data.subarray(4 * (24 * 64 + 32), 4 * (24 * 64 + 32) + 3);
  assert.ok(middle[0] > 100 && middle[1] < 100, `${middle}`);
}));

test('each scene has its own files, which are sent once', () => withPool(1, async (pool) => {
  const tile = readFileSync(join(root, 'scenes/tile.png'));
  const text = 'prm a\nsetTexture color tile.png';
  const given = async (source) => (await pool.load(source)).summary.files[0].given;
  assert.equal(await given({ text, files: { 'tile.png': tile } }), true);
  assert.equal(await given({ text: `${text}\nexp .5 .5`, files: { 'tile.png': tile } }), true);
  assert.equal(await given(text), false);
  assert.equal(await given({ text, files: { 'tile.png': tile } }), true);
  const { fault } = (await pool.load({ text, files: { 'tile.png': tile.subarray(0, 60) } })).summary.files[0];
  assert.match(fault, /no texture/);
  // A scene that takes the place of one that waits for the engine still has its files.
  await withPool(1, async (cold) => {
    const first = cold.load({ text, files: { 'tile.png': tile } });
    const second = cold.load({ text: `${text} 2`, files: { 'tile.png': tile } });
    await assert.rejects(first, Superseded);
    assert.equal((await second).summary.files[0].given, true);
  });
}));

test('a scene that another one replaces is superseded', () => withPool(1, async (pool) => {
  const first = pool.load(BALL);
  const second = pool.load('prm other');
  await assert.rejects(first, Superseded);
  assert.equal((await second).summary.root, 'other');
}));

test('a wrong request and a wrong file are errors, and the pool goes on', () => withPool(1, async (pool) => {
  await pool.load(BALL);
  await assert.rejects(pool.picture({ width: 0, height: 10 }), /width/);
  await assert.rejects(pool.picture({ output: 'beauty' }), /expected one of light/);
  await assert.rejects(pool.ask({ about: 'export', file: 'a.jpg', tolerance: 1e-3 }), /names no format/);
  await assert.rejects(pool.load({ name: 'a.bin', bytes: new Uint8Array([0, 255, 254]) }), /neither a scene nor data/);
  await pool.load(BALL);
  assert.ok(await pool.picture({ width: 8, height: 8, samples: 1 }));
}));

test('questions are answered while a picture is made', () => withPool(1, async (pool) => {
  const { camera } = await pool.load('set samples 64\nprm ball');
  const picture = pool.picture({ width: 640, height: 480 });
  const hit = await pool.ask({ about: 'pick', camera, width: 640, height: 480, x: 320, y: 240 });
  assert.equal(hit.path, 'ball');
  assert.ok(Math.abs(hit.t - 9) < 1e-9);
  const grid = await pool.ask({ about: 'grid', camera });
  assert.ok(grid.inside.some((inside) => inside === 1) && grid.inside.some((inside) => inside === 0));
  pool.abandon();
  assert.equal(await picture, undefined);
}));

test('an empty scene has a picture', async () => {
  const { data } = await render('', { width: 8, height: 8, workers: 1 });
  assert.equal(data.length, 256);
});
