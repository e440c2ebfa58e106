// The widget in JupyterLab, with a kernel that has the package: $JUPYTER_LAB is its command. crates/superegg-python/check.sh runs it.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { launch, screens } from '../../page/test/browser.js';

const command = process.env.JUPYTER_LAB;
const needsJupyter = command ? {} : { skip: 'JUPYTER_LAB names no JupyterLab' };
const CELLS = [
  `import superegg as se
scene = se.Scene()
scene.add(se.Superquadric((1, 1, 1.3), (1, 0.7)), color="orange", name="egg")
board = se.Superquadric((2, 2, 0.15), (0.3, 0.3))
scene.add(board, position=(0, 0, -1.45), color="tan", name="board")
scene.look_at((4, -5, 3), up=(0, 0, 1), fov=36)
scene.add_light(se.SunLight((2, -3, 4)))
scene.set_sky((0.85, 0.9, 1))
view = scene.view(420, 300, where="browser", samples=4)
view`,
  'import math; print(view.hit.path, round(math.hypot(*view.camera.position), 6))',
  'view.camera = scene.camera',
];

function notebook(cells) {
  const code = (source, index) => ({ cell_type: 'code', id: `cell${index}`, execution_count: null, metadata: {}, outputs: [], source });
  const kernelspec = { display_name: 'Python 3', language: 'python', name: 'python3' };
  return JSON.stringify({ cells: cells.map(code), metadata: { kernelspec }, nbformat: 4, nbformat_minor: 5 });
}

const freePort = () => new Promise((resolve) => {
  const server = createServer().listen(0, '127.0.0.1', () => {
    const { port } = server.address();
    server.close(() => resolve(port));
  });
});

async function withLab(work) {
  const folder = mkdtempSync(join(tmpdir(), 'superegg-lab-'));
  const port = await freePort();
  writeFileSync(join(folder, 'a.ipynb'), notebook(CELLS));
  const env = { ...process.env, JUPYTER_CONFIG_DIR: join(folder, 'config'), JUPYTER_RUNTIME_DIR: join(folder, 'run') };
  const flags = ['--allow-root', '--no-browser', `--port=${port}`, '--ServerApp.port_retries=0', '--ServerApp.token=t', `--ServerApp.root_dir=${folder}`];
  const lab = spawn(command, flags, { env, stdio: 'ignore' });
  const ended = new Promise((resolve) => lab.on('exit', resolve));
  try {
    const address = `http://127.0.0.1:${port}`;
    for (let tries = 0; !(await fetch(`${address}/api?token=t`).catch(() => undefined))?.ok; tries += 1) {
      assert.ok(tries < 600 && lab.exitCode === null, 'JupyterLab does not start');
      await new Promise((resolve) => setTimeout(resolve, 200));
    }
    await work(`${address}/lab/tree/a.ipynb?token=t`);
  } finally {
    lab.kill();
    await ended;
    rmSync(folder, { recursive: true });
  }
}

test('a scene in JupyterLab: the picture, a click, a drag, and a camera from Python', needsJupyter, () => withLab(async (address) => {
  const browser = await launch();
  try {
    const page = await browser.newPage({ viewport: { width: 1080, height: 760 } });
    const errors = [];
    page.on('pageerror', (error) => errors.push(error.message));
    await page.goto(address);
    const run = async (cell) => {
      await page.locator('.jp-CodeCell .cm-content').nth(cell).click();
      await page.keyboard.press('Shift+Enter');
    };
    await page.locator('.jp-CodeCell .cm-content').first().waitFor({ timeout: 120_000 });
    // The kernel is there, and no question is open.
    await page.getByText(/Python 3.* \| Idle/).waitFor({ timeout: 120_000 });
    // JupyterLab asks whether it may fetch news.
    await page.getByRole('button', { name: 'No', exact: true }).click({ timeout: 10_000 }).catch(() => undefined);
    await run(0);
    const canvas = page.locator('.jp-OutputArea canvas');
    await page.locator('.jp-OutputArea canvas[data-pass="last"]').waitFor({ timeout: 120_000 });
    const picture = () => canvas.evaluate((element) => element.toDataURL());
    const home = await picture();
    await canvas.click({ position: { x: 210, y: 130 } });
    await page.getByText('model/egg').waitFor();
    const box = await canvas.boundingBox();
    await page.mouse.move(box.x + 210, box.y + 130);
    await page.mouse.down();
    await page.mouse.move(box.x + 260, box.y + 110, { steps: 5 });
    await page.mouse.up();
    await page.locator('.jp-OutputArea canvas[data-pass="last"]').waitFor();
    assert.notEqual(await picture(), home);
    await page.waitForTimeout(500);
    await run(1);
    await page.getByText('model/egg 7.071068').waitFor();
    const cells = await page.locator('.jp-Notebook').boundingBox();
    await page.screenshot({ path: join(screens, 'jupyterlab.png'), clip: { ...cells, height: 575 } });
    await run(2);
    for (let tries = 0; await picture() !== home; tries += 1) {
      assert.ok(tries < 100, 'the camera of Python is not shown');
      await page.waitForTimeout(100);
    }
    assert.deepEqual(errors, []);
  } catch (error) {
    await browser.contexts()[0]?.pages()[0]?.screenshot({ path: join(screens, 'jupyterlab-failed.png') });
    throw error;
  } finally {
    await browser.close();
  }
}));
