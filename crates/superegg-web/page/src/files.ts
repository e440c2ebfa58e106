// Files and links: what is opened, dropped, downloaded and sent.

import { fetchBytes, surroundingsOf } from 'superegg/fetch';
import { canvas, complain, page, say, view } from './app';
import { byId, download } from './dom';
import { EXAMPLES } from './examples';
import { decode, encode } from './share';
import { editor, readText, showExponents, showText } from './text';

/** A larger file is not read. */
const MOST_BYTES = 512 * 2 ** 20;
/** A file whose scene has a longer text stays a file. */
const MOST_TEXT = 150_000;
/** The tolerance of meshes, as a part of each instance's size. */
const TOLERANCE = 1e-3;

const sceneText = async () => (page.shown.kind === 'text' ? editor.text : view.pool.ask({ about: 'text' }));

/** Downloads the scene as a file with this ending. */
export async function save(ending: string): Promise<void> {
  const { shown } = page;
  const stem = shown.kind === 'file' ? shown.name.replace(/\.[^.]*$/, '') : (view.info?.summary.root ?? 'scene');
  const name = `${stem}.${ending}`;
  try {
    if (ending === 'scn') {
      download(name, new Blob([await sceneText()], { type: 'text/plain' }));
    } else if (ending === 'png') {
      const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
      if (blob) download(name, blob);
    } else {
      const { bytes, losses } = await view.pool.ask({ about: 'export', file: name, tolerance: TOLERANCE });
      download(name, new Blob([bytes]));
      if (losses.length > 0) say(losses.join('; '));
    }
  } catch (error) {
    complain(error);
  }
}

/** Opens a file: its text becomes the text of the page if it is short enough. */
export async function openFile(file: File): Promise<void> {
  if (file.size > MOST_BYTES) {
    throw new Error(`'${file.name}' has ${Math.round(file.size / 2 ** 20)} MiB; at most ${MOST_BYTES / 2 ** 20} can be read here`);
  }
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (/\.(hdr|exr)$/i.test(file.name)) {
    page.surroundings = bytes;
    await readText();
    say(`'${file.name}' lights the scene`);
    return;
  }
  if (/\.scn$/i.test(file.name) && bytes.length <= MOST_TEXT) {
    showText(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
    return;
  }
  const before = page.shown;
  const source = { name: file.name, bytes };
  page.shown = { kind: 'file', name: file.name, source };
  const info = await view.show(source).catch((error: unknown) => {
    page.shown = before;
    void readText();
    throw error;
  });
  if (!info) return;
  const text = await view.pool.ask({ about: 'text' });
  const notes = [file.name, ...info.notes];
  if (text.length <= MOST_TEXT) showText(`# ${notes.join(': ').replaceAll('\n', ' ')}\n${text}`);
  else showNotes(notes);
}

/** Shows what is known of a file in place of its text. */
function showNotes(notes: string[]): void {
  byId('editor').hidden = true;
  const panel = byId('file');
  panel.hidden = false;
  const back = Object.assign(document.createElement('button'), { type: 'button', textContent: 'Back to the text' });
  back.addEventListener('click', () => showText(editor.text));
  panel.replaceChildren(...notes.map((note) => Object.assign(document.createElement('p'), { textContent: note })), back);
  showExponents();
}

/** Puts the scene into the address, and the address into the clipboard. */
export async function share(): Promise<void> {
  try {
    history.replaceState(null, '', `${location.pathname}${await encode(await sceneText())}`);
    await navigator.clipboard.writeText(location.href).then(
      () => say('the link is copied'),
      () => say('the link is in the address bar'),
    );
  } catch (error) {
    complain(error);
  }
}

/** Opens the scene of the address. Returns whether it has one. */
export async function openAddress(): Promise<boolean> {
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
  return name !== null && openExample(name);
}

/** Opens an example or a scene of the gallery, with the picture of its surroundings. Returns whether there is one. */
export async function openExample(name: string): Promise<boolean> {
  const example = EXAMPLES.find((one) => one.name === name);
  if (example) {
    showText(example.text);
    return true;
  }
  if (!/^\w+$/.test(name)) return false;
  try {
    const address = new URL(`./scenes/${name}.scn`, document.baseURI);
    const bytes = await fetchBytes(address);
    const named = surroundingsOf(bytes);
    page.surroundings = named ? await fetchBytes(new URL(named, address)) : undefined;
    showText(new TextDecoder().decode(bytes));
    return true;
  } catch (error) {
    complain(error);
    return false;
  }
}

/** Lets files be dropped anywhere on the page. */
export function acceptDrops(): void {
  const sheet = byId('drop');
  addEventListener('dragover', (event) => {
    event.preventDefault();
    sheet.hidden = false;
  });
  addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) sheet.hidden = true;
  });
  addEventListener('drop', (event) => {
    event.preventDefault();
    sheet.hidden = true;
    const file = event.dataTransfer?.files[0];
    if (file) openFile(file).catch(complain);
  });
}
