// Two sliders for the exponents of a primitive.

import { byId, short } from './dom';
import { exponentLine, type Exponents } from './language';

const MOST = 3;

export class Sliders {
  private field = byId<HTMLFieldSetElement>('exponents');
  private inputs = { e: byId<HTMLInputElement>('e'), n: byId<HTMLInputElement>('n') };
  private shown: Exponents | undefined;

  /** `change` is called with the part of the text to replace, and the new text. */
  constructor(change: (place: Exponents, text: string) => void) {
    for (const key of ['e', 'n'] as const) {
      const input = this.inputs[key];
      input.addEventListener('input', () => {
        const { shown } = this;
        if (!shown) return;
        const next = { e: shown.e, n: shown.n, [key]: Number(input.value) };
        change(shown, exponentLine(shown.word, next.e, next.n));
      });
    }
  }

  /** Shows the exponents of a primitive; hides the sliders without one. */
  show(exponents: Exponents | undefined): void {
    this.shown = exponents;
    this.field.hidden = !exponents;
    if (!exponents) return;
    const legend = this.field.querySelector('legend');
    if (legend) legend.textContent = `Exponents of ${exponents.name}`;
    for (const key of ['e', 'n'] as const) {
      const input = this.inputs[key];
      const value = exponents[key];
      input.max = String(Math.max(MOST, Math.ceil(value)));
      if (document.activeElement !== input) input.value = String(value);
      const output = input.nextElementSibling as HTMLOutputElement;
      output.value = short(value, 3);
      input.setAttribute('aria-valuetext', output.value);
    }
  }
}
