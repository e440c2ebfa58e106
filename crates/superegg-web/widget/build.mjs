// Builds the widget of notebooks: one script with the source of its worker in it, and the compressed module beside it. A notebook
// has no server for further files: both come from Python.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { build } from 'rolldown';

const path = (name) => fileURLToPath(new URL(name, import.meta.url));

/** The text of a bundled script. */
async function bundle(input, plugins = []) {
  const { output } = await build({ input, plugins, write: false, platform: 'browser', output: { format: 'esm', minify: true } });
  if (output.length !== 1) throw new Error(`expected one script of ${input}, found ${output.length} files`);
  return output[0].code;
}

const worker = await bundle(path('../package/dist/worker.js'));
const embedded = {
  name: 'worker',
  resolveId: (id) => (id === 'virtual:worker' ? id : null),
  load: (id) => (id === 'virtual:worker' ? `export default ${JSON.stringify(worker)}` : null),
};
mkdirSync(path('dist'), { recursive: true });
writeFileSync(path('dist/widget.js'), await bundle(path('src/widget.ts'), [embedded]));
writeFileSync(path('dist/superegg.wasm.gz'), gzipSync(readFileSync(path('../package/engine/superegg_bg.wasm')), { level: 9 }));
