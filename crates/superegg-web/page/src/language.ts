// The language in this thread: errors, completion, hints, help. The engine answers; nothing is asked before it has started.

import { engine, start } from 'superegg/engine';
import type { Finding } from 'superegg';

/** The words that fit at a cursor. */
export interface Completions {
  from: number;
  words: { word: string; detail: string; info: string }[];
}

/** The exponents of a primitive, and the part of the text that sets them. */
export interface Exponents {
  name: string;
  e: number;
  n: number;
  word: string;
  line: number;
  from: number;
  to: number;
  is_new: boolean;
}

/** A row of the table of keys. */
export interface Key {
  keys: string[];
  action: string;
  help: string;
}

/** A text that the engine has run. */
export class Document {
  private inner: engine.Document;
  readonly findings: Finding[];

  constructor(text: string) {
    this.inner = new engine.Document(text);
    this.findings = JSON.parse(this.inner.findings()) as Finding[];
  }

  complete(line: number, before: string): Completions {
    return JSON.parse(this.inner.complete(line, before)) as Completions;
  }

  hint(line: number, before: string): string | undefined {
    return this.inner.hint(line, before);
  }

  highlight(line: string): Uint32Array {
    return this.inner.highlight(line);
  }

  /** The exponents of a primitive; without a name, of the one that is selected behind a line. */
  exponents(name: string | undefined, line: number): Exponents | undefined {
    const found = this.inner.exponents(name, line);
    return found === undefined ? undefined : (JSON.parse(found) as Exponents);
  }

  free(): void {
    this.inner.free();
  }
}

export const exponentLine = (word: string, e: number, n: number) => engine.Document.exponentLine(word, e, n);
export const helpForCommand = (word: string) => engine.helpForCommand(word);
export const keyTable = () => JSON.parse(engine.keys()) as Key[];
export { start };
