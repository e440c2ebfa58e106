// The native program, for comparison: $SUPEREGG, or that of the workspace. Tests that need it say that they are skipped.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { inflateSync } from 'node:zlib';

export const root = fileURLToPath(new URL('../../../../', import.meta.url));
const program = process.env.SUPEREGG ?? join(root, 'target/release/superegg');

/** Options of a test that needs the native program. */
export const needsNative = existsSync(program) ? {} : { skip: `no native program at ${program}` };

/** Runs the program in an empty folder; `files` are written there first. Returns its output. */
export function native(args, files = {}) {
  return withFolder((folder) => execFileSync(program, args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] }), files);
}

/** Runs the program and returns the bytes of a file that it wrote. */
export function nativeFile(args, output, files = {}) {
  return withFolder((folder) => {
    execFileSync(program, args, { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
    return readFileSync(join(folder, output));
  }, files);
}

function withFolder(work, files) {
  const folder = mkdtempSync(join(tmpdir(), 'superegg-'));
  try {
    for (const [name, content] of Object.entries(files)) writeFileSync(join(folder, name), content);
    return work(folder);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The pixels of a PNG file of 8 bits a channel, as red, green, blue and alpha. */
export function decodePng(file) {
  let [width, height, channels] = [0, 0, 0];
  const parts = [];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    const kind = file.toString('latin1', at + 4, at + 8);
    const body = file.subarray(at + 8, at + 8 + length);
    if (kind === 'IHDR') {
      [width, height] = [body.readUInt32BE(0), body.readUInt32BE(4)];
      channels = { 2: 3, 6: 4 }[body[9]];
      if (body[8] !== 8 || !channels || body[12] !== 0) throw new Error('expected 8 bits, RGB or RGBA, not interlaced');
    }
    if (kind === 'IDAT') parts.push(body);
    at += length + 12;
  }
  const rows = inflateSync(Buffer.concat(parts));
  const stride = width * channels;
  const data = new Uint8ClampedArray(4 * width * height);
  const line = new Uint8Array(stride);
  const above = new Uint8Array(stride);
  for (let y = 0; y < height; y += 1) {
    const filter = rows[y * (stride + 1)];
    for (let i = 0; i < stride; i += 1) {
      const [a, b, c] = [i < channels ? 0 : line[i - channels], above[i], i < channels ? 0 : above[i - channels]];
      const [pa, pb, pc] = [Math.abs(b - c), Math.abs(a - c), Math.abs(a + b - 2 * c)];
      const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
      line[i] = rows[y * (stride + 1) + 1 + i] + [0, a, b, (a + b) >> 1, paeth][filter];
    }
    for (let x = 0; x < width; x += 1) {
      data.set(line.subarray(x * channels, x * channels + channels), 4 * (y * width + x));
      if (channels === 3) data[4 * (y * width + x) + 3] = 255;
    }
    above.set(line);
  }
  return { width, height, data };
}

/** The number of pixels whose channels differ by more than `most`, and the largest difference. */
export function difference(a, b, most = 1) {
  if (a.data.length !== b.data.length) throw new Error(`${a.width} x ${a.height} against ${b.width} x ${b.height}`);
  let [worst, count] = [0, 0];
  for (let at = 0; at < a.data.length; at += 4) {
    const far = Math.max(...[0, 1, 2, 3].map((i) => Math.abs(a.data[at + i] - b.data[at + i])));
    worst = Math.max(worst, far);
    if (far > most) count += 1;
  }
  return { worst, count };
}

/** Numbers in [0, 1), the same in every run. */
export function seeded(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let x = Math.imul(state ^ (state >>> 15), state | 1);
    x ^= x + Math.imul(x ^ (x >>> 7), x | 61);
    return ((x ^ (x >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Two superquadric grains as LIGGGHTS dumps them. */
export const DUMP = `ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS ff ff ff
-1 1
-1 1
-1 1
ITEM: ATOMS id x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2
7 0 0 0 .1 .2 .3 1 0 0 0 8 2
9 .5 0 0 .2 .2 .2 1 0 0 0 2 2
`;
