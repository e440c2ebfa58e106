/**
 * Exact superquadrics: scenes as text, ray traced pictures, ray queries and meshes, in the browser and in Node.
 *
 * @example
 * import { parse, render } from 'superegg';
 * const scene = await parse('prm egg\nexp 1 .9');
 * const { t } = scene.intersect(new Float64Array([0, 0, 5]), new Float64Array([0, 0, -1]));
 * const picture = await render('prm egg\nexp 1 .9', { width: 320, height: 240 });
 */

export { start, type EngineSource } from './engine.js';
export { blit, render, Superseded, WorkerPool, type PictureOptions } from './pool.js';
export type { Answers, Question, SceneInfo, Size, TestGrid } from './protocol.js';
export { intersect, mesh, parse, Scene } from './scene.js';
export type {
  FileNamed, Finding, FirstHit, Hits, Mesh, Output, PictureRequest, Pixels, SceneExtras, SceneSource, Summary,
} from './types.js';
