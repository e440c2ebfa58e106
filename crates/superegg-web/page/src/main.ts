// The page: a text on the left, its picture on the right.

import './style.css';
import { redo, undo } from '@codemirror/commands';
import type { Output } from 'superegg';
import type { Pass } from 'superegg/view';
import { canvas, complain, say, view } from './app';
import { byId, short } from './dom';
import { EXAMPLES, GALLERY, WELCOME } from './examples';
import { acceptDrops, openAddress, openExample, openFiles, save, share } from './files';
import { frameAction } from './frames';
import { Keys } from './keys';
import { keyTable, start } from './language';
import { keepOffline } from './offline';
import { splitter } from './splitter';
import { draw, toggle } from './drawings';
import { editor, readText, showText } from './text';
import { themeButton } from './theme';

/** Carries out an action of the table of keys. Returns whether it is known here. */
function act(action: string): boolean {
  switch (action) {
    case 'Refresh': void readText(); return true;
    case 'WriteCamera': writeCamera(); return true;
    case 'Screenshot': void save('png'); return true;
    case 'Save': void save('scn'); return true;
    case 'Open': byId('chooser').click(); return true;
    case 'ToggleHelp': byId<HTMLDialogElement>('keys').showModal(); return true;
    case 'Undo': return undo(editor.view);
    case 'Redo': return redo(editor.view);
    case 'ToggleLightsTurn':
      view.lightsTurning = !view.lightsTurning;
      say(view.lightsTurning ? 'the lights turn with the scene' : 'the lights stay with the eye');
      return true;
    case 'KeyboardBack': focusText(); return true;
    case 'ToggleShading': nextOutput(); return true;
    case 'ToggleTrace': stopOrGoOn(); return true;
    default: return toggle(action) || frameAction(action) || view.act(action);
  }
}

/** Gives the keyboard to the text, or to what stands in its place. */
function focusText(): void {
  if (byId('editor').hidden) byId('file').querySelector('button')?.focus();
  else editor.view.focus();
}

/** Shows the next quantity of the list. */
function nextOutput(): void {
  const list = byId<HTMLSelectElement>('output');
  list.selectedIndex = (list.selectedIndex + 1) % list.options.length;
  view.output = list.value as Output;
  say(`the picture shows ${list.selectedOptions[0]?.textContent?.toLowerCase() ?? list.value}`);
}

/** Stops the picture in the making, or goes on with one that was stopped. */
function stopOrGoOn(): void {
  if (view.isPaused) view.refine();
  else if (!view.pause()) say('the picture is finished');
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

/** The choice of files in the list of examples. */
const OPEN = '*';
let hasPicture = false;

function showPass({ coarseness, samples, milliseconds, isLast, isPaused }: Pass): void {
  // For bench.mjs.
  if (!hasPicture) performance.mark('first picture');
  hasPicture = true;
  const seconds = milliseconds < 1000 ? `${Math.round(milliseconds)} ms` : `${(milliseconds / 1000).toFixed(1)} s`;
  const grain = coarseness > 1 ? `1/${coarseness}` : `${samples} ${samples === 1 ? 'sample' : 'samples'}`;
  byId('progress').textContent = isPaused ? 'paused' : isLast ? `${grain}, ${seconds}` : `${grain} ...`;
  byId('refine').hidden = !isPaused;
  document.documentElement.dataset.pass = isLast ? 'last' : coarseness > 1 ? 'coarse' : 'full';
}

view.on('begun', () => {
  byId('refine').hidden = true;
  document.documentElement.dataset.pass = 'begun';
});
view.on('pass', showPass);
view.on('error', complain);

document.querySelectorAll<HTMLElement>('[data-action]').forEach((button) => {
  button.addEventListener('click', () => act(button.dataset.action ?? ''));
});
byId<HTMLSelectElement>('output').addEventListener('change', (event) => {
  view.output = (event.target as HTMLSelectElement).value as Output;
});
byId('refine').addEventListener('click', () => {
  view.refine();
});
byId('help').addEventListener('click', () => act('ToggleHelp'));
byId('open').addEventListener('click', () => act('Open'));
byId('share').addEventListener('click', () => void share());

const examples = byId<HTMLSelectElement>('examples');
for (const { title, name } of [...EXAMPLES, ...GALLERY]) examples.append(new Option(title, name));
// The button to open files is hidden where the window is narrow.
examples.append(new Option('Open files ...', OPEN));
examples.addEventListener('change', () => {
  const { value } = examples;
  examples.value = '';
  if (value === OPEN) act('Open');
  else if (value) void openExample(value);
});
const downloads = byId<HTMLSelectElement>('download');
downloads.addEventListener('change', () => {
  void save(downloads.value);
  downloads.value = '';
});
byId<HTMLInputElement>('chooser').addEventListener('change', (event) => {
  const chooser = event.target as HTMLInputElement;
  const files = [...(chooser.files ?? [])];
  chooser.value = '';
  openFiles(files).catch(complain);
});
acceptDrops();
addEventListener('hashchange', () => void openAddress());

themeButton(byId('theme'), draw);
const main = document.querySelector('main');
if (main) splitter(byId('splitter'), main);
void openAddress().then((isOpened) => {
  if (!isOpened) showText(WELCOME);
});
void start().then(() => {
  const keys = new Keys(keyTable());
  const table = document.querySelector<HTMLTableElement>('#keys table');
  if (table) keys.describe(table);
  canvas.addEventListener('keydown', (event) => {
    const action = keys.action(event);
    if (action && act(action)) event.preventDefault();
  });
}, complain);
// The engine and the workers come first.
addEventListener('load', () => setTimeout(keepOffline, 3000));
