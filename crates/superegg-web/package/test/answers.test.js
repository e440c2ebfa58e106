// Rays, points, meshes, texts and files: laws, the oracle, and the native program's answers.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { intersect, mesh, parse } from 'superegg';
import { DUMP, native, nativeFile, needsNative, root, seeded } from './native.js';

const rows = (csv) => csv.trim().split('\n').slice(1).map((line) => line.split(','));

test('the oracle of 40 digits', async () => {
  const truth = rows(readFileSync(join(root, 'crates/superegg-geom/tests/data/rays.csv'), 'utf8'));
  let checked = 0;
  for (const row of truth) {
    const [e, n, ...rest] = row;
    const [ox, oy, oz, dx, dy, dz] = rest.map(Number);
    const [isHit, t, margin] = [row[9] === '1', Number(row[10]), Number(row[14])];
    if (!(margin > 1e-6)) continue;
    const hits = await intersect(`prm a\nexp ${e} ${n}`, new Float64Array([ox, oy, oz]), new Float64Array([dx, dy, dz]));
    assert.equal(Number.isFinite(hits.t[0]), isHit, row.join());
    if (isHit) assert.ok(Math.abs(hits.t[0] - t) <= 1e-6 * (1 + t), `${row.join()}: t ${hits.t[0]}`);
    checked += 1;
  }
  assert.ok(checked > 1000, `${checked} rays`);
});

/** Rays from a sphere around the origin towards a box. */
function rays(count, seed, radius = 6) {
  const next = seeded(seed);
  const column = (of) => Float64Array.from({ length: 3 * count }, of);
  const origins = column(() => radius * (2 * next() - 1));
  const aims = column(() => 1.5 * (2 * next() - 1));
  return [origins, aims.map((x, i) => x - origins[i])];
}

test('laws of hits: on the surface, normals of length 1, the same one by one', async () => {
  const next = seeded(7);
  for (let round = 0; round < 200; round += 1) {
    const [e, n] = [0, 0].map(() => 10 ** (-2 + 2.5 * next()));
    const [a, b, c] = [0, 0, 0].map(() => 10 ** (-1 + 2 * next()));
    const scene = await parse(`prm a\ncoeff ${a} ${b} ${c}\nexp ${e} ${n}`);
    const [origins, directions] = rays(50, round);
    const hits = scene.intersect(origins, directions);
    for (let i = 0; i < 50; i += 1) {
      const of = (column) => column.subarray(3 * i, 3 * i + 3);
      const one = scene.firstHit(of(origins), of(directions));
      assert.equal(one === undefined, hits.t[i] === Infinity);
      if (!one) continue;
      const length = Math.hypot(...of(directions));
      assert.ok(Math.abs(one.t - hits.t[i] * length) <= 1e-7 * (1 + one.t), `${one.t} for ${hits.t[i] * length}`);
      assert.ok(Math.abs(Math.hypot(...of(hits.normals)) - 1) < 1e-9);
      assert.equal(hits.path(i), 'a');
      // The gauge N is 1 on the surface.
      const [x, y, z] = of(hits.points).map((value, axis) => Math.abs(value) / [a, b, c][axis]);
      const r = Math.max(x, y) * ((x / Math.max(x, y)) ** (2 / e) + (y / Math.max(x, y)) ** (2 / e)) ** (e / 2) || 0;
      const m = Math.max(r, z);
      const gauge = m * ((r / m) ** (2 / n) + (z / m) ** (2 / n)) ** (n / 2);
      assert.ok(Math.abs(gauge - 1) < 1e-6, `N ${gauge} for e ${e} n ${n}`);
      const inward = of(hits.points).map((value) => value * 0.999);
      assert.equal(scene.inside(inward)[0], 1);
    }
    scene.free();
  }
});

test('hits are those of the native program', needsNative, async () => {
  for (const name of ['crane_arm', 'stars', 'fractal_tree', 'snowman']) {
    const file = join(root, `scenes/${name}.scn`);
    const [origins, directions] = rays(500, 3, 12);
    const lines = ['ox,oy,oz,dx,dy,dz'];
    for (let at = 0; at < origins.length; at += 3) lines.push([...origins.subarray(at, at + 3), ...directions.subarray(at, at + 3)].join());
    const csv = native(['intersect', file, '--rays', 'rays.csv'], { 'rays.csv': lines.join('\n') });
    const head = csv.split('\n')[0].split(',');
    const hits = await intersect(readFileSync(file, 'utf8'), origins, directions);
    rows(csv).forEach((row, i) => {
      const t = row[head.indexOf('t')];
      if (!t || !Number.isFinite(Number(t))) assert.equal(hits.t[i], Infinity, `${name} ray ${i}`);
      else assert.ok(Math.abs(hits.t[i] - Number(t)) <= 1e-9 * (1 + Number(t)), `${name} ray ${i}: ${hits.t[i]} for ${t}`);
    });
  }
});

test('errors are those of the language, at the right columns', async () => {
  const scene = await parse('prm égg 😀\nprm a\nsetColr 1 0 0\ncolor 1 0 2\nload x.scn\n');
  const [name, unknown, range, load] = scene.findings;
  assert.equal(name.code, 'argument-count');
  assert.deepEqual([unknown.line, unknown.from, unknown.to, unknown.code], [3, 0, 7, 'unknown-command']);
  assert.match(unknown.help, /did you mean 'setColor'/);
  assert.deepEqual([range.line, range.from, range.to], [4, 10, 11]);
  assert.deepEqual([load.line, load.severity, load.code], [5, 'warning', 'not-here']);
  const { summary } = scene;
  assert.deepEqual([summary.root, summary.instances], ['a', '1']);
});

test('the text of a scene reads back as the same scene', async () => {
  for (const name of ['crane_arm', 'chess', 'features/lens', 'features/patterns']) {
    const scene = await parse(readFileSync(join(root, `scenes/${name}.scn`), 'utf8'));
    const again = await parse(scene.text);
    assert.equal(again.text, scene.text);
    assert.deepEqual(again.findings, []);
  }
});

test('meshes lie on the surfaces, and files are those of the native program', needsNative, async () => {
  const file = join(root, 'scenes/crane_arm.scn');
  const text = readFileSync(file, 'utf8');
  const { positions, normals, colors, indices, instanceOfTriangle, paths } = await mesh(text, 1e-2);
  assert.equal(positions.length, normals.length);
  assert.equal(positions.length, colors.length);
  assert.equal(indices.length, 3 * instanceOfTriangle.length);
  assert.ok(indices.every((index) => 3 * index < positions.length));
  assert.ok(instanceOfTriangle.every((instance) => instance < paths.length));
  const scene = await parse(text);
  for (const ending of ['pov', 'csv']) {
    const expected = nativeFile(['export', file, '-o', `a.${ending}`], `a.${ending}`).toString();
    const actual = Buffer.from(scene.export(`a.${ending}`)).toString();
    sameNumbers(actual, expected, ending);
  }
  const expected = nativeFile(['export', file, '-o', 'a.stl'], 'a.stl');
  // The powers of two systems differ in the last digits, and with them the number of chords of a few arcs.
  const length = scene.export('a.stl').length;
  assert.ok(Math.abs(length - expected.length) < 0.005 * expected.length, `${length} for ${expected.length}`);
  assert.throws(() => scene.export('a.jpg'), /names no format/);
});

/** Two texts are the same but for the last digits of their numbers: the powers of two systems differ there. */
function sameNumbers(actual, expected, what) {
  const number = /-?\d+\.?\d*(?:e[-+]?\d+)?/g;
  assert.equal(actual.replace(number, '#'), expected.replace(number, '#'), what);
  const [a, b] = [actual.match(number).map(Number), expected.match(number).map(Number)];
  a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) <= 1e-6 * (1 + Math.abs(b[i])), `${what}: ${x} for ${b[i]}`));
}

test('files of other programs', async () => {
  const scene = await parse({ name: 'grains.dump', bytes: new TextEncoder().encode(DUMP) });
  assert.equal(scene.summary.instances, '2');
  assert.match(scene.notes[0], /LIGGGHTS.*2 shapes/);
  assert.deepEqual([...scene.inside(new Float64Array([0, 0, 0.29, 0, 0, 0.31]))], [1, 0]);
});

test('no bytes break the engine', async () => {
  const next = seeded(11);
  const seeds = [DUMP, readFileSync(join(root, 'scenes/crane_arm.scn'), 'latin1'), '# vtk DataFile Version 3.0\n', 'NRRD0004\n', 'glTF'];
  for (let round = 0; round < 400; round += 1) {
    const bytes = Buffer.from(seeds[round % seeds.length], 'latin1');
    for (let change = 0; change < 1 + round / 20; change += 1) bytes[Math.floor(next() * bytes.length)] = Math.floor(256 * next());
    try {
      (await parse({ name: 'x', bytes })).free();
    } catch (error) {
      // A trap of the module is no answer.
      assert.ok(!(error instanceof WebAssembly.RuntimeError), `${error.stack}\n${bytes}`);
    }
  }
});
