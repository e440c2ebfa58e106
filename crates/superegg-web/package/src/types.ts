// The records that the engine returns.

/** An error or a warning about a text. */
export interface Finding {
  severity: 'error' | 'warning';
  /** A stable code, such as `unknown-name`. */
  code: string;
  message: string;
  /** How to correct it. */
  help: string | null;
  /** The line, counted from 1; 0 for the whole text. */
  line: number;
  /** The wrong columns, counted from 0 in UTF-16 units. */
  from: number;
  to: number;
}

/** What a scene has. */
export interface Summary {
  /** The object or primitive that is shown. */
  root: string | null;
  /** The number of instances, as text: it has no bound. */
  instances: string;
  /** The size and the samples per pixel that the scene sets for its picture. */
  width: number;
  height: number;
  samples: number;
  /** The frames that its keys make, from 0 to the last key; 0 without keys. */
  frames: number;
  /** The pictures that the scene names, of its surroundings and on its surfaces. */
  files: FileNamed[];
}

/** A file that a scene names. */
export interface FileNamed {
  name: string;
  /** Whether it was given. Without it surfaces and surroundings are plain. */
  given: boolean;
  /** Why it cannot be read. */
  fault: string | null;
}

/** The first hit of a ray. */
export interface FirstHit {
  /** The distance from the ray's origin, in world units. */
  t: number;
  point: [number, number, number];
  /** The outward unit normal. */
  normal: [number, number, number];
  /** Names from the root down, joined by `/`. */
  path: string;
  primitive: string;
  /** Newton steps to the hit; `null` for a shape that is not convex. */
  steps: number | null;
}

/** The closest hits of rays. Row i belongs to ray i. */
export interface Hits {
  /** In lengths of the direction; infinity for a miss. */
  t: Float64Array;
  /** Three numbers each; NaN for a miss. */
  points: Float64Array;
  normals: Float64Array;
  /** The index of the primitive; 4294967295 for a miss. */
  primitives: Uint32Array;
  /** The id of the instance; 0 for a miss. */
  ids: Uint32Array;
  /** The path of the instance of one ray. */
  path(ray: number): string | undefined;
}

/** Triangles of a scene, in the layout of three.js's BufferGeometry. */
export interface Mesh {
  positions: Float32Array;
  /** The normals of the exact surfaces. */
  normals: Float32Array;
  /** Linear colours of the vertices. */
  colors: Float32Array;
  /** Counter-clockwise from outside. */
  indices: Uint32Array;
  /** For each triangle the index of its instance in `paths`. */
  instanceOfTriangle: Uint32Array;
  paths: string[];
}

/** The quantity that a picture shows. */
export type Output = 'light' | 'normal' | 'depth' | 'albedo' | 'id' | 'steps' | 'occlusion';

/** A picture to render. What is left out is as the scene has it. */
export interface PictureRequest {
  width?: number;
  height?: number;
  /** Samples per pixel. */
  samples?: number;
  /** The noise threshold, 0 for none. */
  noise?: number;
  output?: Output;
  /** Position, target, up, field of view in degrees, and height of an orthographic picture or 0. */
  camera?: number[];
  /** The map of the lights, twelve numbers in columns. */
  lightMap?: number[];
}

/** A rendered picture. */
export interface Pixels {
  width: number;
  height: number;
  /** Red, green, blue and alpha of each pixel, row by row from the top left. */
  data: Uint8ClampedArray<ArrayBuffer>;
  /** The number of rays that were traced. */
  rays: number;
}

/** What goes with a scene. */
export interface SceneExtras {
  /**
   * The pictures that it names, by name: PNG, JPEG or Radiance for surfaces, Radiance for surroundings. Folders do not count
   * where a name has none of its own.
   */
  files?: Readonly<Record<string, Uint8Array>>;
  /** The frame of its keys; without one the scene is as without keys. */
  frame?: number;
}

/** What a scene is read from: a text, or a file of a scene or of another program. */
export type SceneSource =
  | string
  | ({ text: string } & SceneExtras)
  | ({ name: string; bytes: Uint8Array } & SceneExtras);
