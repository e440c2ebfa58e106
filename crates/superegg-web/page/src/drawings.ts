// The tests of the course and other drawings over the picture, and the hit of a click.

import type { FirstHit, Mesh, SceneInfo, TestGrid } from 'superegg';
import { canvas, complain, say, view } from './app';
import { byId, short } from './dom';
import { drawOverlay, type CastRay } from './overlay';
import { select } from './text';

/** The tolerance of the edges, as a part of each instance's size. */
const TOLERANCE = 1e-2;

const overlay = byId<HTMLCanvasElement>('overlay');
const shows = { axes: false, grid: false, outside: true, ray: false, edges: false, normals: false };
let grid: TestGrid | undefined;
let mesh: Mesh | undefined;
let cast: CastRay | undefined;

/** The extent of what is in sight: a wide floor or wall would make everything else small. */
function extent({ bounds }: SceneInfo): number {
  const b = bounds ?? [-1, -1, -1, 1, 1, 1];
  const { camera } = view;
  const sides = [0, 1, 2].map((i) => (b[i + 3] ?? 1) - (b[i] ?? -1));
  const distance = Math.hypot(...[0, 1, 2].map((i) => (camera[i] ?? 0) - (camera[i + 3] ?? 0)));
  return Math.min(Math.max(...sides), distance);
}

export function draw(): void {
  const { info } = view;
  if (!info) return;
  drawOverlay(overlay, {
    camera: view.camera,
    axes: shows.axes,
    lights: info.lights,
    size: extent(info),
    grid: shows.grid ? grid : undefined,
    showOutside: shows.outside,
    cast: shows.ray ? cast : undefined,
    mesh: shows.edges ? mesh : undefined,
    showNormals: shows.normals,
  });
}

/** Asks for what the drawings need and do not have. */
async function refresh(): Promise<void> {
  const { info } = view;
  try {
    if (shows.grid && !grid) grid = await view.pool.ask({ about: 'grid', camera: view.camera });
    if (shows.edges && !mesh) mesh = await view.pool.ask({ about: 'mesh', tolerance: TOLERANCE });
    if (shows.ray && !cast) await pick(canvas.width / 2, canvas.height / 2);
  } catch (error) {
    // Of a scene that was replaced nobody needs to know.
    if (info === view.info) complain(error);
  }
  draw();
}

async function pick(x: number, y: number): Promise<void> {
  const { width, height } = canvas;
  const { camera } = view;
  const hit = await view.pool.ask({ about: 'pick', camera, width, height, x, y }).catch(() => undefined);
  const point = (at: number): CastRay['origin'] => [camera[at] ?? 0, camera[at + 1] ?? 0, camera[at + 2] ?? 0];
  cast = { origin: point(0), hit, end: hit ? hit.point : point(3) };
  showHit(hit);
  select(hit?.primitive);
  draw();
}

function showHit(hit: FirstHit | undefined): void {
  const list = byId('hit');
  list.hidden = false;
  const row = (term: string, value: string) => [
    Object.assign(document.createElement('dt'), { textContent: term }),
    Object.assign(document.createElement('dd'), { textContent: value }),
  ];
  if (!hit) {
    list.replaceChildren(...row('ray', 'hits nothing'));
    say('the ray hits nothing');
    return;
  }
  const vector = (numbers: readonly number[]) => numbers.map((x) => short(x, 5)).join(' ');
  list.replaceChildren(
    ...row('t', short(hit.t, 8)),
    ...row('point', vector(hit.point)),
    ...row('normal', vector(hit.normal)),
    ...row('path', hit.path),
    ...row('steps', hit.steps === null ? 'isolated by bounds' : `${hit.steps} of Newton`),
  );
  say(`hit ${hit.path} at t ${short(hit.t, 6)}`);
}

const SWITCHES: Record<string, keyof typeof shows> = {
  ToggleIoTest: 'grid', ToggleIntersectTest: 'ray', ToggleWireframe: 'edges', ToggleNormals: 'normals',
  ToggleOutside: 'outside', ToggleAxes: 'axes',
};

/** Turns a drawing on or off by the name of its action. Returns whether it is one. */
export function toggle(action: string): boolean {
  const key = SWITCHES[action];
  if (!key) return false;
  shows[key] = !shows[key];
  document.querySelector(`[data-action="${action}"]`)?.setAttribute('aria-pressed', String(shows[key]));
  byId('view').classList.toggle('wire', shows.edges);
  void refresh();
  return true;
}

view.on('loaded', () => {
  grid = mesh = cast = undefined;
  byId('hit').hidden = true;
  void refresh();
});
view.on('camera', draw);
view.on('click', ({ x, y }) => void pick(x, y));
new ResizeObserver(draw).observe(overlay);
