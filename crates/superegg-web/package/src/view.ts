// A canvas that shows a scene and can be turned: coarse pictures while it moves, then a full one, then all samples.

import { engine, start } from './engine.js';
import { Superseded, WorkerPool } from './pool.js';
import type { SceneInfo } from './protocol.js';
import type { Output, SceneSource } from './types.js';

/** The time of a coarse picture. */
const COARSE_MS = 60;
const COARSEST = 16;
/** Samples per millisecond that are assumed before any measurement. */
const FIRST_GUESS = 300;
/** A picture beyond its first full pass stops after this long, until somebody asks for more. */
const UNASKED_MS = 20_000;
const MOST_PIXELS = 2_000_000;
/** The farthest that a pointer moves in a click. */
const CLICK_PX = 3;
const WHEEL_STEP = 1.1;
const KEY_TURN = 0.12;

const KEYS: Record<string, string> = {
  ArrowLeft: 'TurnLeft', ArrowRight: 'TurnRight', ArrowUp: 'TurnUp', ArrowDown: 'TurnDown',
  '+': 'Larger', '=': 'Larger', '-': 'Smaller', Home: 'Home',
};

/** The action of a key where there is no table of keys: arrows, plus, minus and Home. */
export function keyAction(event: KeyboardEvent): string | undefined {
  return event.ctrlKey || event.metaKey || event.altKey ? undefined : KEYS[event.key];
}

/** The workers of a view that is one of several on a page. */
export function modestWorkers(): number {
  return Math.ceil((navigator.hardwareConcurrency || 2) / 2);
}

/** A pass of a picture that is finished. */
export interface Pass {
  /** The edge of the square of canvas pixels that one pixel of the pass covers. */
  coarseness: number;
  samples: number;
  milliseconds: number;
  /** Nothing finer will follow. */
  isLast: boolean;
  /** It stopped before all samples were taken, see `refine`. */
  isPaused: boolean;
}

export interface ViewEvents {
  /** The picture will change. */
  begun: undefined;
  loaded: SceneInfo;
  pass: Pass;
  camera: Float64Array;
  /** A click, in pixels of the canvas. */
  click: { x: number; y: number };
  error: Error;
}

/** Shows a scene on a canvas. */
export class SceneView {
  readonly canvas: HTMLCanvasElement;
  readonly pool: WorkerPool;
  /** What is known of the scene that is shown. */
  info: SceneInfo | undefined;
  private context: CanvasRenderingContext2D;
  private coarse = document.createElement('canvas');
  private eye: engine.Eye | undefined;
  private listeners = new Map<keyof ViewEvents, Set<(event: never) => void>>();
  private lightsTurn = true;
  private wantedOutput: Output = 'light';
  private samplesPerMs = FIRST_GUESS;
  private isMoving = false;
  private isDirty = false;
  private isFirstPass = false;
  private isRunning = false;
  private isRefined = false;
  private stopped = false;
  private isHome = true;
  private number = 0;
  private sharpen: ReturnType<typeof setTimeout> | undefined;
  private observer: ResizeObserver;
  private pointers = new Map<number, { x: number; y: number }>();

  constructor(canvas: HTMLCanvasElement, options: { workers?: number; worker?: () => Worker } = {}) {
    this.canvas = canvas;
    this.pool = new WorkerPool(options.workers, options);
    const context = canvas.getContext('2d', { alpha: true });
    if (!context) throw new Error('this canvas has another context');
    this.context = context;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(canvas);
    this.listen();
  }

  /** Ends the workers. The canvas keeps its picture. */
  close(): void {
    this.observer.disconnect();
    clearTimeout(this.sharpen);
    this.pool.close();
    this.info = undefined;
  }

  on<K extends keyof ViewEvents>(kind: K, hear: (event: ViewEvents[K]) => void): void {
    const listeners = this.listeners.get(kind) ?? new Set();
    listeners.add(hear as (event: never) => void);
    this.listeners.set(kind, listeners);
  }

  private emit<K extends keyof ViewEvents>(kind: K, event: ViewEvents[K]): void {
    this.listeners.get(kind)?.forEach((hear) => hear(event as never));
  }

  /**
   * Loads a scene. With `keepView` the view stays where it is unless the scene's camera is another one; with `'turned'` it stays
   * where somebody has turned it, whatever the scene's camera does. Resolves once the scene is loaded, or another one took its
   * place.
   */
  async show(source: SceneSource, options: { keepView?: boolean | 'turned' } = {}): Promise<SceneInfo | undefined> {
    this.number += 1;
    const { number } = this;
    this.fit();
    try {
      const [info] = await Promise.all([
        this.pool.load(source, [this.canvas.width, this.canvas.height]), start(),
      ]);
      if (number !== this.number) return undefined;
      const old = this.info;
      this.info = info;
      const isSame = old !== undefined && old.camera.every((x, i) => x === info.camera[i]);
      const isTurned = options.keepView === 'turned' && !this.isHome;
      if (!this.eye || !(isTurned || (options.keepView && isSame))) this.goHome();
      this.emit('loaded', info);
      this.changed(false);
      return info;
    } catch (error) {
      if (error instanceof Superseded || number !== this.number) return undefined;
      throw error;
    }
  }

  /** The camera of the view: position, target, up, field of view, and height of an orthographic picture or 0. */
  get camera(): Float64Array {
    return this.eye?.camera() ?? new Float64Array(11);
  }

  set camera(numbers: Float64Array) {
    if (!this.info) return;
    this.eye?.free();
    this.eye = new engine.Eye(numbers);
    this.isHome = false;
    this.emit('camera', this.camera);
    this.changed(false);
  }

  get output(): Output {
    return this.wantedOutput;
  }

  set output(output: Output) {
    this.wantedOutput = output;
    this.changed(false);
  }

  /** Whether the lights turn with the scene. */
  get lightsTurning(): boolean {
    return this.lightsTurn;
  }

  set lightsTurning(turn: boolean) {
    this.lightsTurn = turn;
    this.changed(false);
  }

  /** Carries out a change of the view by the name that the table of keys has for it. Returns whether it is known. */
  act(action: string): boolean {
    const { eye, info } = this;
    if (!eye) return false;
    const aspect = this.canvas.width / this.canvas.height;
    switch (action) {
      case 'Larger': eye.magnify(WHEEL_STEP); break;
      case 'Smaller': eye.magnify(1 / WHEEL_STEP); break;
      case 'Home':
        this.goHome();
        this.emit('camera', this.camera);
        this.changed(false);
        return true;
      case 'FrontView': eye.lookFrom('front', info?.up ?? new Float64Array()); break;
      case 'RightView': eye.lookFrom('right', info?.up ?? new Float64Array()); break;
      case 'TopView': eye.lookFrom('top', info?.up ?? new Float64Array()); break;
      case 'FrameSelected':
      case 'FrameAll':
        if (info?.bounds) eye.frame(info.bounds, aspect);
        break;
      case 'ToggleLightsTurn': this.lightsTurning = !this.lightsTurn; return true;
      case 'TurnLeft': this.turn(-KEY_TURN, 0); return true;
      case 'TurnRight': this.turn(KEY_TURN, 0); return true;
      case 'TurnUp': this.turn(0, KEY_TURN); return true;
      case 'TurnDown': this.turn(0, -KEY_TURN); return true;
      default: return false;
    }
    this.moved();
    return true;
  }

  /** The scene's own camera, with all in sight that is in the scene's own picture. */
  private goHome(): void {
    const { info, canvas } = this;
    if (!info) return;
    const { width, height } = info.summary;
    this.eye?.free();
    this.eye = new engine.Eye(widened(info.camera, width / height, canvas.width / canvas.height));
    this.isHome = true;
  }

  /** Turns by a drag from the middle, in radii of the arcball. */
  private turn(x: number, y: number): void {
    this.eye?.press(0, 0);
    this.eye?.drag(x, y);
    this.eye?.release();
    this.moved();
  }

  /** Stops the picture in the making, until `refine` or a change. Returns whether there was one. */
  pause(): boolean {
    if (!this.isRunning) return false;
    this.stopped = true;
    this.pool.abandon();
    return true;
  }

  /** Whether the picture was stopped before all samples were taken. */
  get isPaused(): boolean {
    return this.stopped;
  }

  /** Takes all samples, however long it lasts. */
  refine(): void {
    this.isRefined = true;
    this.stopped = false;
    this.emit('begun', undefined);
    this.isDirty = true;
    void this.run();
  }

  /** Draws again: as it is, or coarsely because it is moving. */
  private changed(isMoving: boolean): void {
    this.isMoving = isMoving;
    this.isDirty = true;
    this.isRefined = false;
    this.stopped = false;
    this.emit('begun', undefined);
    // The first pass of a picture is finished, or a view in constant motion would never be seen.
    if (this.isRunning && !this.isFirstPass) this.pool.abandon();
    void this.run();
  }

  /** The camera has moved a little, and may go on. */
  private moved(): void {
    this.isHome = false;
    this.emit('camera', this.camera);
    this.changed(true);
    clearTimeout(this.sharpen);
    if (this.pointers.size === 0) this.sharpen = setTimeout(() => this.changed(false), 150);
  }

  private fit(): void {
    const box = this.canvas.getBoundingClientRect();
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const wanted = box.width * box.height * ratio * ratio;
    const scale = ratio * Math.min(1, Math.sqrt(MOST_PIXELS / Math.max(wanted, 1)));
    const width = Math.max(1, Math.round(box.width * scale));
    const height = Math.max(1, Math.round(box.height * scale));
    if (this.canvas.width === width && this.canvas.height === height) return;
    const before = document.createElement('canvas');
    before.width = this.canvas.width;
    before.height = this.canvas.height;
    before.getContext('2d')?.drawImage(this.canvas, 0, 0);
    this.canvas.width = width;
    this.canvas.height = height;
    this.context.drawImage(before, 0, 0, width, height);
  }

  private resize(): void {
    const { width, height } = this.canvas;
    this.fit();
    if (!this.info || (width === this.canvas.width && height === this.canvas.height)) return;
    if (this.isHome) this.goHome();
    this.emit('camera', this.camera);
    this.changed(false);
  }

  private async run(): Promise<void> {
    if (this.isRunning) return;
    this.isRunning = true;
    try {
      while (this.isDirty && this.info) {
        this.isDirty = false;
        const pixels = this.canvas.width * this.canvas.height;
        const affordable = this.samplesPerMs * COARSE_MS;
        const coarseness = Math.min(COARSEST, Math.max(1, Math.ceil(Math.sqrt(pixels / affordable))));
        this.isFirstPass = true;
        const { summary } = this.info;
        const isWhole = coarseness === 1 && summary.samples === 1;
        const isRefined = this.isRefined;
        if (!isRefined) await this.pass(coarseness, 1, !this.isMoving && isWhole);
        this.isFirstPass = false;
        if (this.isDirty || this.isMoving || this.stopped) continue;
        if (coarseness > 1 && !isRefined) await this.pass(1, 1, summary.samples === 1);
        if (this.isDirty || this.stopped || (summary.samples === 1 && !isRefined)) continue;
        await this.pass(1, summary.samples, true);
      }
    } catch (error) {
      this.emit('error', error instanceof Error ? error : new Error(String(error)));
    } finally {
      this.isRunning = false;
    }
  }

  private async pass(coarseness: number, samples: number, isLast: boolean): Promise<void> {
    const width = Math.ceil(this.canvas.width / coarseness);
    const height = Math.ceil(this.canvas.height / coarseness);
    const lightMap = this.lightsTurn ? undefined : this.eye?.lightMap();
    const isPreview = samples === 1 && !isLast;
    const request = {
      width, height, samples, output: this.wantedOutput, camera: Array.from(this.camera),
      ...(lightMap ? { lightMap: Array.from(lightMap) } : {}),
      ...(isPreview ? { noise: 0 } : {}),
    };
    const context = coarseness > 1 ? this.coarseContext(width, height) : this.context;
    const begin = performance.now();
    const deadline = samples === 1 || this.isRefined ? undefined : setTimeout(() => this.pause(), UNASKED_MS);
    const done = await this.pool.picture(request, { onTiles: (tiles, pixels) => put(context, tiles, pixels) });
    clearTimeout(deadline);
    const milliseconds = performance.now() - begin;
    const isPaused = this.stopped && !done;
    if (!done && !isPaused) return;
    if (coarseness > 1) this.context.drawImage(this.coarse, 0, 0, width * coarseness, height * coarseness);
    if (samples === 1) {
      this.samplesPerMs = 0.5 * (this.samplesPerMs + (width * height) / Math.max(milliseconds, 1));
    }
    this.emit('pass', { coarseness, samples, milliseconds, isLast, isPaused });
  }

  private coarseContext(width: number, height: number): CanvasRenderingContext2D {
    this.coarse.width = width;
    this.coarse.height = height;
    const context = this.coarse.getContext('2d');
    if (!context) throw new Error('no further canvas can be made');
    return context;
  }

  /** A point of the window in radii of the arcball: the middle of the canvas is 0 0, and y goes up. */
  private onBall(event: PointerEvent): [number, number] {
    const box = this.canvas.getBoundingClientRect();
    const radius = Math.min(box.width, box.height) / 2;
    return [
      (event.clientX - box.left - box.width / 2) / radius,
      (box.top + box.height / 2 - event.clientY) / radius,
    ];
  }

  /** Pointer and wheel: one finger turns, two move and zoom, a click is a click. */
  private listen(): void {
    const { canvas, pointers } = this;
    let pressed: { x: number; y: number } | undefined;
    let gesture: 'turn' | 'move' | undefined;
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
    };
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      const isMove = event.button !== 0 || event.shiftKey || pointers.size > 1;
      if (gesture === 'turn' && isMove) this.eye?.release();
      gesture = isMove ? 'move' : 'turn';
      pressed = isMove ? undefined : { x: event.clientX, y: event.clientY };
      if (gesture === 'turn') this.eye?.press(...this.onBall(event));
      canvas.focus({ preventScroll: true });
      event.preventDefault();
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before || !gesture) return;
      if (pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) <= CLICK_PX) return;
      pressed = undefined;
      const { height } = canvas.getBoundingClientRect();
      const wide = spread();
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (gesture === 'turn') {
        this.eye?.drag(...this.onBall(event));
      } else {
        const share = 1 / pointers.size;
        this.eye?.moveBy(share * (event.clientX - before.x), share * (event.clientY - before.y), height);
        if (wide > 0) this.eye?.magnify(spread() / wide || 1);
      }
      this.moved();
    });
    const up = (event: PointerEvent) => {
      if (!pointers.delete(event.pointerId)) return;
      if (gesture === 'turn') this.eye?.release();
      if (pressed) {
        const box = canvas.getBoundingClientRect();
        const x = ((event.clientX - box.left) * canvas.width) / box.width;
        const y = ((event.clientY - box.top) * canvas.height) / box.height;
        this.emit('click', { x, y });
      } else if (pointers.size === 0) {
        this.changed(false);
      }
      pressed = undefined;
      gesture = pointers.size > 0 ? 'move' : undefined;
    };
    canvas.addEventListener('pointerup', up);
    canvas.addEventListener('pointercancel', up);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      const notches = Math.max(-3, Math.min(3, -event.deltaY / (event.deltaMode === 0 ? 100 : 3)));
      this.eye?.magnify(WHEEL_STEP ** notches);
      this.moved();
    }, { passive: false });
  }
}

/** A camera whose narrower picture has the width of one with the scene's own aspect ratio. */
function widened(camera: Float64Array, own: number, aspect: number): Float64Array {
  const factor = own / aspect;
  if (!(factor > 1)) return camera;
  const wide = Float64Array.from(camera);
  const [degrees = 40, height = 0] = [camera[9], camera[10]];
  wide[9] = (360 / Math.PI) * Math.atan(factor * Math.tan((degrees * Math.PI) / 360));
  wide[10] = height * factor;
  return wide;
}

function put(context: CanvasRenderingContext2D, tiles: Uint32Array, pixels: Uint8ClampedArray<ArrayBuffer>): void {
  let at = 0;
  for (let i = 0; i < tiles.length; i += 4) {
    const [left = 0, top = 0, width = 0, height = 0] = tiles.subarray(i, i + 4);
    const length = 4 * width * height;
    context.putImageData(new ImageData(pixels.slice(at, at + length), width, height), left, top);
    at += length;
  }
}
