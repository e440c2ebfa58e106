// What is drawn over the picture: axes and lights, the inside-outside test, the intersection test, edges.

import type { FirstHit, Mesh, TestGrid } from 'superegg';
import { Projector } from './project';

/** More edges than this are thinned out. */
const MOST_EDGES = 40_000;
/** The radius of a mark of the inside-outside test, in steps of the grid. */
const MARK = 0.09;

/** A ray that was cast, and its hit. */
export interface CastRay {
  origin: [number, number, number];
  hit: FirstHit | undefined;
  end: [number, number, number];
}

/** What is to be seen. */
export interface OverlayState {
  camera: ArrayLike<number>;
  axes: boolean;
  lights: ArrayLike<number>;
  size: number;
  grid: TestGrid | undefined;
  showOutside: boolean;
  cast: CastRay | undefined;
  mesh: Mesh | undefined;
  showNormals: boolean;
}

type Point = [number, number, number];

const triple = (numbers: ArrayLike<number>, at: number): Point => [
  numbers[at] ?? 0, numbers[at + 1] ?? 0, numbers[at + 2] ?? 0,
];

export function drawOverlay(canvas: HTMLCanvasElement, state: OverlayState): void {
  const box = canvas.getBoundingClientRect();
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(box.width * ratio);
  canvas.height = Math.round(box.height * ratio);
  const context = canvas.getContext('2d');
  if (!context) return;
  context.scale(ratio, ratio);
  context.lineCap = 'round';
  const projector = new Projector(state.camera, box.width, box.height);
  if (state.mesh) drawEdges(context, projector, state.mesh, state.showNormals, state.size);
  if (state.axes) drawAxes(context, projector, state);
  if (state.grid) drawGrid(context, projector, state.grid, state.showOutside);
  if (state.cast) drawCast(context, projector, state.cast, state.size);
}

function line(context: CanvasRenderingContext2D, projector: Projector, from: Point, to: Point): void {
  const a = projector.at(from);
  const b = projector.at(to);
  if (!a || !b) return;
  context.beginPath();
  context.moveTo(a.x, a.y);
  context.lineTo(b.x, b.y);
  context.stroke();
}

function dot(context: CanvasRenderingContext2D, projector: Projector, at: Point, radius: number): void {
  const point = projector.at(at);
  if (!point) return;
  context.beginPath();
  context.arc(point.x, point.y, radius, 0, 2 * Math.PI);
  context.fill();
}

function drawAxes(context: CanvasRenderingContext2D, projector: Projector, { size, lights }: OverlayState): void {
  const length = 0.6 * size;
  const ends: [Point, string, string][] = [
    [[length, 0, 0], '#e5484d', 'x'], [[0, length, 0], '#3fa55b', 'y'], [[0, 0, length], '#3f7de0', 'z'],
  ];
  context.lineWidth = 2;
  context.font = '600 12px system-ui, sans-serif';
  for (const [end, color, name] of ends) {
    context.strokeStyle = context.fillStyle = color;
    line(context, projector, [0, 0, 0], end);
    const tip = projector.at(end);
    if (tip) context.fillText(name, tip.x + 5, tip.y + 4);
  }
  for (let at = 0; at + 2 < lights.length; at += 3) {
    context.fillStyle = '#f2c14e';
    dot(context, projector, triple(lights, at), 4);
  }
}

function drawGrid(
  context: CanvasRenderingContext2D, projector: Projector, { points, inside, step }: TestGrid, outside: boolean,
): void {
  const marks = Array.from(inside, (isInside, i) => ({ isInside, at: projector.at(triple(points, 3 * i)) }));
  // From far to near.
  marks.sort((a, b) => (b.at?.depth ?? 0) - (a.at?.depth ?? 0));
  for (const { isInside, at } of marks) {
    if (!at || !(isInside || outside)) continue;
    context.fillStyle = isInside ? '#ff2b22' : '#4d80ff38';
    context.beginPath();
    context.arc(at.x, at.y, Math.max(1, MARK * step * projector.scaleAt(at.depth)), 0, 2 * Math.PI);
    context.fill();
  }
}

function drawCast(context: CanvasRenderingContext2D, projector: Projector, cast: CastRay, size: number): void {
  context.lineWidth = 2;
  context.strokeStyle = '#ffd92e';
  line(context, projector, cast.origin, cast.end);
  if (!cast.hit) return;
  const { point, normal } = cast.hit;
  const tip = point.map((x, i) => x + 0.25 * size * (normal[i] ?? 0)) as Point;
  context.strokeStyle = context.fillStyle = '#25d07a';
  line(context, projector, point, tip);
  context.strokeStyle = '#0008';
  context.lineWidth = 1;
  dot(context, projector, point, 5);
  context.stroke();
}

function drawEdges(
  context: CanvasRenderingContext2D, projector: Projector, mesh: Mesh, normals: boolean, size: number,
): void {
  const { positions, indices } = mesh;
  const every = Math.max(1, Math.ceil(indices.length / MOST_EDGES));
  const style = getComputedStyle(document.documentElement);
  context.strokeStyle = style.getPropertyValue('--text');
  context.globalAlpha = 0.55;
  context.lineWidth = 0.6;
  context.beginPath();
  for (let at = 0; at + 2 < indices.length; at += 3 * every) {
    for (const [from, to] of [[0, 1], [1, 2], [2, 0]] as const) {
      const [i = 0, j = 0] = [indices[at + from], indices[at + to]];
      // Each edge belongs to two triangles.
      if (i > j && every === 1) continue;
      const a = projector.at(triple(positions, 3 * i));
      const b = projector.at(triple(positions, 3 * j));
      if (!a || !b) continue;
      context.moveTo(a.x, a.y);
      context.lineTo(b.x, b.y);
    }
  }
  context.stroke();
  if (normals) {
    context.strokeStyle = '#25d07a';
    const few = Math.max(3, 3 * Math.ceil(positions.length / 3 / 5000));
    for (let at = 0; at + 2 < positions.length; at += few) {
      const from = triple(positions, at);
      line(context, projector, from, from.map((x, i) => x + 0.06 * size * (mesh.normals[at + i] ?? 0)) as Point);
    }
  }
  context.globalAlpha = 1;
}
