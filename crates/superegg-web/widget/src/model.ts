// The half of the widget that Python sees: its traits, and the messages to it.

import type { FirstHit, Output, SceneExtras, SceneSource } from 'superegg';

/** The traits, by their names in Python. */
export interface Traits {
  /** The scene as text; empty where `binary` has it. */
  text: string;
  /** The scene as a binary file; empty where `text` has it. */
  binary: DataView;
  /** The pictures that the scene names. */
  files: Record<string, DataView>;
  /** The frame of the scene's keys. */
  frame: number | null;
  /** Width and height in pixels of the page. */
  size: [number, number];
  output: Output;
  /** Position, target, up, field of view and height of an orthographic picture; `null` before the first picture. */
  camera: number[] | null;
  /** The hit of the last click; `null` for a miss. */
  hit: FirstHit | null;
  /** An error. */
  note: string;
  /** The address of the compressed module; empty where the kernel sends it. */
  module: string;
}

/** The model of a widget, as anywidget has it. */
export interface Model {
  get<K extends keyof Traits>(key: K): Traits[K];
  set<K extends keyof Traits>(key: K, value: Traits[K]): void;
  save_changes(): void;
  on(event: string, hear: (...values: never[]) => void): void;
  off(event: string, hear: (...values: never[]) => void): void;
  send(content: unknown): void;
}

const bytes = (view: DataView) => new Uint8Array(view.buffer, view.byteOffset, view.byteLength);

/** The scene of a model. */
export function sourceOf(model: Model): SceneSource {
  const files = Object.fromEntries(Object.entries(model.get('files')).map(([name, view]) => [name, bytes(view)]));
  const frame = model.get('frame');
  const extras: SceneExtras = frame === null ? { files } : { files, frame };
  const binary = bytes(model.get('binary'));
  return binary.length > 0 ? { name: 'scene.sqb', bytes: binary, ...extras } : { text: model.get('text'), ...extras };
}
