// What the parts of the page share: the view, what is shown, and messages.

import type { SceneSource } from 'superegg';
import { SceneView } from 'superegg/view';
import { byId, message } from './dom';

export const canvas = byId<HTMLCanvasElement>('picture');
export const view = new SceneView(canvas);

/** The scene of the page: its text, or a file whose text would be too long. */
export type Shown = { kind: 'text' } | { kind: 'file'; name: string; source: SceneSource };

export const page = {
  shown: { kind: 'text' } as Shown,
  /** The picture of surroundings that was dropped. */
  surroundings: undefined as Uint8Array | undefined,
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
