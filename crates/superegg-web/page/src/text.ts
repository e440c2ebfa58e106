// From the text to the picture: the editor, its errors, and the sliders of exponents.

import type { SceneInfo } from 'superegg';
import { canvas, complain, page, say, view } from './app';
import { byId } from './dom';
import { Editor } from './editor';
import { Document, start } from './language';
import { Sliders } from './sliders';

/** A text is read this long after the last key. */
const PAUSE_MS = 25;
/** Longer texts are read later and have no sliders. */
const LONG = 60_000;
const PAUSE_LONG_MS = 250;

let pause: ReturnType<typeof setTimeout> | undefined;
let running: Document | undefined;
/** The primitive that was clicked last. */
let clicked: string | undefined;

export const editor = new Editor(byId('editor'), '', {
  changed: (text) => {
    clicked = undefined;
    clearTimeout(pause);
    pause = setTimeout(() => void readText(), text.length > LONG ? PAUSE_LONG_MS : PAUSE_MS);
  },
  cursor: () => showExponents(),
});

const sliders = new Sliders(({ line, from, to, is_new }, text) => {
  editor.edit(line, from, to, text, is_new);
  // The next step of the slider must find its line where it now is.
  void readText();
});

/** Runs the text, and shows its scene. */
export async function readText(): Promise<void> {
  clearTimeout(pause);
  if (page.shown.kind !== 'text') return;
  const { text } = editor;
  await start();
  running?.free();
  running = new Document(text);
  editor.setDocument(running, running.findings);
  showProblems();
  showExponents();
  await showScene(true).catch(complain);
}

/** Shows the scene of the page at the frame of the page. */
export async function showScene(keepView: boolean | 'turned'): Promise<SceneInfo | undefined> {
  const { shown, files, frame } = page;
  const extras = frame === undefined ? { files } : { files, frame };
  const source = shown.kind === 'file' ? { ...shown.source, ...extras } : { text: editor.text, ...extras };
  return view.show(source, { keepView });
}

/** Puts a text into the editor and shows its scene. */
export function showText(text: string): void {
  page.shown = { kind: 'text' };
  page.frame = undefined;
  byId('editor').hidden = false;
  byId('file').hidden = true;
  editor.text = text;
  void readText();
}

/** Shows the sliders of a primitive that was clicked. */
export function select(primitive: string | undefined): void {
  clicked = primitive;
  showExponents();
}

export function showExponents(): void {
  if (!running || editor.text.length > LONG || page.shown.kind !== 'text') {
    sliders.show(undefined);
    return;
  }
  const atCursor = running.exponents(undefined, editor.line);
  sliders.show(atCursor ?? (clicked ? running.exponents(clicked, 0) : undefined));
}

function showProblems(): void {
  const findings = running?.findings ?? [];
  const errors = findings.filter((found) => found.severity === 'error').length;
  const warnings = findings.length - errors;
  const count = (n: number, word: string) => (n === 0 ? '' : `${n} ${word}${n === 1 ? '' : 's'}`);
  const button = byId('problems');
  button.textContent = [count(errors, 'error'), count(warnings, 'warning')].filter(Boolean).join(', ') || 'no errors';
  button.className = errors > 0 ? 'error' : warnings > 0 ? 'warning' : '';
}

view.on('loaded', ({ summary, notes }) => {
  const { instances, files, root } = summary;
  const counted = `${instances} ${instances === '1' ? 'instance' : 'instances'}`;
  byId('summary').textContent = counted;
  canvas.setAttribute(
    'aria-label',
    `The ray traced picture of ${root ?? 'nothing'}: ${counted}. Arrow keys turn it, w and s zoom, question mark lists all keys.`,
  );
  const missing = files.filter(({ given }) => !given).map(({ name }) => `'${name}'`);
  const faults = files.flatMap(({ fault }) => fault ?? []);
  if (faults.length > 0) say(faults.join('; '));
  else if (missing.length > 0) say(`drop ${missing.join(', ')} here: the scene names ${missing.length > 1 ? 'these pictures' : 'this picture'}`);
  else if (root === null && editor.text.trim() !== '') say('nothing is selected, so nothing is shown');
  if (notes.length > 0) say(notes.join('; '));
});
byId('problems').addEventListener('click', () => editor.goToProblem());
