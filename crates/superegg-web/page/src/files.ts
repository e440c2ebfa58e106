// Files and links: what is opened, dropped, downloaded and sent.

import { fetchScene } from 'superegg/fetch';
import { canvas, complain, page, say, view } from './app';
import { byId, download } from './dom';
import { EXAMPLES } from './examples';
import { decode, encode } from './share';
import { editor, readText, showExponents, showScene, showText } from './text';

/** A larger file is not read. */
const MOST_BYTES = 512 * 2 ** 20;
/** The pictures that scenes name. */
const PICTURE = /\.(hdr|exr|png|jpe?g)$/i;
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
  if (PICTURE.test(file.name)) {
    await keepPicture(file.name, bytes);
    return;
  }
  if (/\.scn$/i.test(file.name) && bytes.length <= MOST_TEXT) {
    showText(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
    return;
  }
  const before = page.shown;
  page.shown = { kind: 'file', name: file.name, source: { name: file.name, bytes } };
  page.frame = undefined;
  const info = await showScene(false).catch((error: unknown) => {
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

/** Gives scenes a picture that they may name. */
async function keepPicture(name: string, bytes: Uint8Array): Promise<void> {
  page.files = { ...page.files, [name]: bytes };
  if (page.shown.kind === 'text') await readText();
  else await showScene(true);
  const bare = (path: string) => path.split(/[/\\]/).pop();
  const named = view.info?.summary.files.find((file) => bare(file.name) === name);
  const line = /\.hdr$/i.test(name) ? `environment ${name}` : `setTexture color ${name}`;
  // The fault of a picture that cannot be read is shown already.
  if (!named) say(`'${name}' is kept; the line '${line}' shows it`);
  else if (!named.fault) say(`'${name}' is a picture of this scene`);
}

/** Opens files: pictures first, so that scenes find those that they name. */
export async function openFiles(files: readonly File[]): Promise<void> {
  const rank = (file: File) => (PICTURE.test(file.name) ? 0 : 1);
  for (const file of [...files].sort((a, b) => rank(a) - rank(b))) await openFile(file);
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

/** Opens an example or a scene of the gallery, with the pictures that it names. Returns whether there is one. */
export async function openExample(name: string): Promise<boolean> {
  const example = EXAMPLES.find((one) => one.name === name);
  if (example) {
    showText(example.text);
    return true;
  }
  if (!/^(features\/)?\w+$/.test(name)) {
    say(`there is no scene '${name.slice(0, 40)}' here`);
    return false;
  }
  try {
    const source = await fetchScene(new URL(`./scenes/${name}.scn`, document.baseURI));
    page.files = { ...page.files, ...source.files };
    if ('bytes' in source) showText(new TextDecoder().decode(source.bytes));
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
    openFiles([...(event.dataTransfer?.files ?? [])]).catch(complain);
  });
}
