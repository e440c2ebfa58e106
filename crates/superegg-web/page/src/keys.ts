// The keys of the course's program, from the engine's table.

import type { Key } from './language';

/** Keys of the page alone: those of the arrows are of no window with a panel. */
const MORE: Key[] = [
  { keys: ['ArrowLeft', 'ArrowRight'], action: 'TurnLeft', help: 'turn the scene to the side' },
  { keys: ['ArrowUp', 'ArrowDown'], action: 'TurnUp', help: 'turn the scene up or down' },
];
const ARROWS: Record<string, string> = {
  ArrowLeft: 'TurnLeft', ArrowRight: 'TurnRight', ArrowUp: 'TurnUp', ArrowDown: 'TurnDown',
};
/** Actions that mean something else here: a page has no command line, no preview, and always traces rays. */
const HELP: Record<string, string> = {
  KeyboardBack: 'keyboard to the text',
  ToggleShading: 'the next quantity: light, normals, depth, instances, steps',
  ToggleTrace: 'stop the picture, or go on with it',
  FrameSelected: 'frame the scene',
  Screenshot: 'download the picture',
  Open: 'open files; files dropped on the page open too',
  Save: 'download the scene',
};
const LABELS: Record<string, string> = { ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓' };
/** The actions that make sense on the page. */
const HERE = new Set([
  ...Object.keys(HELP), 'PreviousFrame', 'NextFrame', 'TogglePlaying',
  'ToggleLightsTurn', 'Larger', 'Smaller', 'Refresh', 'ToggleWireframe', 'ToggleNormals', 'ToggleIoTest', 'ToggleIntersectTest',
  'ToggleAxes', 'ToggleOutside', 'FrameAll', 'FrontView', 'RightView', 'TopView', 'Home', 'WriteCamera', 'ToggleHelp', 'Undo', 'Redo',
]);

export class Keys {
  private rows: Key[];

  constructor(table: Key[]) {
    const rows = table.filter((row) => HERE.has(row.action));
    this.rows = rows.map((row) => ({ ...row, help: HELP[row.action] ?? row.help }));
  }

  /** The action of a key press over the picture. */
  action(event: KeyboardEvent): string | undefined {
    if (event.altKey || event.metaKey) return undefined;
    const shift = event.shiftKey && event.key.length === 1 && /[a-z]/i.test(event.key) ? 'Shift+' : '';
    const key = event.key === ' ' ? 'Space' : event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const typed = event.ctrlKey ? `Ctrl+${shift}${key}` : `${shift}${key}`;
    const find = (name: string) => this.rows.find((row) => row.keys.includes(name))?.action;
    // Shift with a letter that has no action of its own is the letter.
    return find(typed) ?? (event.ctrlKey ? undefined : find(key) ?? ARROWS[event.key]);
  }

  /** Fills the table of the help. */
  describe(table: HTMLTableElement): void {
    for (const { keys, help } of [...this.rows, ...MORE]) {
      const row = table.insertRow();
      const head = document.createElement('th');
      head.scope = 'row';
      for (const key of keys) {
        const element = document.createElement('kbd');
        element.textContent = LABELS[key] ?? key;
        head.append(element);
      }
      row.append(head);
      row.insertCell().textContent = help;
    }
  }
}
