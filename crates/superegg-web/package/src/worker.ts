// A worker: one engine with its own copy of the scene. Between slices of a picture it looks for messages, so that a new
// picture or a question never waits longer than a slice.

import { engine, inNode, start } from './engine.js';
import type { Question, FromWorker, ToWorker } from './protocol.js';
import { Scene } from './scene.js';

interface Port {
  post(message: FromWorker, transfer?: ArrayBuffer[]): void;
  listen(hear: (message: ToWorker) => void): void;
}

async function openPort(): Promise<Port> {
  if (inNode) {
    const threads = 'node:worker_threads';
    const { parentPort } = (await import(/* @vite-ignore */ threads)) as typeof import('node:worker_threads');
    return {
      post: (message, transfer = []) => parentPort?.postMessage(message, transfer),
      listen: (hear) => parentPort?.on('message', hear),
    };
  }
  // The library of a page's types has no worker's own scope.
  const post = globalThis.postMessage as (message: FromWorker, transfer: ArrayBuffer[]) => void;
  return {
    post: (message, transfer = []) => post(message, transfer),
    listen: (hear) => globalThis.addEventListener('message', (event) => hear((event as MessageEvent<ToWorker>).data)),
  };
}

/** A picture that is being rendered. */
interface Running {
  number: number;
  whole: boolean;
  picture: engine.Picture;
  slice: number;
  begun: number;
}

const port = await openPort();
let scene: Scene | undefined;
/** The files of scenes. They stay while scenes change, so that each is read once. */
let files: engine.Files | undefined;
let running: Running | undefined;

// A message to oneself comes after those that are waiting, and sooner than any timer. Node takes a thousand from one port
// before it looks at another.
const turn = new MessageChannel();
if (!inNode) turn.port1.onmessage = () => renderSlice();
const later = () => (inNode ? setImmediate(renderSlice) : turn.port2.postMessage(0));

const text = (error: unknown) => (error instanceof Error ? error.message : String(error));

function stop() {
  running?.picture.free();
  running = undefined;
}

function load(message: Extract<ToWorker, { kind: 'scene' }>) {
  stop();
  port.post({ kind: 'begun', number: message.number });
  scene?.free();
  scene = undefined;
  const begun = performance.now();
  try {
    scene = Scene.of(message.source);
    const { inner } = scene;
    files ??= new engine.Files();
    files.keep(message.files);
    inner.setFiles(files);
    const { findings, notes, summary } = scene;
    const [width, height] = message.size ?? [summary.width, summary.height];
    const camera = inner.camera(width, height);
    const info = { summary, findings, notes, camera, up: inner.up(), bounds: inner.bounds(), lights: inner.lights() };
    port.post({ kind: 'loaded', number: message.number, info, milliseconds: performance.now() - begun });
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError) throw error;
    port.post({ kind: 'failed', number: message.number, message: text(error) });
  }
}

function begin({ number, request, shard, slice }: Extract<ToWorker, { kind: 'picture' }>) {
  stop();
  port.post({ kind: 'begun', number });
  if (!scene) return;
  try {
    const picture = scene.inner.picture(JSON.stringify({ ...request, shard }));
    // Depth and steps are coloured once all is there.
    const whole = request.output === 'depth' || request.output === 'steps';
    running = { number, whole, picture, slice, begun: performance.now() };
    later();
  } catch (error) {
    if (error instanceof WebAssembly.RuntimeError) throw error;
    port.post({ kind: 'failed', number, message: text(error) });
  }
}

function renderSlice() {
  if (!running) return;
  const { number, whole, picture, slice, begun } = running;
  if (picture.left > 0) {
    const finished = picture.step(slice);
    if (!whole) sendTiles(number, picture, finished);
  }
  if (picture.left > 0) {
    later();
    return;
  }
  if (whole) send(number, Uint32Array.of(0, 0, picture.width, picture.height), [picture.data()]);
  port.post({ kind: 'done', number, rays: picture.rays, milliseconds: performance.now() - begun });
  stop();
}

function sendTiles(number: number, picture: engine.Picture, finished: Uint32Array) {
  const tiles = new Uint32Array(4 * finished.length);
  const parts = Array.from(finished, (index, i) => {
    tiles.set(picture.tile(index), 4 * i);
    return picture.pixels(index);
  });
  send(number, tiles, parts);
}

function send(number: number, tiles: Uint32Array<ArrayBuffer>, parts: Uint8Array[]) {
  const pixels = new Uint8ClampedArray(parts.reduce((length, part) => length + part.length, 0));
  let at = 0;
  for (const part of parts) {
    pixels.set(part, at);
    at += part.length;
  }
  port.post({ kind: 'tiles', number, tiles, pixels }, [tiles.buffer, pixels.buffer]);
}

function answer(of: Scene, question: Question): unknown {
  const { inner } = of;
  switch (question.about) {
    case 'pick': {
      const { camera, width, height, x, y } = question;
      const hit = inner.pick(camera, width, height, x, y);
      return hit === undefined ? undefined : JSON.parse(hit);
    }
    case 'grid': {
      const grid = inner.testGrid(question.camera);
      if (!grid) return undefined;
      const { points, inside, step } = grid;
      grid.free();
      return { points, inside, step };
    }
    case 'mesh':
      return of.mesh(question.tolerance);
    case 'export': {
      const written = inner.export(question.file, question.tolerance);
      const { bytes, companion, losses } = written;
      written.free();
      return { bytes, companion, losses };
    }
    case 'text':
      return of.text;
  }
}

port.listen((message) => {
  switch (message.kind) {
    case 'module':
      void start(message.module).then(() => port.post({ kind: 'ready' }));
      break;
    case 'scene':
      load(message);
      break;
    case 'file':
      files ??= new engine.Files();
      files.put(message.name, message.bytes);
      break;
    case 'picture':
      begin(message);
      break;
    case 'cancel':
      stop();
      port.post({ kind: 'idle' });
      break;
    case 'ask':
      try {
        if (!scene) throw new Error('there is no scene');
        port.post({ kind: 'answer', id: message.id, answer: answer(scene, message.question) });
      } catch (error) {
        if (error instanceof WebAssembly.RuntimeError) throw error;
        port.post({ kind: 'refused', id: message.id, message: text(error) });
      }
  }
});
