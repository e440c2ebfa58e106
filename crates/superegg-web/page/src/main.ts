// The page: a text on the left, its picture on the right.

import './style.css';
import type { FirstHit, Mesh, Output, SceneInfo, SceneSource, TestGrid } from 'superegg';
import { SceneView, type Pass } from 'superegg/view';
import { byId, download, message, short } from './dom';
import { Editor } from './editor';
import { EXAMPLES, WELCOME } from './examples';
import { Keys } from './keys';
import { Document, exponentLine, keyTable, start, type Exponents } from './language';
import { keepOffline } from './offline';
import { drawOverlay, type CastRay } from './overlay';
import { decode, encode } from './share';
import { splitter } from './splitter';
import { themeButton } from './theme';

/** A text is read this long after the last key. */
const PAUSE_MS = 25;
/** Longer texts are read later and have no sliders. */
const LONG = 60_000;
const PAUSE_LONG_MS = 250;
/** A larger file is not read. */
const MOST_BYTES = 512 * 2 ** 20;
/** A file whose scene has a longer text stays a file. */
const MOST_TEXT = 150_000;
const MESH_TOLERANCE = 1e-3;
const WIRE_TOLERANCE = 1e-2;

type Shown = { kind: 'text' } | { kind: 'file'; name: string; source: SceneSource };

const canvas = byId<HTMLCanvasElement>('picture');
const overlay = byId<HTMLCanvasElement>('overlay');
const view = new SceneView(canvas);

const state = {
  shown: { kind: 'text' } as Shown,
  axes: false,
  ioTest: false,
  outside: true,
  intersect: false,
  wire: false,
  normals: false,
  grid: undefined as TestGrid | undefined,
  mesh: undefined as Mesh | undefined,
  cast: undefined as CastRay | undefined,
  surroundings: undefined as Uint8Array | undefined,
  exponents: undefined as Exponents | undefined,
  /** The primitive that was clicked last. */
  clicked: undefined as string | undefined,
  document: undefined as Document | undefined,
};

const editor = new Editor(byId('editor'), '', {
  changed: (text) => {
    state.clicked = undefined;
    clearTimeout(pause);
    pause = setTimeout(() => void readText(), text.length > LONG ? PAUSE_LONG_MS : PAUSE_MS);
  },
  cursor: () => showExponents(),
});
let pause: ReturnType<typeof setTimeout> | undefined;

// ---- Messages

let forgetting: ReturnType<typeof setTimeout> | undefined;

function say(text: string): void {
  byId('status').textContent = text;
  clearTimeout(forgetting);
  forgetting = setTimeout(() => {
    byId('status').textContent = '';
  }, 8000);
}

const complain = (error: unknown) => say(message(error));

// ---- From text to picture

async function readText(): Promise<void> {
  if (state.shown.kind !== 'text') return;
  const { text } = editor;
  await start();
  state.document?.free();
  state.document = new Document(text);
  editor.setDocument(state.document, state.document.findings);
  showProblems();
  showExponents();
  const source = state.surroundings ? { text, surroundings: state.surroundings } : text;
  await show(source, true);
}

async function show(source: SceneSource, keepView: boolean): Promise<void> {
  try {
    await view.show(source, { keepView });
  } catch (error) {
    complain(error);
  }
}

view.on('loaded', (info) => {
  state.grid = state.mesh = undefined;
  state.cast = undefined;
  byId('hit').hidden = true;
  const { instances, surroundings, has_surroundings } = info.summary;
  byId('summary').textContent = `${instances} ${instances === '1' ? 'instance' : 'instances'}`;
  canvas.setAttribute('aria-label', `The ray traced picture of ${info.summary.root ?? 'nothing'}: ${instances} instances. Arrow keys turn it, w and s zoom, question mark lists all keys.`);
  if (surroundings && !has_surroundings) say(`drop '${surroundings}' here: it is the picture that lights this scene`);
  else if (info.summary.root === null && editor.text.trim() !== '') say('nothing is selected, so nothing is shown');
  if (info.notes.length > 0) say(info.notes.join('; '));
  void refreshTests();
});
view.on('begun', () => {
  document.documentElement.dataset.pass = 'begun';
});
view.on('error', complain);
view.on('camera', draw);
view.on('click', ({ x, y }) => void pick(x, y));
view.on('pass', showPass);

function showPass({ coarseness, samples, milliseconds, isLast, isPaused }: Pass): void {
  const seconds = milliseconds < 1000 ? `${Math.round(milliseconds)} ms` : `${(milliseconds / 1000).toFixed(1)} s`;
  const grain = coarseness > 1 ? `1/${coarseness}` : `${samples} ${samples === 1 ? 'sample' : 'samples'}`;
  byId('progress').textContent = isPaused ? 'paused' : isLast ? `${grain}, ${seconds}` : `${grain} ...`;
  byId('refine').hidden = !isPaused;
  document.documentElement.dataset.pass = isLast ? 'last' : coarseness > 1 ? 'coarse' : 'full';
}

// ---- Errors

function showProblems(): void {
  const findings = state.document?.findings ?? [];
  const errors = findings.filter((found) => found.severity === 'error').length;
  const warnings = findings.length - errors;
  const button = byId('problems');
  const count = (n: number, word: string) => (n === 0 ? '' : `${n} ${word}${n === 1 ? '' : 's'}`);
  button.textContent = [count(errors, 'error'), count(warnings, 'warning')].filter(Boolean).join(', ') || 'no errors';
  button.className = errors > 0 ? 'error' : warnings > 0 ? 'warning' : '';
}

byId('problems').addEventListener('click', () => editor.goToProblem());

// ---- Sliders

const sliders = { e: byId<HTMLInputElement>('e'), n: byId<HTMLInputElement>('n') };

function showExponents(): void {
  const { document: text } = state;
  const isShort = editor.text.length <= LONG && state.shown.kind === 'text';
  const found = text && isShort ? (text.exponents(undefined, editor.line) ?? (state.clicked ? text.exponents(state.clicked, 0) : undefined)) : undefined;
  state.exponents = found;
  const field = byId<HTMLFieldSetElement>('exponents');
  field.hidden = !found;
  if (!found) return;
  byId('exponents').querySelector('legend')!.textContent = `Exponents of ${found.name}`;
  for (const key of ['e', 'n'] as const) {
    const slider = sliders[key];
    slider.max = String(Math.max(3, Math.ceil(found[key])));
    if (globalThis.document.activeElement !== slider) slider.value = String(found[key]);
    const output = slider.nextElementSibling as HTMLOutputElement;
    output.value = short(found[key], 3);
    slider.setAttribute('aria-valuetext', output.value);
  }
}

for (const key of ['e', 'n'] as const) {
  sliders[key].addEventListener('input', () => {
    const found = state.exponents;
    if (!found) return;
    const next = { e: found.e, n: found.n, [key]: Number(sliders[key].value) };
    editor.edit(found.line, found.from, found.to, exponentLine(found.word, next.e, next.n), found.is_new);
    // The next step of the slider must find its line where it now is.
    clearTimeout(pause);
    void readText();
  });
}

// ---- Tests and drawings over the picture

function size(info: SceneInfo): number {
  const b = info.bounds ?? [-1, -1, -1, 1, 1, 1];
  const largest = Math.max(...[0, 1, 2].map((i) => (b[i + 3] ?? 1) - (b[i] ?? -1)));
  // A wide floor or wall would make everything else small.
  const camera = view.camera;
  const distance = Math.hypot(...[0, 1, 2].map((i) => (camera[i] ?? 0) - (camera[i + 3] ?? 0)));
  return Math.min(largest, distance);
}

function draw(): void {
  const { info } = view;
  if (!info) return;
  drawOverlay(overlay, {
    camera: view.camera,
    axes: state.axes,
    lights: info.lights,
    size: size(info),
    grid: state.ioTest ? state.grid : undefined,
    showOutside: state.outside,
    cast: state.intersect ? state.cast : undefined,
    mesh: state.wire ? state.mesh : undefined,
    showNormals: state.normals,
  });
}

/** Asks for what the drawings need and do not have. */
async function refreshTests(): Promise<void> {
  const { info } = view;
  try {
    if (state.ioTest && !state.grid) state.grid = await view.pool.ask({ about: 'grid', camera: view.camera });
    if (state.wire && !state.mesh) state.mesh = await view.pool.ask({ about: 'mesh', tolerance: WIRE_TOLERANCE });
    if (state.intersect && !state.cast) await pick(canvas.width / 2, canvas.height / 2);
  } catch (error) {
    if (info === view.info) complain(error);
  }
  draw();
}

async function pick(x: number, y: number): Promise<void> {
  const { width, height } = canvas;
  const camera = view.camera;
  const hit = await view.pool.ask({ about: 'pick', camera, width, height, x, y }).catch(() => undefined);
  const position = [camera[0] ?? 0, camera[1] ?? 0, camera[2] ?? 0] as CastRay['origin'];
  const end = hit ? hit.point : ([camera[3] ?? 0, camera[4] ?? 0, camera[5] ?? 0] as CastRay['origin']);
  state.cast = { origin: position, hit, end };
  showHit(hit);
  state.clicked = hit?.primitive;
  showExponents();
  draw();
}

function showHit(hit: FirstHit | undefined): void {
  const list = byId('hit');
  list.hidden = false;
  list.replaceChildren();
  const add = (term: string, value: string) => {
    const dt = document.createElement('dt');
    const dd = document.createElement('dd');
    dt.textContent = term;
    dd.textContent = value;
    list.append(dt, dd);
  };
  if (!hit) {
    add('ray', 'hits nothing');
    say('the ray hits nothing');
    return;
  }
  const vector = (v: readonly number[]) => v.map((x) => short(x, 5)).join(' ');
  add('t', short(hit.t, 8));
  add('point', vector(hit.point));
  add('normal', vector(hit.normal));
  add('path', hit.path);
  add('steps', hit.steps === null ? 'isolated by bounds' : `${hit.steps} of Newton`);
  say(`hit ${hit.path} at t ${short(hit.t, 6)}`);
}

// ---- Actions

function press(action: string, isOn: boolean): void {
  document.querySelector(`[data-action="${action}"]`)?.setAttribute('aria-pressed', String(isOn));
}

function act(action: string): boolean {
  switch (action) {
    case 'ToggleIoTest':
      state.ioTest = !state.ioTest;
      press(action, state.ioTest);
      void refreshTests();
      return true;
    case 'ToggleIntersectTest':
      state.intersect = !state.intersect;
      press(action, state.intersect);
      void refreshTests();
      return true;
    case 'ToggleWireframe':
      state.wire = !state.wire;
      press(action, state.wire);
      byId('view').classList.toggle('wire', state.wire);
      void refreshTests();
      return true;
    case 'ToggleNormals': state.normals = !state.normals; draw(); return true;
    case 'ToggleOutside': state.outside = !state.outside; draw(); return true;
    case 'ToggleAxes':
      state.axes = !state.axes;
      press(action, state.axes);
      draw();
      return true;
    case 'Refresh': void readText(); return true;
    case 'WriteCamera': writeCamera(); return true;
    case 'Screenshot': void save('png'); return true;
    case 'Save': void save('scn'); return true;
    case 'Open': byId('chooser').click(); return true;
    case 'ToggleHelp': byId<HTMLDialogElement>('keys').showModal(); return true;
    case 'Undo': void import('@codemirror/commands').then(({ undo }) => undo(editor.view)); return true;
    case 'Redo': void import('@codemirror/commands').then(({ redo }) => redo(editor.view)); return true;
    case 'ToggleLightsTurn':
      view.lightsTurning = !view.lightsTurning;
      say(view.lightsTurning ? 'the lights turn with the scene' : 'the lights stay with the eye');
      return true;
    default: return view.act(action);
  }
}

/** Writes the view into the text as the scene's camera. */
function writeCamera(): void {
  const numbers = Array.from(view.camera, (x) => short(x, 7));
  const ortho = Number(numbers[10]) > 0 ? [`orthographic ${numbers[10]}`] : [];
  const lines = [`camera ${numbers.slice(0, 3).join(' ')}  ${numbers.slice(3, 6).join(' ')}  ${numbers[9]}`, `cameraUp ${numbers.slice(6, 9).join(' ')}`, ...ortho];
  const kept = editor.text.split('\n').filter((line) => !/^\s*(camera|cameraUp|orthographic)\s/i.test(line));
  const first = kept.findIndex((line) => !/^\s*(#|$)/.test(line));
  kept.splice(Math.max(first, 0), 0, ...lines);
  editor.text = kept.join('\n');
  say('the view is the camera of the scene now');
}

document.querySelectorAll<HTMLElement>('[data-action]').forEach((button) => {
  button.addEventListener('click', () => act(button.dataset.action ?? ''));
});
byId<HTMLSelectElement>('output').addEventListener('change', (event) => {
  view.output = (event.target as HTMLSelectElement).value as Output;
});
byId('refine').addEventListener('click', () => {
  byId('refine').hidden = true;
  view.refine();
});
byId('help').addEventListener('click', () => act('ToggleHelp'));

// ---- Files and links

const stem = () => (state.shown.kind === 'file' ? state.shown.name.replace(/\.[^.]*$/, '') : (view.info?.summary.root ?? 'scene'));

async function save(ending: string): Promise<void> {
  const name = `${stem()}.${ending}`;
  try {
    if (ending === 'scn') {
      const text = state.shown.kind === 'text' ? editor.text : await view.pool.ask({ about: 'text' });
      download(name, new Blob([text], { type: 'text/plain' }));
    } else if (ending === 'png') {
      const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
      if (blob) download(name, blob);
    } else {
      const { bytes, losses } = await view.pool.ask({ about: 'export', file: name, tolerance: MESH_TOLERANCE });
      download(name, new Blob([bytes]));
      if (losses.length > 0) say(losses.join('; '));
    }
  } catch (error) {
    complain(error);
  }
}

function showText(text: string): void {
  state.shown = { kind: 'text' };
  byId('editor').hidden = false;
  byId('file').hidden = true;
  editor.text = text;
  clearTimeout(pause);
  void readText();
}

/** Opens a file: its text becomes the text of the page if it is short enough. */
async function openFile(file: File): Promise<void> {
  if (file.size > MOST_BYTES) throw new Error(`'${file.name}' has ${Math.round(file.size / 2 ** 20)} MiB; at most ${MOST_BYTES / 2 ** 20} can be read here`);
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (/\.(hdr|exr)$/i.test(file.name)) {
    state.surroundings = bytes;
    await readText();
    say(`'${file.name}' lights the scene`);
    return;
  }
  if (/\.scn$/i.test(file.name) && bytes.length <= MOST_TEXT) {
    showText(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
    return;
  }
  const before = state.shown;
  const source = { name: file.name, bytes };
  state.shown = { kind: 'file', name: file.name, source };
  const info = await view.show(source).catch((error: unknown) => {
    state.shown = before;
    void readText();
    throw error;
  });
  if (!info) return;
  const text = await view.pool.ask({ about: 'text' });
  if (text.length <= MOST_TEXT) {
    showText(`# ${[file.name, ...info.notes].join(': ').replaceAll('\n', ' ')}\n${text}`);
    return;
  }
  byId('editor').hidden = true;
  const panel = byId('file');
  panel.hidden = false;
  panel.replaceChildren(...[file.name, ...info.notes].map((note) => Object.assign(document.createElement('p'), { textContent: note })));
  const back = Object.assign(document.createElement('button'), { type: 'button', textContent: 'Back to the text' });
  back.addEventListener('click', () => showText(editor.text));
  panel.append(back);
  showExponents();
}

async function share(): Promise<void> {
  try {
    const text = state.shown.kind === 'text' ? editor.text : await view.pool.ask({ about: 'text' });
    history.replaceState(null, '', `${location.pathname}${await encode(text)}`);
    await navigator.clipboard.writeText(location.href).then(
      () => say('the link is copied'),
      () => say('the link is in the address bar'),
    );
  } catch (error) {
    complain(error);
  }
}

async function openAddress(): Promise<boolean> {
  try {
    const text = await decode(location.hash);
    if (text !== undefined) {
      showText(text);
      return true;
    }
  } catch (error) {
    complain(error);
    return false;
  }
  const name = new URLSearchParams(location.search).get('scene');
  const example = EXAMPLES.find((one) => one.name === name);
  if (example) showText(example.text);
  return example !== undefined;
}

const examples = byId<HTMLSelectElement>('examples');
for (const { title, name } of EXAMPLES) examples.append(new Option(title, name));
examples.addEventListener('change', () => {
  const example = EXAMPLES.find(({ name }) => name === examples.value);
  examples.value = '';
  if (example) showText(example.text);
});
const downloads = byId<HTMLSelectElement>('download');
downloads.addEventListener('change', () => {
  void save(downloads.value);
  downloads.value = '';
});
byId('share').addEventListener('click', () => void share());
byId('open').addEventListener('click', () => byId('chooser').click());
byId<HTMLInputElement>('chooser').addEventListener('change', (event) => {
  const chooser = event.target as HTMLInputElement;
  const file = chooser.files?.[0];
  chooser.value = '';
  if (file) openFile(file).catch(complain);
});
addEventListener('hashchange', () => void openAddress());
addEventListener('dragover', (event) => {
  event.preventDefault();
  byId('drop').hidden = false;
});
addEventListener('dragleave', (event) => {
  if (event.relatedTarget === null) byId('drop').hidden = true;
});
addEventListener('drop', (event) => {
  event.preventDefault();
  byId('drop').hidden = true;
  const file = event.dataTransfer?.files[0];
  if (file) openFile(file).catch(complain);
});

// ---- Start

themeButton(byId('theme'), draw);
splitter(byId('splitter'), document.querySelector('main')!);
new ResizeObserver(draw).observe(overlay);
void openAddress().then((isOpened) => {
  if (!isOpened) showText(WELCOME);
});
// The engine and the workers come first.
addEventListener('load', () => setTimeout(keepOffline, 3000));
void start().then(() => {
  const keys = new Keys(keyTable());
  keys.describe(document.querySelector<HTMLTableElement>('#keys table')!);
  canvas.addEventListener('keydown', (event) => {
    const action = keys.action(event);
    if (action && act(action)) event.preventDefault();
  });
}, complain);
