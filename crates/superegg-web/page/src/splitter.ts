// The width of the text beside the picture.

const [LEAST, MOST] = [20, 75];

export function splitter(bar: HTMLElement, main: HTMLElement): void {
  let percent = 38;
  const set = (next: number) => {
    percent = Math.min(MOST, Math.max(LEAST, next));
    main.style.setProperty('--text-width', `${percent}%`);
    bar.setAttribute('aria-valuenow', String(Math.round(percent)));
  };
  set(percent);
  bar.addEventListener('pointerdown', (event) => {
    bar.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  bar.addEventListener('pointermove', (event) => {
    if (!bar.hasPointerCapture(event.pointerId)) return;
    const box = main.getBoundingClientRect();
    set((100 * (event.clientX - box.left)) / box.width);
  });
  bar.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -2, ArrowRight: 2 }[event.key];
    if (!step) return;
    set(percent + step);
    event.preventDefault();
  });
}
