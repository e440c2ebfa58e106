// Rays a second of one worker, beside the native program on one thread: camera rays of one picture, and a whole picture.
//
//     node crates/superegg-web/package/bench.mjs [SCENE.scn ...]
//
// Both render the same picture, of normals with one sample a pixel for camera rays; each figure is the best of some rounds,
// which alternate. Compiling the scene is not counted.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parse } from 'superegg';

const ROUNDS = 5;
const [width, height] = [1280, 960];
const root = fileURLToPath(new URL('../../../', import.meta.url));
const program = process.env.SUPEREGG ?? join(root, 'target/release/superegg');
const folder = mkdtempSync(join(tmpdir(), 'superegg-'));

/** Seconds and rays of the native program. */
function native(file, flags) {
  const stats = join(folder, 'stats.json');
  const size = ['--size', `${width}x${height}`, '--samples', '1', '--threads', '1', '--quiet', '--force'];
  execFileSync(program, ['render', file, ...size, ...flags, '-o', join(folder, 'a.png'), '--stats', stats], { stdio: 'ignore' });
  const text = readFileSync(stats, 'utf8');
  const number = (name) => Number(new RegExp(`"${name}": ([\\d.e+-]+)`).exec(text)?.[1] ?? 0);
  return { seconds: number('render'), rays: ['camera', 'shadow', 'ambient', 'reflection', 'refraction'].reduce((sum, kind) => sum + number(kind), 0) };
}

function engine(scene, request) {
  const picture = scene.inner.picture(JSON.stringify({ width, height, samples: 1, ...request }));
  const begin = performance.now();
  picture.step(Infinity);
  const seconds = (performance.now() - begin) / 1000;
  const { rays } = picture;
  picture.free();
  return { seconds, rays };
}

try {
  let files = process.argv.slice(2);
  if (files.length === 0) {
    execFileSync(program, ['bench', '--save', folder, 'cloud:1000', 'robot']);
    files = [join(folder, 'cloud_1000.scn'), join(folder, 'robot.scn')];
  }
  console.log('scene            picture   native Mrays/s   module Mrays/s   share');
  for (const file of files) {
    const scene = await parse(readFileSync(file, 'utf8'));
    scene.inner.camera(width, height);
    for (const [name, flags, request] of [['normals', ['--aov', 'normal'], { output: 'normal' }], ['light', [], {}]]) {
      const best = { native: 0, engine: 0 };
      for (let round = 0; round < ROUNDS; round += 1) {
        for (const [which, run] of [['native', () => native(file, flags)], ['engine', () => engine(scene, request)]]) {
          const { seconds, rays } = run();
          best[which] = Math.max(best[which], rays / seconds / 1e6);
        }
      }
      const share = `1/${(best.native / best.engine).toFixed(1)}`;
      console.log(`${basename(file, '.scn').padEnd(16)} ${name.padEnd(9)} ${best.native.toFixed(2).padStart(12)} ${best.engine.toFixed(2).padStart(16)}     ${share}`);
    }
  }
} finally {
  rmSync(folder, { recursive: true });
}
