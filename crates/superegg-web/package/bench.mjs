// Rays a second of one worker, beside the native program on one thread: camera rays of one picture, and a whole picture.
//
//     node crates/superegg-web/package/bench.mjs [SCENE.scn ...]
//
// Both render the same picture, of normals with one sample a pixel for camera rays. Seconds are those of the processor, so that other
// programs on the machine count little; each is the least of some rounds, which alternate. Those of the native program are without
// a picture of one tile, which has the time to start, to read and to compile the scene.

import { execFileSync, spawnSync } from 'node:child_process';
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

/** Processor seconds and rays of the native program. */
function native(file, flags, size) {
  const stats = join(folder, 'stats.json');
  const args = [file, '--size', size, '--samples', '1', '--threads', '1', '--quiet', '--force', ...flags, '-o', join(folder, 'a.png'), '--stats', stats];
  const timed = ['-c', 'TIMEFORMAT="%U %S"; time "$@" >/dev/null 2>&1', 'bench', program, 'render', ...args];
  const { stderr } = spawnSync('bash', timed, { encoding: 'utf8' });
  const [user, system] = stderr.trim().split(' ').map(Number);
  const text = readFileSync(stats, 'utf8');
  const number = (name) => Number(new RegExp(`"${name}": ([\\d.e+-]+)`).exec(text)?.[1] ?? 0);
  const kinds = ['camera', 'shadow', 'ambient', 'reflection', 'refraction'];
  return { seconds: user + system, rays: kinds.reduce((sum, kind) => sum + number(kind), 0) };
}

/** Processor seconds and rays of the module. */
function engine(scene, request) {
  const picture = scene.inner.picture(JSON.stringify({ width, height, samples: 1, ...request }));
  const begin = process.cpuUsage();
  picture.step(Infinity);
  const { user, system } = process.cpuUsage(begin);
  const { rays } = picture;
  picture.free();
  return { seconds: (user + system) / 1e6, rays };
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
      const least = { whole: Infinity, start: Infinity, engine: Infinity };
      let rays = 0;
      for (let round = 0; round < ROUNDS; round += 1) {
        const whole = native(file, flags, `${width}x${height}`);
        const made = engine(scene, request);
        rays = whole.rays;
        least.whole = Math.min(least.whole, whole.seconds);
        least.start = Math.min(least.start, native(file, flags, '32x16').seconds);
        least.engine = Math.min(least.engine, made.seconds);
      }
      const [of, beside] = [rays / least.engine / 1e6, rays / (least.whole - least.start) / 1e6];
      console.log(`${basename(file, '.scn').padEnd(16)} ${name.padEnd(9)} ${beside.toFixed(2).padStart(12)} ${of.toFixed(2).padStart(16)}     1/${(beside / of).toFixed(1)}`);
    }
  }
} finally {
  rmSync(folder, { recursive: true });
}
