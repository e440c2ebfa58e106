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
/** The actions that make sense on the page. */
const HERE = new Set([
  'ToggleLightsTurn', 'Larger', 'Smaller', 'Refresh', 'ToggleWireframe', 'ToggleNormals', 'ToggleIoTest', 'ToggleIntersectTest',
  'ToggleAxes', 'ToggleOutside', 'FrameAll', 'FrameSelected', 'FrontView', 'RightView', 'TopView', 'Home', 'WriteCamera',
  'Screenshot', 'ToggleHelp', 'Undo', 'Redo', 'Open', 'Save',
]);

export class Keys {
  private rows: Key[];

  constructor(table: Key[]) {
    this.rows = table.filter((row) => HERE.has(row.action));
  }

  /** The action of a key press over the picture. */
  action(event: KeyboardEvent): string | undefined {
    if (event.altKey || event.metaKey) return undefined;
    const shift = event.shiftKey && event.key.length === 1 && /[a-z]/i.test(event.key) ? 'Shift+' : '';
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
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
        element.textContent = key;
        head.append(element);
      }
      row.append(head);
      row.insertCell().textContent = help;
    }
  }
}
