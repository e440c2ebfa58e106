// The engine of a notebook: one compiled module for all its widgets, from the kernel or from an address.

import { start } from 'superegg';
import type { Model } from './model';

/** A kernel that is busy for longer is taken for one that is gone. */
const PATIENCE_MS = 60_000;

/** Every widget has a copy of this script, so what they share is with the page. */
const SHARED = Symbol.for('superegg.modules');
type Shared = { [SHARED]?: Map<string, Promise<WebAssembly.Module>> };

/** Starts the engine of this widget. */
export async function startEngine(model: Model): Promise<void> {
  const shared = ((globalThis as Shared)[SHARED] ??= new Map<string, Promise<WebAssembly.Module>>());
  const address = model.get('module');
  let compiled = shared.get(address);
  if (!compiled) {
    compiled = (address ? fetched(address) : asked(model)).then(compile);
    shared.set(address, compiled);
    // The next widget tries again.
    compiled.catch(() => shared.delete(address));
  }
  await start(await compiled);
}

async function fetched(address: string): Promise<ReadableStream> {
  const response = await fetch(address);
  if (!response.ok || !response.body) throw new Error(`there is no module at ${address} (${response.status})`);
  return response.body;
}

/** The compressed module from the kernel. */
function asked(model: Model): Promise<ReadableStream> {
  return new Promise((resolve, reject) => {
    const late = setTimeout(() => {
      model.off('msg:custom', hear);
      reject(new Error('the kernel does not send the module: run the cell again'));
    }, PATIENCE_MS);
    function hear(content: { kind?: string }, buffers: DataView<ArrayBuffer>[]): void {
      const [module] = buffers;
      if (content.kind !== 'module' || !module) return;
      clearTimeout(late);
      model.off('msg:custom', hear);
      resolve(new Blob([module]).stream());
    }
    model.on('msg:custom', hear);
    model.send({ kind: 'module' });
  });
}

async function compile(packed: ReadableStream): Promise<WebAssembly.Module> {
  const module = new Response(packed.pipeThrough(new DecompressionStream('gzip')), { headers: { 'content-type': 'application/wasm' } });
  return WebAssembly.compileStreaming(module);
}
