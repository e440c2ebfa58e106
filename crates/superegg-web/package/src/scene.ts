// A scene in this thread: text or file in, answers out.

import { engine, start } from './engine.js';
import type { Finding, FirstHit, Hits, Mesh, SceneSource, Summary } from './types.js';

/** A scene. `free` it when it is no longer needed, or let it be collected. */
export class Scene {
  /** The engine's own scene. */
  readonly inner: engine.Scene;

  private constructor(inner: engine.Scene) {
    this.inner = inner;
  }

  /** Reads a scene. The engine must have started. Throws if a file is of no known kind. */
  static of(source: SceneSource): Scene {
    if (typeof source === 'string') return new Scene(new engine.Scene(source));
    const inner = 'text' in source ? new engine.Scene(source.text) : engine.Scene.read(source.name, source.bytes);
    if (source.files) {
      const files = new engine.Files();
      for (const [name, bytes] of Object.entries(source.files)) files.put(name, bytes);
      inner.setFiles(files);
      files.free();
    }
    if (source.frame !== undefined) inner.setFrame(source.frame);
    return new Scene(inner);
  }

  /** The errors and warnings of the text; a line with an error is left out of the scene. */
  get findings(): Finding[] {
    return JSON.parse(this.inner.findings()) as Finding[];
  }

  /** How a file was read. */
  get notes(): string[] {
    return this.inner.notes();
  }

  get summary(): Summary {
    return JSON.parse(this.inner.summary()) as Summary;
  }

  /** The scene as text. */
  get text(): string {
    return this.inner.text();
  }

  /** Lower and upper corner of the box around it. */
  get bounds(): Float64Array | undefined {
    return this.inner.bounds();
  }

  /** The closest hits of rays; origins and directions have three numbers each. */
  intersect(origins: Float64Array, directions: Float64Array): Hits {
    const hits = this.inner.intersect(origins, directions);
    const { t, points, normals, primitives, ids } = hits;
    return { t, points, normals, primitives, ids, path: (ray) => hits.path(ray) };
  }

  /** The first hit of one ray, with the Newton steps to it. */
  firstHit(origin: Float64Array, direction: Float64Array): FirstHit | undefined {
    const hit = this.inner.firstHit(origin, direction);
    return hit === undefined ? undefined : (JSON.parse(hit) as FirstHit);
  }

  /** Whether each point is inside a shape: 1 or 0. */
  inside(points: Float64Array): Uint8Array {
    return this.inner.inside(points);
  }

  /** The triangles of all instances, at most `tolerance` from the exact surfaces, as a part of each instance's size. */
  mesh(tolerance = 1e-3): Mesh {
    const mesh = this.inner.mesh(tolerance);
    const { positions, normals, colors, indices, instanceOfTriangle, paths } = mesh;
    mesh.free();
    return { positions, normals, colors, indices, instanceOfTriangle, paths };
  }

  /** A file for another program; the ending decides the format: .stl, .glb, .ply, .obj, .pov, .csv, .vtp, .nrrd. */
  export(file: string, tolerance = 1e-3): Uint8Array<ArrayBuffer> {
    const written = this.inner.export(file, tolerance);
    const bytes = written.bytes as Uint8Array<ArrayBuffer>;
    written.free();
    return bytes;
  }

  free(): void {
    this.inner.free();
  }
}

/** Reads a scene; starts the engine of this thread if it has not started. */
export async function parse(source: SceneSource): Promise<Scene> {
  await start();
  return Scene.of(source);
}

/** The closest hits of rays with a scene. */
export async function intersect(source: SceneSource, origins: Float64Array, directions: Float64Array): Promise<Hits> {
  return (await parse(source)).intersect(origins, directions);
}

/** The triangles of a scene. */
export async function mesh(source: SceneSource, tolerance?: number): Promise<Mesh> {
  const scene = await parse(source);
  try {
    return scene.mesh(tolerance);
  } finally {
    scene.free();
  }
}
