// Scenes from addresses.

/** A longer file is refused. */
const MOST_BYTES = 64 * 2 ** 20;

/** The file that a scene names as the picture of its surroundings. */
export function surroundingsOf(scene: Uint8Array): string | undefined {
  const head = new TextDecoder().decode(scene.subarray(0, 1 << 16));
  const found = /^\s*environment\s+(?:"([^"]+)"|(\S+))/im.exec(head);
  return found?.[1] ?? found?.[2];
}

/** The bytes at an address, unless they are too many. */
export async function fetchBytes(address: URL): Promise<Uint8Array> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`there is nothing at ${address.href} (${response.status})`);
  const isLong = Number(response.headers.get('content-length') ?? 0) > MOST_BYTES;
  const bytes = isLong ? undefined : new Uint8Array(await response.arrayBuffer());
  if (!bytes || bytes.length > MOST_BYTES) throw new Error(`the file has more than ${MOST_BYTES} bytes`);
  return bytes;
}
