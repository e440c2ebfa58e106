// Dark or light: as the system, until somebody chooses.

const KEY = 'superegg-theme';
const system = matchMedia('(prefers-color-scheme: dark)');

function chosen(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function apply(): void {
  document.documentElement.dataset.theme = chosen() ?? (system.matches ? 'dark' : 'light');
}

/** Makes a button change the theme. `changed` is called after each change. */
export function themeButton(button: HTMLElement, changed: () => void): void {
  apply();
  system.addEventListener('change', () => {
    apply();
    changed();
  });
  button.addEventListener('click', () => {
    const next = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
    try {
      localStorage.setItem(KEY, next);
    } catch {
      // Without storage the choice lasts as long as the page.
    }
    document.documentElement.dataset.theme = next;
    changed();
  });
}
