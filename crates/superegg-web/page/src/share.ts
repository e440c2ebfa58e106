// Scenes in links: `#1.` and the compressed text in the letters of a URL. A link is data, and is checked as such.

/** A longer text is not put into a link, and none comes out of one. */
export const MOST_CHARACTERS = 200_000;
const MOST_ENCODED = 100_000;
const VERSION = '1.';

async function through(bytes: Uint8Array<ArrayBuffer>, stream: GenericTransformStream, most: number): Promise<Uint8Array> {
  const reader = new Blob([bytes]).stream().pipeThrough(stream as ReadableWritablePair<Uint8Array, BufferSource>).getReader();
  const parts: Uint8Array[] = [];
  let length = 0;
  for (let next = await reader.read(); !next.done; next = await reader.read()) {
    length += next.value.length;
    if (length > most) {
      void reader.cancel();
      throw new Error('the scene in the link is too long');
    }
    parts.push(next.value);
  }
  const all = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** The fragment for a text. */
export async function encode(text: string): Promise<string> {
  if (text.length > MOST_CHARACTERS) throw new Error('the scene is too long for a link; download it instead');
  const packed = await through(new TextEncoder().encode(text), new CompressionStream('deflate-raw'), Infinity);
  const letters = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(''));
  const encoded = letters.replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
  if (encoded.length > MOST_ENCODED) throw new Error('the scene is too long for a link; download it instead');
  return `#${VERSION}${encoded}`;
}

/** The text of a fragment; `undefined` if there is none. Throws if the link is damaged. */
export async function decode(fragment: string): Promise<string | undefined> {
  if (!fragment.startsWith('#') || fragment.length === 1) return undefined;
  const body = fragment.slice(1);
  const encoded = body.slice(VERSION.length);
  if (!body.startsWith(VERSION)) throw new Error('the link is not one of this page, or of a later one');
  if (encoded.length > MOST_ENCODED) throw new Error('the scene in the link is too long');
  if (!/^[A-Za-z0-9_-]+$/.test(encoded)) throw new Error('the link is damaged: it has letters that no link has');
  try {
    const letters = atob(encoded.replaceAll('-', '+').replaceAll('_', '/'));
    const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    // A character has at most four bytes.
    const bytes = await through(packed, new DecompressionStream('deflate-raw'), 4 * MOST_CHARACTERS);
    return new TextDecoder('utf-8', { fatal: true }).decode(bytes);
  } catch (error) {
    if (error instanceof Error && error.message.includes('too long')) throw error;
    throw new Error('the link is damaged: a part of it is missing or changed');
  }
}
