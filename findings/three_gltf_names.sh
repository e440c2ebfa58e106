#!/usr/bin/env bash
# three.js r187 (npm, GLTFLoader) takes the characters [ ] . : / out of node names, since its animations use them as
# separators, and numbers names that become equal. Two nodes with the valid, different glTF names "a/bc" and "ab/c" arrive
# as "abc" and "abc_1", and nothing is said. So names that are paths, as modellers write them, cannot be looked up by
# getObjectByName, and which of the two is "abc" depends on the order of nodes. The name of the file is kept in userData.name.
# Seen 2026-11: name "abc", userData.name "a/bc"; name "abc_1", userData.name "ab/c".
# For us: docs/formats.md says where to find the path of an instance of our .glb in three.js.
# usage: findings/three_gltf_names.sh   (needs node 18 or newer with npm, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent three@0.187 >/dev/null
cat > names.mjs <<'JS'
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
globalThis.self = globalThis;
const scene = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0, 1] }],
    nodes: [{ name: 'a/bc' }, { name: 'ab/c' }],
};
new GLTFLoader().parse(JSON.stringify(scene), '', (gltf) => {
    const found = gltf.scene.children.map((node) => [node.name, node.userData.name]);
    found.forEach(([name, own]) => console.log(`name "${name}", userData.name "${own}"`));
    const before = JSON.stringify([['abc', 'a/bc'], ['abc_1', 'ab/c']]);
    if (JSON.stringify(found) !== before) throw new Error('the names are others now');
    if (gltf.scene.getObjectByName('a/bc') !== undefined) throw new Error('the path is found now');
    console.log('as before');
}, (error) => { throw error; });
JS
node names.mjs
