// Pictures of the module are those of the native program, within 1 of 255.

import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { render } from 'superegg';
import { decodePng, difference, nativeFile, needsNative, root } from './native.js';

const [width, height] = [96, 72];
const features = readdirSync(join(root, 'scenes/features')).filter((name) => name.endsWith('.scn')).map((name) => join('features', name));
const scenes = ['minimal.scn', 'five_solids.scn', 'crane_arm.scn', 'snowman.scn', 'fractal_tree.scn', 'brass_and_glass.scn', ...features];

/**
 * Scenes in which light goes through the edges of glass, where a normal turns by a right angle within a thousandth of the
 * shape: the last bit of a hit decides where a refracted ray goes, and the native program has fused multiply-add.
 */
const GLASS = ['features/absorption.scn', 'features/coloured_shadow.scn'];
const MOST_OF_GLASS = 0.001;

/** Scenes with pictures of textures, which the module does not read: their surfaces are plain there. */
const TEXTURES = ['features/textures.scn'];

for (const name of scenes.filter((scene) => !TEXTURES.includes(scene))) {
  test(`picture of ${name}`, needsNative, async () => {
    const file = join(root, 'scenes', name);
    const text = readFileSync(file, 'utf8');
    const samples = 4;
    const expected = decodePng(nativeFile(
      ['render', file, '--size', `${width}x${height}`, '--samples', `${samples}`, '-o', 'a.png'], 'a.png',
    ));
    const named = /^environment (\S+)/m.exec(text);
    const surroundings = named ? readFileSync(join(root, 'scenes', named[1])) : undefined;
    const actual = await render(surroundings ? { text, surroundings } : text, { width, height, samples, workers: 2 });
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

test('the picture does not depend on the number of workers', async () => {
  const text = readFileSync(join(root, 'scenes/crane_arm.scn'), 'utf8');
  const pictures = await Promise.all([1, 2, 3].map((workers) => render(text, { width: 70, height: 50, workers })));
  for (const picture of pictures) assert.deepEqual(picture.data, pictures[0].data);
});
