// The messages between a page and its workers.

import type { FirstHit, Finding, PictureRequest, SceneSource, Summary } from './types.js';

/** Width and height of a picture in pixels. */
export type Size = readonly [number, number];

/** What a page tells a worker. */
export type ToWorker =
  | { kind: 'module'; module: WebAssembly.Module }
  /** A picture that scenes may name from now on. */
  | { kind: 'file'; name: string; bytes: Uint8Array }
  /** A scene, without its files: of those that were sent it has the ones of these names. */
  | { kind: 'scene'; number: number; source: SceneSource; files: string[]; size: Size | undefined }
  | { kind: 'picture'; number: number; request: PictureRequest; shard: string; slice: number }
  | { kind: 'cancel' }
  | { kind: 'ask'; id: number; question: Question };

/** What a worker answers. */
export type FromWorker =
  | { kind: 'ready' }
  /** A scene or a picture is begun. */
  | { kind: 'begun'; number: number }
  | { kind: 'loaded'; number: number; info: SceneInfo; milliseconds: number }
  /** The picture is given up. */
  | { kind: 'idle' }
  /** Left, top, width and height of tiles, and their pixels one after the other. */
  | { kind: 'tiles'; number: number; tiles: Uint32Array; pixels: Uint8ClampedArray<ArrayBuffer> }
  | { kind: 'done'; number: number; rays: number; milliseconds: number }
  | { kind: 'failed'; number: number; message: string }
  | { kind: 'answer'; id: number; answer: unknown }
  | { kind: 'refused'; id: number; message: string };

/** What is known of a scene once it is loaded. */
export interface SceneInfo {
  summary: Summary;
  findings: Finding[];
  notes: string[];
  camera: Float64Array;
  up: Float64Array;
  bounds: Float64Array | undefined;
  lights: Float64Array;
}

/** A question about the loaded scene. */
export type Question =
  | { about: 'pick'; camera: Float64Array; width: number; height: number; x: number; y: number }
  | { about: 'grid'; camera: Float64Array }
  | { about: 'mesh'; tolerance: number }
  | { about: 'export'; file: string; tolerance: number }
  | { about: 'text' };

/** The points of the inside-outside test. */
export interface TestGrid {
  points: Float64Array;
  inside: Uint8Array;
  step: number;
}

/** The answer to each kind of question. */
export interface Answers {
  pick: FirstHit | undefined;
  grid: TestGrid | undefined;
  mesh: import('./types.js').Mesh;
  export: { bytes: Uint8Array<ArrayBuffer>; companion: Uint8Array<ArrayBuffer> | undefined; losses: string[] };
  text: string;
}
