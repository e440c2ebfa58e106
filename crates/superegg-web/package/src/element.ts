// <superegg-scene>: a scene in a page, ray traced, that can be turned.
//
//     <superegg-scene src="snowman.scn" label="A snowman"></superegg-scene>
//     <superegg-scene>prm egg
//     exp 1 .9</superegg-scene>

import { fetchScene } from './fetch.js';
import type { SceneSource } from './types.js';
import { SceneView, keyAction, modestWorkers } from './view.js';

const STYLE = `
:host { display: block; aspect-ratio: 4 / 3; position: relative; contain: content; }
canvas { width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; outline-offset: -2px; }
canvas:active { cursor: grabbing; }
p { position: absolute; inset: auto 0 0 0; margin: 0; padding: .5em .75em; font: 13px/1.4 system-ui, sans-serif;
    color: #fff; background: #a3241fe6; white-space: pre-wrap; }
p:empty { display: none; }`;

/**
 * A scene as an element. Attributes: `src`, the address of a scene or of a file of another program; without it the
 * element's text is the scene. `label`, for screen readers. `workers`, default: half the cores. Events: `load`, `error`.
 */
export class SupereggScene extends HTMLElement {
  static observedAttributes = ['src', 'label'];
  private view: SceneView | undefined;
  private canvas = document.createElement('canvas');
  private message = document.createElement('p');
  private seen: IntersectionObserver | undefined;
  private count = 0;

  constructor() {
    super();
    const root = this.attachShadow({ mode: 'open' });
    const style = document.createElement('style');
    style.textContent = STYLE;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'img');
    this.message.setAttribute('role', 'status');
    root.append(style, this.canvas, this.message);
    this.canvas.addEventListener('keydown', (event) => {
      const action = keyAction(event);
      if (action && this.view?.act(action)) event.preventDefault();
    });
  }

  connectedCallback(): void {
    this.describe();
    // Scenes far down a page wait until they are near the window.
    this.seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      this.seen?.disconnect();
      this.begin();
    }, { rootMargin: '200px' });
    this.seen.observe(this);
  }

  disconnectedCallback(): void {
    this.seen?.disconnect();
    this.view?.close();
    this.view = undefined;
  }

  attributeChangedCallback(name: string): void {
    if (name === 'label') this.describe();
    else if (this.view) void this.load();
  }

  /** Shows a text or a file in place of what the element shows. */
  async show(source: SceneSource): Promise<void> {
    this.count += 1;
    this.begin(false);
    await this.tell(source);
  }

  private describe(): void {
    const label = this.getAttribute('label') ?? 'A ray traced scene';
    this.canvas.setAttribute('aria-label', `${label}. Arrow keys turn it, plus and minus zoom.`);
  }

  private begin(loads = true): void {
    if (this.view || !this.isConnected) return;
    const workers = Number(this.getAttribute('workers')) || modestWorkers();
    this.view = new SceneView(this.canvas, { workers });
    this.view.on('error', (error) => this.fail(error));
    if (loads) void this.load();
  }

  private async load(): Promise<void> {
    this.count += 1;
    const { count } = this;
    try {
      const source = await this.source();
      if (count === this.count) await this.tell(source);
    } catch (error) {
      if (count === this.count) this.fail(error);
    }
  }

  private async tell(source: SceneSource): Promise<void> {
    try {
      const info = await this.view?.show(source);
      if (!info) return;
      const error = info.findings.find((finding) => finding.severity === 'error');
      this.message.textContent = error ? `line ${error.line}: ${error.message}` : '';
      this.dispatchEvent(new CustomEvent('load', { detail: info }));
    } catch (error) {
      this.fail(error);
    }
  }

  private fail(error: unknown): void {
    this.message.textContent = error instanceof Error ? error.message : String(error);
    this.dispatchEvent(new ErrorEvent('error', { message: this.message.textContent }));
  }

  private async source(): Promise<SceneSource> {
    const src = this.getAttribute('src');
    if (src === null) return this.textContent ?? '';
    return fetchScene(new URL(src, this.baseURI));
  }
}

if (!customElements.get('superegg-scene')) customElements.define('superegg-scene', SupereggScene);

declare global {
  interface HTMLElementTagNameMap {
    'superegg-scene': SupereggScene;
  }
}
