// The frames of a scene with keys: a slider, and playing.

import { complain, page, view } from './app';
import { byId } from './dom';
import { showScene } from './text';

/** The least time of a frame while they are played: 24 a second. */
const FRAME_MS = 1000 / 24;
/** A frame that has no picture after this long is left. */
const PATIENCE_MS = 5000;

const panel = byId('frames');
const button = byId<HTMLButtonElement>('play');
const slider = byId<HTMLInputElement>('frame');
const output = byId<HTMLOutputElement>('frame-number');
let count = 0;
let isPlaying = false;
/** Called with the first picture of the frame that is shown. */
let seen: (() => void) | undefined;

function describe(): void {
  panel.hidden = count === 0;
  slider.max = String(Math.max(count - 1, 0));
  slider.value = String(page.frame ?? 0);
  output.value = page.frame === undefined ? `${count} frames` : `${page.frame} / ${count - 1}`;
  slider.setAttribute('aria-valuetext', page.frame === undefined ? 'no frame' : `frame ${page.frame}`);
  button.textContent = isPlaying ? 'Stop' : 'Play';
  button.setAttribute('aria-pressed', String(isPlaying));
}

async function showFrame(frame: number): Promise<void> {
  page.frame = frame;
  describe();
  await showScene('turned');
}

const pause = (milliseconds: number) => new Promise<void>((resolve) => setTimeout(resolve, milliseconds));

async function play(): Promise<void> {
  isPlaying = true;
  try {
    while (isPlaying && count > 0) {
      const begun = performance.now();
      const picture = new Promise<void>((resolve) => {
        seen = resolve;
      });
      await showFrame(page.frame === undefined ? 0 : (page.frame + 1) % count);
      await Promise.race([picture, pause(PATIENCE_MS)]);
      await pause(FRAME_MS - (performance.now() - begun));
    }
  } catch (error) {
    complain(error);
  }
  isPlaying = false;
  describe();
}

/** Carries out an action of the frames. Returns whether it is one. */
export function frameAction(action: string): boolean {
  const step = { PreviousFrame: -1, NextFrame: 1 }[action];
  if (step === undefined && action !== 'TogglePlaying') return false;
  if (count === 0) return true;
  if (step === undefined) {
    if (isPlaying) isPlaying = false;
    else void play();
    describe();
    return true;
  }
  isPlaying = false;
  const next = page.frame === undefined ? 0 : (page.frame + step + count) % count;
  showFrame(next).catch(complain);
  return true;
}

slider.addEventListener('input', () => {
  isPlaying = false;
  showFrame(Number(slider.value)).catch(complain);
});
view.on('loaded', ({ summary }) => {
  count = summary.frames;
  // A text that lost its last frames shows the last that is left.
  if (page.frame !== undefined && page.frame >= count) page.frame = count > 0 ? count - 1 : undefined;
  describe();
});
view.on('pass', () => seen?.());
view.on('error', () => seen?.());
