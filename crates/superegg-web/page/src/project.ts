// From the world to the picture, as the engine's camera does it.

type Vector = [number, number, number];

const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const unit = (a: Vector): Vector => {
  const length = Math.sqrt(dot(a, a)) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** A point in the picture: pixels from the top left, and the depth along the line of sight. */
export interface Projected {
  x: number;
  y: number;
  depth: number;
}

/** A camera and the size of its picture. */
export class Projector {
  readonly position: Vector;
  readonly forward: Vector;
  private right: Vector;
  private up: Vector;
  private scale: number;
  private isParallel: boolean;

  constructor(camera: ArrayLike<number>, private width: number, private height: number) {
    const vector = (at: number): Vector => [camera[at] ?? 0, camera[at + 1] ?? 0, camera[at + 2] ?? 0];
    this.position = vector(0);
    this.forward = unit(minus(vector(3), this.position));
    this.right = unit(cross(this.forward, vector(6)));
    this.up = cross(this.right, this.forward);
    const ortho = camera[10] ?? 0;
    this.isParallel = ortho > 0;
    this.scale = height / (this.isParallel ? ortho : 2 * Math.tan(((camera[9] ?? 40) * Math.PI) / 360));
  }

  /** The point in the picture; `undefined` behind the camera. */
  at(point: Vector): Projected | undefined {
    const to = minus(point, this.position);
    const depth = dot(to, this.forward);
    if (depth <= 1e-9 && !this.isParallel) return undefined;
    const scale = this.isParallel ? this.scale : this.scale / depth;
    return { x: this.width / 2 + scale * dot(to, this.right), y: this.height / 2 - scale * dot(to, this.up), depth };
  }

  /** Pixels per world unit at a depth. */
  scaleAt(depth: number): number {
    return this.isParallel ? this.scale : this.scale / depth;
  }
}
