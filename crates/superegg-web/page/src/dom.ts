/** The element with this id, which is in the page. */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

/** Hands a file to the user. */
export function download(name: string, blob: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A number with so many digits, without an exponent where it is short enough. */
export function short(x: number, digits = 6): string {
  return String(Number(x.toPrecision(digits)));
}

export const message = (error: unknown) => (error instanceof Error ? error.message : String(error));
