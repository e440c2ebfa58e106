// Scenes from addresses.

import { engine, start } from './engine.js';
import type { SceneSource } from './types.js';

/** A longer file is refused. */
const MOST_BYTES = 64 * 2 ** 20;
/** The most pictures that are fetched for a scene. */
const MOST_FILES = 16;

/** The bytes at an address, unless they are too many. */
export async function fetchBytes(address: URL): Promise<Uint8Array> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`there is nothing at ${address.href} (${response.status})`);
  const isLong = Number(response.headers.get('content-length') ?? 0) > MOST_BYTES;
  const bytes = isLong ? undefined : new Uint8Array(await response.arrayBuffer());
  if (!bytes || bytes.length > MOST_BYTES) throw new Error(`the file has more than ${MOST_BYTES} bytes`);
  return bytes;
}

/** A scene at an address, with the pictures that it names: they are beside it, on the same server. */
export async function fetchScene(address: URL): Promise<Exclude<SceneSource, string>> {
  const [bytes] = await Promise.all([fetchBytes(address), start()]);
  const name = decodeURIComponent(address.pathname.split('/').pop() ?? 'scene');
  const named = engine.filesNamed(name, bytes).slice(0, MOST_FILES);
  const found = await Promise.all(named.map(async (file) => {
    const beside = new URL(file, address);
    if (beside.origin !== address.origin) return [];
    // A scene without one of its pictures is shown all the same.
    return fetchBytes(beside).then((content) => [[file, content] as const], () => []);
  }));
  return { name, bytes, files: Object.fromEntries(found.flat()) };
}
