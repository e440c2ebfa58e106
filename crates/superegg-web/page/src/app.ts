// What the parts of the page share: the view, what is shown, and messages.

import type { SceneSource } from 'superegg';
import { SceneView } from 'superegg/view';
import { byId, message } from './dom';

export const canvas = byId<HTMLCanvasElement>('picture');
export const view = new SceneView(canvas);

/** The scene of the page: its text, or a file whose text would be too long. */
export type Shown = { kind: 'text' } | { kind: 'file'; name: string; source: Exclude<SceneSource, string> };

export const page = {
  shown: { kind: 'text' } as Shown,
  /** The pictures that scenes may name, dropped or fetched, by name. */
  files: {} as Record<string, Uint8Array>,
  /** The frame of the scene's keys that is shown; without one the scene is as without keys. */
  frame: undefined as number | undefined,
};

const FORGOTTEN_MS = 8000;
let forgetting: ReturnType<typeof setTimeout> | undefined;

/** Shows a message for a while. Screen readers read it. */
export function say(text: string): void {
  byId('status').textContent = text;
  clearTimeout(forgetting);
  forgetting = setTimeout(() => {
    byId('status').textContent = '';
  }, FORGOTTEN_MS);
}

export const complain = (error: unknown) => say(message(error));
