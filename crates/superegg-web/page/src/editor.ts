// The editor: CodeMirror with the language's own completion, hints, painting and errors.

import { autocompletion, completionKeymap, type CompletionContext, type CompletionResult } from '@codemirror/autocomplete';
import { defaultKeymap, history, historyKeymap } from '@codemirror/commands';
import { lintGutter, lintKeymap, nextDiagnostic, setDiagnostics, type Diagnostic } from '@codemirror/lint';
import { EditorState, StateEffect } from '@codemirror/state';
import {
  Decoration, drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, hoverTooltip, keymap, lineNumbers,
  ViewPlugin, WidgetType, type DecorationSet, type ViewUpdate,
} from '@codemirror/view';
import type { Finding } from 'superegg';
import { Document, helpForCommand } from './language';

const PAINTS = ['se-command', 'se-name', 'se-value', 'se-wrong', 'se-comment'].map((name) => Decoration.mark({ class: name }));
/** A longer line is not painted. */
const LONGEST_LINE = 2000;

/** Something that the editor shows has changed outside of it. */
const refreshed = StateEffect.define<null>();

class HintWidget extends WidgetType {
  constructor(private text: string) {
    super();
  }

  override eq(other: HintWidget): boolean {
    return other.text === this.text;
  }

  override toDOM(): HTMLElement {
    const element = document.createElement('span');
    element.className = 'se-hint';
    element.setAttribute('aria-hidden', 'true');
    element.textContent = this.text;
    return element;
  }
}

export interface EditorEvents {
  /** The text was changed. */
  changed(text: string): void;
  /** The cursor is in this line, counted from 0. */
  cursor(line: number): void;
}

export class Editor {
  readonly view: EditorView;
  private document: Document | undefined;

  constructor(parent: HTMLElement, text: string, private events: EditorEvents) {
    const painter = ViewPlugin.define((view) => new Painter(view, () => this.document), { decorations: (painter) => painter.decorations });
    this.view = new EditorView({
      parent,
      state: EditorState.create({
        doc: text,
        extensions: [
          lineNumbers(), history(), drawSelection(), highlightActiveLine(), highlightActiveLineGutter(), lintGutter(),
          autocompletion({ override: [(context) => this.complete(context)], icons: false }),
          keymap.of([...completionKeymap, ...lintKeymap, ...historyKeymap, ...defaultKeymap]),
          hoverTooltip((view, at) => this.hover(view, at)),
          painter,
          EditorView.lineWrapping,
          EditorView.contentAttributes.of({ 'aria-label': 'Scene as text', tabindex: '0', spellcheck: 'false', autocapitalize: 'off' }),
          EditorView.updateListener.of((update) => this.updated(update)),
        ],
      }),
    });
  }

  get text(): string {
    return this.view.state.doc.toString();
  }

  /** Replaces the text, as one change that can be undone. */
  set text(text: string) {
    this.view.dispatch({ changes: { from: 0, to: this.view.state.doc.length, insert: text }, selection: { anchor: 0 }, scrollIntoView: true });
  }

  /** The line of the cursor, counted from 0. */
  get line(): number {
    const { state } = this.view;
    return state.doc.lineAt(state.selection.main.head).number - 1;
  }

  /** Shows what the engine found in the text, and paints with what it knows. */
  setDocument(document: Document, findings: Finding[]): void {
    this.document = document;
    const { doc } = this.view.state;
    const diagnostics = findings.filter((found) => found.line <= doc.lines).map((found): Diagnostic => {
      const line = doc.line(Math.max(found.line, 1));
      const isWhole = found.line === 0;
      const from = isWhole ? line.from : Math.min(line.from + found.from, line.to);
      const to = isWhole ? line.from : Math.min(Math.max(line.from + found.to, from), line.to);
      const message = found.help ? `${found.message}\n${found.help}` : found.message;
      return { from, to, severity: found.severity, message, source: found.code };
    });
    this.view.dispatch(setDiagnostics(this.view.state, diagnostics), { effects: refreshed.of(null) });
  }

  /** Moves the cursor to the next error or warning. */
  goToProblem(): void {
    this.view.focus();
    nextDiagnostic(this.view);
  }

  /** Replaces a part of a line, or adds a line behind it. Lines are counted from 0. */
  edit(line: number, from: number, to: number, text: string, isNew: boolean): void {
    const at = this.view.state.doc.line(line + 1);
    if (isNew) this.view.dispatch({ changes: { from: at.to, insert: `\n${text}` }, userEvent: 'input.slider' });
    else this.view.dispatch({ changes: { from: at.from + from, to: at.from + to, insert: text }, userEvent: 'input.slider' });
  }

  private updated(update: ViewUpdate): void {
    if (update.docChanged) this.events.changed(this.text);
    if (update.docChanged || update.selectionSet) this.events.cursor(this.line);
  }

  private complete(context: CompletionContext): CompletionResult | null {
    const line = context.state.doc.lineAt(context.pos);
    const before = line.text.slice(0, context.pos - line.from);
    if (!this.document || (!context.explicit && !/\S$/.test(before))) return null;
    const { from, words } = this.document.complete(line.number - 1, before);
    if (words.length === 0) return null;
    const options = words.map(({ word, detail, info }) => ({
      label: word, ...(detail ? { detail } : {}), ...(info ? { info } : {}),
    }));
    return { from: line.from + from, options, filter: false };
  }

  private hover(view: EditorView, at: number) {
    const line = view.state.doc.lineAt(at);
    const word = /^\s*([^\s#;]+)/.exec(line.text);
    const start = word ? line.from + word[0].length - (word[1]?.length ?? 0) : 0;
    if (!word?.[1] || at < start || at > start + word[1].length) return null;
    const help = helpForCommand(word[1]);
    if (!help) return null;
    const create = () => {
      const dom = document.createElement('pre');
      dom.textContent = help;
      return { dom };
    };
    return { pos: start, end: start + word[1].length, above: false, create };
  }
}

/** Paints the lines that are in sight, and the hint behind the cursor. */
class Painter {
  decorations: DecorationSet;

  constructor(view: EditorView, private document: () => Document | undefined) {
    this.decorations = this.paint(view);
  }

  update(update: ViewUpdate): void {
    const isRefreshed = update.transactions.some((one) => one.effects.some((effect) => effect.is(refreshed)));
    if (update.docChanged || update.viewportChanged || update.selectionSet || update.focusChanged || isRefreshed) {
      this.decorations = this.paint(update.view);
    }
  }

  private paint(view: EditorView): DecorationSet {
    const document = this.document();
    if (!document) return Decoration.none;
    const ranges = [];
    const { doc, selection } = view.state;
    const cursor = selection.main.empty && view.hasFocus ? selection.main.head : -1;
    for (const { from, to } of view.visibleRanges) {
      for (let line = doc.lineAt(from); ; line = doc.line(line.number + 1)) {
        if (line.length <= LONGEST_LINE) {
          const parts = document.highlight(line.text);
          for (let i = 0; i + 2 < parts.length; i += 3) {
            const [start = 0, end = 0, kind = 0] = parts.subarray(i, i + 3);
            const mark = PAINTS[kind];
            if (mark && end > start) ranges.push(mark.range(line.from + start, line.from + end));
          }
          const hint = cursor === line.to && line.length > 0 ? document.hint(line.number - 1, line.text) : undefined;
          if (hint) ranges.push(Decoration.widget({ widget: new HintWidget(hint), side: 1 }).range(line.to));
        }
        if (line.to >= to || line.number >= doc.lines) break;
      }
    }
    return Decoration.set(ranges, true);
  }
}
