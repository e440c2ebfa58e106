// The workers of a page: each has an engine and the scene, and renders one shard of a picture. A worker that does not
// answer in time is ended and replaced, so nothing that a scene costs can hold up the next one.

import { compiledModule, inNode } from './engine.js';
import type { Answers, FromWorker, Question, SceneInfo, Size, ToWorker } from './protocol.js';
import type { PictureRequest, Pixels, SceneSource } from './types.js';

/**
 * A new scene waits this long for a worker that is still busy with an old one; a new picture so much longer as the scene took to
 * load, which a successor would have to do again.
 */
const PATIENCE_MS = 40;
/** A slice of work between two looks for messages. */
const SLICE_MS = 12;

interface Thread {
  post(message: ToWorker): void;
  end(): void;
}

async function startThread(
  make: (() => Worker) | undefined,
  hear: (message: FromWorker) => void,
  failed: (message: string) => void,
): Promise<Thread> {
  if (inNode) {
    const threads = 'node:worker_threads';
    const { Worker: NodeWorker } = (await import(/* @vite-ignore */ threads)) as typeof import('node:worker_threads');
    const worker = new NodeWorker(new URL('./worker.js', import.meta.url));
    worker.on('message', hear);
    worker.on('error', (error) => failed(error.message));
    return { post: (message) => worker.postMessage(message), end: () => void worker.terminate() };
  }
  const worker = make?.() ?? new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  worker.onmessage = (event: MessageEvent<FromWorker>) => hear(event.data);
  worker.onerror = (event) => failed(event.message || 'its file could not be loaded');
  return { post: (message) => worker.postMessage(message), end: () => worker.terminate() };
}

/** A worker and what it is doing. */
interface Member {
  thread: Thread | undefined;
  /** Counts the threads of this member, so that the last words of an ended one are not heard. */
  life: number;
  isReady: boolean;
  /** Messages that wait for the engine. */
  waiting: ToWorker[];
  /** The files of scenes that it has, so that none is sent twice. */
  files: Map<string, Uint8Array>;
  /** The number of the last scene or picture that it has begun. */
  begun: number;
  /** Whether it has work that is not finished. A worker that has none is only slow to wake. */
  isBusy: boolean;
  /** The time that it took to load the scene. */
  loadMs: number;
}

/** A picture in the making. */
interface Job {
  number: number;
  request: PictureRequest;
  /** The members whose shard is not finished. */
  left: Set<number>;
  shards: number;
  rays: number;
  onTiles: (tiles: Uint32Array, pixels: Uint8ClampedArray<ArrayBuffer>) => void;
  resolve: (result: { rays: number } | undefined) => void;
  reject: (error: Error) => void;
}

interface Loading {
  number: number;
  resolve: (info: SceneInfo) => void;
  reject: (error: Error) => void;
}

interface Asked {
  member: number;
  resolve: (answer: never) => void;
  reject: (error: Error) => void;
}

/** How a picture is made. */
export interface PictureOptions {
  /** Called with tiles as they are finished: left, top, width and height of each, and their pixels one after the other. */
  onTiles?: (tiles: Uint32Array, pixels: Uint8ClampedArray<ArrayBuffer>) => void;
}

/** Workers with one scene. */
export class WorkerPool {
  readonly size: number;
  private members: Member[];
  private count = 0;
  private scene: { number: number; source: SceneSource; size: Size | undefined } | undefined;
  private loading: Loading | undefined;
  private job: Job | undefined;
  private questions = new Map<number, Asked>();
  private isClosed = false;
  private makeWorker: (() => Worker) | undefined;

  /**
   * Starts workers: by default as many as the machine has cores, at most 8. `worker` starts one where the package's own file
   * has no address, such as in a notebook.
   */
  constructor(size?: number, options: { worker?: (() => Worker) | undefined } = {}) {
    this.makeWorker = options.worker;
    const cores = (globalThis.navigator as Navigator | undefined)?.hardwareConcurrency ?? 2;
    this.size = Math.max(1, Math.min(size ?? cores, 8));
    this.members = Array.from({ length: this.size }, () => ({
      thread: undefined, life: 0, isReady: false, waiting: [], files: new Map(), begun: 0, isBusy: false, loadMs: 0,
    }));
    this.members.forEach((_, index) => this.restart(index));
  }

  /** Ends all workers. */
  close(): void {
    this.abandon();
    this.isClosed = true;
    for (const member of this.members) member.thread?.end();
    const ended = new Error('the workers have been ended');
    this.loading?.reject(ended);
    this.questions.forEach((question) => question.reject(ended));
    this.questions.clear();
  }

  /**
   * Loads a scene into all workers, in place of the one before. A scene whose default camera sees nothing of it is framed
   * for a picture of this size; by default its own.
   */
  load(source: SceneSource, size?: Size): Promise<SceneInfo> {
    this.abandon();
    this.loading?.reject(new Superseded());
    const number = this.next();
    this.scene = { number, source, size };
    const loaded = new Promise<SceneInfo>((resolve, reject) => {
      this.loading = { number, resolve, reject };
    });
    for (const [index, member] of this.members.entries()) {
      // Files are sent once, so they go on waiting.
      member.waiting = member.waiting.filter((message) => message.kind === 'file');
      this.postScene(index);
    }
    this.replaceLate(number);
    return loaded;
  }

  /**
   * Renders a picture of the loaded scene, in place of the one in the making. Resolves to `undefined` if another one takes
   * its place.
   */
  picture(request: PictureRequest, options: PictureOptions = {}): Promise<{ rays: number } | undefined> {
    this.abandon();
    const number = this.next();
    // Depth and steps are coloured by their range in the whole picture.
    const shards = request.output === 'depth' || request.output === 'steps' ? 1 : this.size;
    const left = new Set(Array.from({ length: shards }, (_, index) => index));
    const made = new Promise<{ rays: number } | undefined>((resolve, reject) => {
      const onTiles = options.onTiles ?? (() => undefined);
      this.job = { number, request, left, shards, rays: 0, onTiles, resolve, reject };
    });
    left.forEach((index) => this.postPicture(index));
    this.replaceLate(number);
    return made;
  }

  /** Gives up the picture in the making; its promise resolves to `undefined`. */
  abandon(): void {
    const job = this.job;
    if (!job) return;
    this.job = undefined;
    for (const [index, member] of this.members.entries()) {
      member.waiting = member.waiting.filter((message) => message.kind !== 'picture');
      this.post(index, { kind: 'cancel' });
    }
    job.resolve(undefined);
  }

  /** Asks a worker about the loaded scene. */
  ask<Q extends Question>(question: Q): Promise<Answers[Q['about']]> {
    const id = this.next();
    const member = 0;
    const answer = new Promise<Answers[Q['about']]>((resolve, reject) => {
      this.questions.set(id, { member, resolve: resolve as (answer: never) => void, reject });
    });
    this.post(member, { kind: 'ask', id, question });
    return answer;
  }

  private next(): number {
    this.count += 1;
    return this.count;
  }

  private post(index: number, message: ToWorker): void {
    const member = this.members[index];
    if (!member) return;
    if (member.isReady) member.thread?.post(message);
    else member.waiting.push(message);
  }

  private postScene(index: number): void {
    const member = this.members[index];
    if (!member || !this.scene) return;
    const { number, source, size } = this.scene;
    const { files = {}, ...bare } = typeof source === 'string' ? { text: source } : source;
    for (const name of member.files.keys()) {
      if (!(name in files)) member.files.delete(name);
    }
    for (const [name, bytes] of Object.entries(files)) {
      if (member.files.get(name) === bytes) continue;
      member.files.set(name, bytes);
      this.post(index, { kind: 'file', name, bytes });
    }
    this.post(index, { kind: 'scene', number, source: bare, files: Object.keys(files), size });
  }

  private postPicture(index: number): void {
    if (!this.job?.left.has(index)) return;
    const { number, request, shards } = this.job;
    this.post(index, { kind: 'picture', number, request, shard: `${index + 1}/${shards}`, slice: SLICE_MS });
  }

  /** Ends and replaces workers that are busy with something else and do not begin a scene or picture in time. */
  private replaceLate(number: number): void {
    const isScene = this.scene?.number === number;
    for (const [index, member] of this.members.entries()) {
      if (!member.isBusy || !(isScene || this.job?.left.has(index))) continue;
      const { life } = member;
      setTimeout(() => {
        const isWanted = this.scene?.number === number || this.job?.number === number;
        const isLate = member.isBusy && member.begun < number && member.life === life;
        if (!this.isClosed && isWanted && isLate) this.restart(index);
      }, isScene ? PATIENCE_MS : PATIENCE_MS + member.loadMs);
    }
  }

  /** Starts a worker, in place of the one before, with the scene and its shard of the picture. */
  private restart(index: number): void {
    const member = this.members[index];
    if (!member || this.isClosed) return;
    member.thread?.end();
    this.refuse(index, new Error('the worker was replaced'));
    member.life += 1;
    Object.assign(member, { thread: undefined, isReady: false, waiting: [], files: new Map(), begun: 0, isBusy: false });
    const { life } = member;
    const isCurrent = () => !this.isClosed && member.life === life;
    const hear = (message: FromWorker) => isCurrent() && this.hear(index, member, message);
    const failed = (message: string) => isCurrent() && this.failed(index, member, message);
    const begin = async () => {
      const [module, thread] = await Promise.all([compiledModule(), startThread(this.makeWorker, hear, failed)]);
      if (!isCurrent()) return thread.end();
      member.thread = thread;
      thread.post({ kind: 'module', module });
    };
    begin().catch((error: unknown) => failed(error instanceof Error ? error.message : String(error)));
    this.postScene(index);
    this.postPicture(index);
  }

  /** A worker has crashed: what it was asked fails, and a new one starts, without the scene that it could not bear. */
  private failed(index: number, member: Member, message: string): void {
    const error = new Error(`the engine stopped: ${message}`);
    const { loading, job } = this;
    this.loading = this.job = this.scene = undefined;
    loading?.reject(error);
    job?.reject(error);
    this.refuse(index, error);
    // An engine that could not even start would fail for ever.
    if (member.isReady) this.restart(index);
  }

  private refuse(index: number, error: Error): void {
    for (const [id, question] of this.questions) {
      if (question.member !== index) continue;
      this.questions.delete(id);
      question.reject(error);
    }
  }

  private hear(index: number, member: Member, message: FromWorker): void {
    const { loading, job } = this;
    switch (message.kind) {
      case 'ready':
        member.isReady = true;
        for (const waiting of member.waiting.splice(0)) member.thread?.post(waiting);
        break;
      case 'begun':
        member.begun = message.number;
        member.isBusy = true;
        break;
      case 'idle':
        member.isBusy = false;
        break;
      case 'loaded':
        member.isBusy = false;
        member.loadMs = message.milliseconds;
        if (loading?.number === message.number && index === 0) {
          this.loading = undefined;
          loading.resolve(message.info);
        }
        break;
      case 'tiles':
        if (job?.number === message.number) job.onTiles(message.tiles, message.pixels);
        break;
      case 'done':
        member.isBusy = false;
        if (job?.number !== message.number || !job.left.delete(index)) break;
        job.rays += message.rays;
        if (job.left.size > 0) break;
        this.job = undefined;
        job.resolve({ rays: job.rays });
        break;
      case 'failed': {
        member.isBusy = false;
        const error = new Error(message.message);
        if (loading?.number === message.number) {
          this.loading = undefined;
          loading.reject(error);
        } else if (job?.number === message.number) {
          this.job = undefined;
          job.reject(error);
        }
        break;
      }
      case 'answer':
      case 'refused': {
        const question = this.questions.get(message.id);
        this.questions.delete(message.id);
        if (message.kind === 'answer') question?.resolve(message.answer as never);
        else question?.reject(new Error(message.message));
      }
    }
  }
}

/** The error of a scene that another one replaced before it was loaded. */
export class Superseded extends Error {
  constructor() {
    super('another scene has taken its place');
  }
}

/** Renders a picture of a scene on workers of its own. */
export async function render(
  source: SceneSource,
  request: PictureRequest & { workers?: number } = {},
): Promise<Pixels> {
  const { workers, ...picture } = request;
  const pool = new WorkerPool(workers);
  try {
    const given: Size | undefined = picture.width && picture.height ? [picture.width, picture.height] : undefined;
    const { summary, camera } = await pool.load(source, given);
    const width = picture.width ?? summary.width;
    const height = picture.height ?? summary.height;
    const data = new Uint8ClampedArray(4 * width * height);
    const wanted = { ...picture, width, height, camera: picture.camera ?? Array.from(camera) };
    const done = await pool.picture(wanted, { onTiles: (tiles, pixels) => blit(data, width, tiles, pixels) });
    return { width, height, data, rays: done?.rays ?? 0 };
  } finally {
    pool.close();
  }
}

/** Copies tiles into a picture of this width. */
export function blit(data: Uint8ClampedArray, width: number, tiles: Uint32Array, pixels: Uint8ClampedArray): void {
  let at = 0;
  for (let i = 0; i < tiles.length; i += 4) {
    const [left = 0, top = 0, columns = 0, rows = 0] = tiles.subarray(i, i + 4);
    for (let row = 0; row < rows; row += 1) {
      data.set(pixels.subarray(at, at + 4 * columns), 4 * ((top + row) * width + left));
      at += 4 * columns;
    }
  }
}
