#!/usr/bin/env bash
# binaryen 108 (npm; Debian 12 has it too) writes the export of a module's second table as that of the first one. wasm-opt so
# breaks each module of wasm-bindgen with reference types: its table of references becomes the table of functions, and
# starting it fails with "Table.set(): Argument 1 is invalid for table".
# Seen 2026-11: a module of 4 lines, read and written without any optimization.
# For us: crates/superegg-web/build.sh does without wasm-opt; the compressed module is no larger without the names of functions.
# usage: findings/binaryen_table_exports.sh   (needs Node.js with npm, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
npm install --silent --no-audit --no-fund --prefix "$work" binaryen@108.0.0
cat > "$work/two_tables.mjs" <<'JAVASCRIPT'
import binaryen from 'binaryen';

const text = `(module
  (table $functions 1 funcref)
  (table $references 1 externref)
  (export "references" (table $references)))`;
const module = binaryen.parseText(text);
module.setFeatures(binaryen.Features.All);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(module.emitBinary()));
let message = 'none';
try {
  exports.references.set(0, {});
} catch (error) {
  message = error.message;
}
console.log(`error: ${message}`);
if (!message.includes('invalid for table')) process.exit(1);
JAVASCRIPT
(cd "$work" && node two_tables.mjs)
echo "as before"
