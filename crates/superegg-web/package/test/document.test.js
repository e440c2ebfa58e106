// A text that is edited: completion, hints, colours, and the exponents that sliders change.

import assert from 'node:assert/strict';
import { before, test } from 'node:test';
import { engine, start } from 'superegg/engine';

before(() => start());

const document = (text) => new engine.Document(text);
const exponents = (text, name, line = 0) => {
  const found = document(text).exponents(name, line);
  return found === undefined ? undefined : JSON.parse(found);
};

/** A text after the edit that a slider makes. */
function edited(text, found, e, n) {
  const lines = text.split('\n');
  const line = engine.Document.exponentLine(found.word, e, n);
  if (found.is_new) lines.splice(found.line + 1, 0, line);
  else lines[found.line] = lines[found.line].slice(0, found.from) + line + lines[found.line].slice(found.to);
  return lines.join('\n');
}

test('exponents are changed where the text sets them', () => {
  const cases = [
    ['prm a\nexp 1 1\ncolor red', 'a', 'prm a\nexp 0.5 2\ncolor red'],
    ['prm a\nprm b\nexp 3 3', 'a', 'prm a\nsetExponent 0.5 2\nprm b\nexp 3 3'],
    ['prm a; exp 1 1 # é\n', 'a', 'prm a; exp 0.5 2 # é\n'],
    ['prm 😀; exp 1 1; color red', '😀', 'prm 😀; exp 0.5 2; color red'],
    ['prm a\nexp 1 1\nobj o\nap a\nprm a\nEXPONENT 2 2', 'a', 'prm a\nexp 1 1\nobj o\nap a\nprm a\nEXPONENT 0.5 2'],
  ];
  for (const [text, name, expected] of cases) {
    const found = exponents(text, name);
    const after = edited(text, found, 0.5, 2);
    assert.equal(after, expected);
    const again = exponents(after, name);
    assert.deepEqual([again.e, again.n], [0.5, 2]);
  }
  assert.equal(exponents('prm a', 'b'), undefined);
  assert.equal(exponents('obj o', undefined, 0), undefined);
  assert.equal(exponents('prm a\nprm b', undefined, 1).name, 'b');
  assert.equal(exponents('prm a\nprm b', undefined, 0).name, 'a');
});

test('completion and hints know the names before the cursor', () => {
  const text = document('prm ball\nobj man\nap ball head\n');
  const words = (line, before) => JSON.parse(text.complete(line, before));
  assert.deepEqual(words(3, 'cur ').words.map(({ word }) => word), ['head']);
  assert.deepEqual(words(2, 'cur ').words, []);
  const command = words(3, '  setCo');
  assert.equal(command.from, 2);
  assert.deepEqual(command.words.map(({ word }) => word), ['setCoeff', 'setColor']);
  assert.match(command.words[1].info, /colour/);
  assert.match(text.hint(1, 'xs 1 '), /y.*z/);
  assert.equal(text.hint(1, '# a'), undefined);
});

test('colours are those of the language, in UTF-16 units', () => {
  const text = document('prm 😀');
  assert.deepEqual([...text.highlight('info 😀 # 😀')], [0, 4, 0, 5, 7, 1, 8, 12, 4]);
  assert.deepEqual([...text.highlight('nonsense 1 ')], [0, 8, 3]);
});

test('help and keys are those of the tables', () => {
  assert.match(engine.helpForCommand('exp'), /setExponent/);
  assert.equal(engine.helpForCommand('nonsense'), undefined);
  assert.match(engine.helpFor('soft shadows'), /lightRadius/);
  const keys = JSON.parse(engine.keys());
  assert.ok(keys.some(({ keys: of, action }) => of.includes('o') && action === 'ToggleIoTest'));
});

test('a drag there and back leaves the camera as it was', () => {
  const home = new Float64Array([0, 0, 10, 0, 0, 0, 0, 1, 0, 40, 0]);
  const eye = new engine.Eye(home);
  assert.deepEqual(eye.camera(), home);
  assert.equal(eye.lightMap(), undefined);
  eye.press(0, 0);
  eye.drag(0.5, 0.2);
  assert.notDeepEqual(eye.camera(), home);
  assert.equal(eye.lightMap().length, 12);
  eye.drag(0, 0);
  eye.release();
  eye.camera().forEach((x, i) => assert.ok(Math.abs(x - home[i]) < 1e-12));
  eye.home();
  assert.deepEqual(eye.camera(), home);
});
