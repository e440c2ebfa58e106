// Pictures of the module are those of the native program, within 1 of 255.

import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { parse, render } from 'superegg';
import { engine, start } from 'superegg/engine';
import { decodePng, difference, nativeFile, needsNative, root } from './native.js';

const [width, height] = [96, 72];
const features = readdirSync(join(root, 'scenes/features')).filter((name) => name.endsWith('.scn')).map((name) => join('features', name));
const scenes = ['minimal.scn', 'five_solids.scn', 'crane_arm.scn', 'snowman.scn', 'fractal_tree.scn', 'brass_and_glass.scn', ...features];

/**
 * Scenes in which light goes through the edges of glass, where a normal turns by a right angle within a thousandth of the
 * shape: the last bit of a hit decides where a refracted ray goes, and the native program has fused multiply-add.
 */
const GLASS = ['features/absorption.scn', 'features/coloured_shadow.scn', 'features/nested_glass.scn'];
const MOST_OF_GLASS = 0.001;

/** The pictures that a scene names, which are beside it. */
async function filesOf(file) {
  await start();
  const names = engine.filesNamed(file, readFileSync(file));
  return Object.fromEntries(names.map((name) => [name, readFileSync(join(dirname(file), name))]));
}

for (const name of scenes) {
  test(`picture of ${name}`, needsNative, async () => {
    const file = join(root, 'scenes', name);
    const text = readFileSync(file, 'utf8');
    const samples = 4;
    const expected = decodePng(nativeFile(
      ['render', file, '--size', `${width}x${height}`, '--samples', `${samples}`, '-o', 'a.png'], 'a.png',
    ));
    const actual = await render({ text, files: await filesOf(file) }, { width, height, samples, workers: 2 });
    const { worst, count } = difference(actual, expected);
    const most = GLASS.includes(name) ? MOST_OF_GLASS * width * height : 0;
    assert.ok(count <= most, `${count} pixels differ by more than 1, the worst by ${worst}`);
  });
}

test('each output is that of the program', needsNative, async () => {
  const file = join(root, 'scenes/five_solids.scn');
  const outputs = { normal: 'normal', depth: 'depth', albedo: 'albedo', id: 'instance-id', steps: 'cost', occlusion: 'ao' };
  for (const [output, aov] of Object.entries(outputs)) {
    const expected = decodePng(nativeFile(
      ['render', file, '--size', `${width}x${height}`, '--samples', '1', '--aov', aov, '-o', 'a.png'], 'a.png',
    ));
    const actual = await render(readFileSync(file, 'utf8'), { width, height, samples: 1, output, workers: 2 });
    assert.equal(difference(actual, expected).count, 0, output);
  }
});

test('a frame of keys is that of the program', needsNative, async () => {
  const text = 'prm a\ncoeff 1 .5 .3\nexp .3 .3\nobj b\nap a\nkey 0 rotate z 0\nkey 8 rotate z 80\nkey 8 camera 0 0 6 0 0 0 40\nkey 0 camera 0 -6 1 0 0 0 40\n';
  const scene = await parse(text);
  assert.equal(scene.summary.frames, 9);
  // A scene at a frame keeps its keys.
  const still = await parse({ text, frame: 3.5 });
  assert.equal(still.text, scene.text);
  assert.equal((await parse('prm a')).summary.frames, 0);
  for (const frame of [0, 3.5, 8]) {
    const expected = decodePng(nativeFile(['render', 'a.scn', '--frame', `${frame}`, '--size', `${width}x${height}`, '-o', 'a.png'], 'a.png', { 'a.scn': text }));
    const actual = await render({ text, frame }, { width, height, workers: 2 });
    assert.equal(difference(actual, expected).count, 0, `frame ${frame}`);
  }
  await assert.rejects(parse({ text, frame: NaN }), /finite/);
});

test('pictures that a scene names are found, with or without their folder', async () => {
  const tile = readFileSync(join(root, 'scenes/tile.png'));
  const text = 'prm a\nsetTexture color some/folder/tile.png\nenvironment sky.hdr';
  const plain = await parse(text);
  assert.deepEqual(plain.summary.files.map(({ name, given }) => [name, given]), [['sky.hdr', false], ['some/folder/tile.png', false]]);
  const given = await parse({ text, files: { 'tile.png': tile, 'sky.hdr': tile } });
  const [sky, color] = given.summary.files;
  assert.match(sky.fault, /'sky.hdr' is no picture of surroundings/);
  assert.deepEqual(color, { name: 'some/folder/tile.png', given: true, fault: null });
  const size = { width, height, samples: 1, workers: 1 };
  const [a, b, c] = await Promise.all([
    render(text, size), render({ text, files: { 'tile.png': tile } }, size), render({ text, files: { 'other.png': tile } }, size),
  ]);
  assert.ok(difference(a, b).count > 100);
  assert.equal(difference(a, c).count, 0);
});

test('the picture does not depend on the number of workers', async () => {
  const text = readFileSync(join(root, 'scenes/crane_arm.scn'), 'utf8');
  const pictures = await Promise.all([1, 2, 3].map((workers) => render(text, { width: 70, height: 50, workers })));
  for (const picture of pictures) assert.deepEqual(picture.data, pictures[0].data);
});
