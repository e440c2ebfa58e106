// The WebAssembly module: found, compiled once, and instantiated.

import initialize, * as engine from '../engine/superegg.js';

/** Where the module is: its address, its bytes, or the compiled module. */
export type EngineSource = string | URL | BufferSource | WebAssembly.Module;

let compiled: Promise<WebAssembly.Module> | undefined;
let started: Promise<typeof engine> | undefined;

/** Whether this runs in Node. */
export const inNode = typeof process !== 'undefined' && Boolean(process.versions?.node);

/** The compiled module, which workers share. The first call decides where it comes from. */
export function compiledModule(source?: EngineSource): Promise<WebAssembly.Module> {
  compiled ??= compile(source ?? new URL('../engine/superegg_bg.wasm', import.meta.url));
  return compiled;
}

async function compile(source: EngineSource): Promise<WebAssembly.Module> {
  if (source instanceof WebAssembly.Module) return source;
  if (!(typeof source === 'string' || source instanceof URL)) return WebAssembly.compile(source);
  const address = new URL(source, import.meta.url);
  if (inNode && address.protocol === 'file:') {
    // In a variable, so that bundlers for browsers do not look for it.
    const files = 'node:fs/promises';
    const { readFile } = (await import(/* @vite-ignore */ files)) as typeof import('node:fs/promises');
    return WebAssembly.compile(await readFile(address));
  }
  const response = await fetch(address);
  if (!response.ok) throw new Error(`the engine is not at ${address.href}: ${response.status}`);
  // A server without the type of WebAssembly needs the bytes.
  return response.headers.get('content-type')?.startsWith('application/wasm')
    ? WebAssembly.compileStreaming(response)
    : WebAssembly.compile(await response.arrayBuffer());
}

/** Starts the engine of this thread. Further calls return the same one. */
export function start(source?: EngineSource): Promise<typeof engine> {
  started ??= compiledModule(source).then(async (module) => {
    await initialize({ module_or_path: module });
    return engine;
  });
  return started;
}

export { engine };
