// The widget of notebooks: a scene of Python, ray traced in the browser, that a drag turns.

import { SceneView, keyAction, modestWorkers } from 'superegg/view';
import workerText from 'virtual:worker';
import { sourceOf, type Model } from './model';
import { startEngine } from './module';

/** Python hears of a camera in motion this often. */
const CAMERA_MS = 100;

/** Shows the model in an element. Returns how to end it. */
function render({ model, el }: { model: Model; el: HTMLElement }): () => void {
  const { frame, canvas, note } = elements();
  el.append(frame);
  const script = URL.createObjectURL(new Blob([workerText], { type: 'text/javascript' }));
  let view: SceneView | undefined;
  let isEnded = false;
  let telling: ReturnType<typeof setTimeout> | undefined;

  const say = (text: string) => {
    note.textContent = text;
    note.hidden = text === '';
  };
  const fail = (error: unknown) => {
    const text = error instanceof Error ? error.message : String(error);
    say(text);
    model.set('note', text);
    model.save_changes();
  };
  const resize = () => {
    const [width, height] = model.get('size');
    frame.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  };
  const tellCamera = () => {
    telling = undefined;
    if (!view) return;
    model.set('camera', Array.from(view.camera));
    model.save_changes();
  };
  /** Takes over a camera that Python, or another view of the model, has set. */
  const takeCamera = () => {
    const wanted = model.get('camera');
    if (!view?.info || !wanted || telling !== undefined) return;
    const { camera } = view;
    if (wanted.some((value, index) => value !== camera[index])) view.camera = Float64Array.from(wanted);
  };
  const showScene = async () => {
    const isFirst = !view?.info;
    try {
      const info = await view?.show(sourceOf(model), { keepView: true });
      if (!info) return;
      const error = info.findings.find((finding) => finding.severity === 'error');
      const missing = info.summary.files.filter((file) => !file.given).map((file) => `'${file.name}' is missing`);
      const faults = info.summary.files.flatMap((file) => file.fault ?? []);
      const text = [error ? `line ${error.line}: ${error.message}` : [], faults, missing].flat().join('; ');
      say(text);
      model.set('note', text);
      // A view that is shown later, or again, begins with the camera of the model.
      if (isFirst && model.get('camera')) takeCamera();
      else tellCamera();
      model.save_changes();
    } catch (error) {
      fail(error);
    }
  };
  const pick = async (x: number, y: number) => {
    if (!view) return;
    const { camera } = view;
    const { width, height } = canvas;
    const hit = await view.pool.ask({ about: 'pick', camera, width, height, x, y });
    say(hit ? `t ${Number(hit.t.toPrecision(6))}  ${hit.path}` : 'no hit');
    model.set('hit', hit ?? null);
    model.save_changes();
  };

  const begin = async () => {
    say('starting ...');
    await startEngine(model);
    if (isEnded) return;
    view = new SceneView(canvas, {
      workers: modestWorkers(),
      worker: () => new Worker(script, { type: 'module' }),
    });
    view.output = model.get('output');
    view.on('error', fail);
    view.on('camera', () => {
      telling ??= setTimeout(tellCamera, CAMERA_MS);
    });
    view.on('click', ({ x, y }) => void pick(x, y).catch(fail));
    view.on('pass', ({ isLast }) => {
      canvas.dataset.pass = isLast ? 'last' : 'first';
    });
    view.on('begun', () => {
      canvas.dataset.pass = 'begun';
    });
    await showScene();
  };
  const changeOutput = () => {
    if (view) view.output = model.get('output');
  };
  canvas.addEventListener('keydown', (event) => {
    const action = keyAction(event);
    if (!action || !view?.act(action)) return;
    event.preventDefault();
    // Arrows would also select another cell.
    event.stopPropagation();
  });
  const heard: [string, () => void][] = [
    ['change:text', () => void showScene()], ['change:binary', () => void showScene()], ['change:files', () => void showScene()],
    ['change:frame', () => void showScene()], ['change:size', resize], ['change:output', changeOutput], ['change:camera', takeCamera],
  ];
  heard.forEach(([event, hear]) => model.on(event, hear));
  resize();
  begin().catch(fail);
  return () => {
    isEnded = true;
    heard.forEach(([event, hear]) => model.off(event, hear));
    clearTimeout(telling);
    view?.close();
    URL.revokeObjectURL(script);
  };
}

/** The picture with its line of text, in an element of its own: notebooks set the width of theirs. */
function elements(): { frame: HTMLElement; canvas: HTMLCanvasElement; note: HTMLElement } {
  const frame = document.createElement('div');
  const canvas = document.createElement('canvas');
  const note = document.createElement('div');
  Object.assign(canvas.style, { display: 'block', width: '100%', touchAction: 'none', cursor: 'grab', outlineOffset: '-2px' });
  Object.assign(note.style, {
    position: 'absolute', inset: 'auto 0 0 0', padding: '2px 8px', font: '12px/1.5 system-ui, sans-serif',
    color: '#fff', background: '#000a', whiteSpace: 'pre-wrap', pointerEvents: 'none',
  });
  Object.assign(frame.style, { position: 'relative', maxWidth: '100%', overflow: 'hidden' });
  canvas.tabIndex = 0;
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', 'A ray traced scene. Arrow keys turn it, plus and minus zoom, Home returns to its camera.');
  note.setAttribute('role', 'status');
  frame.append(canvas, note);
  return { frame, canvas, note };
}

export default { render };
