// A scene as the BufferGeometry of three.js: `mesh` has the columns in its layout.

import {
  BufferAttribute, BufferGeometry, DirectionalLight, HemisphereLight, Mesh, MeshStandardMaterial, PerspectiveCamera, Scene, WebGLRenderer,
} from 'three';
import { mesh } from 'superegg';
import snowman from '../../../../scenes/snowman.scn?raw';

const { positions, normals, colors, indices } = await mesh(snowman, 1e-3);
const geometry = new BufferGeometry();
geometry.setAttribute('position', new BufferAttribute(positions, 3));
geometry.setAttribute('normal', new BufferAttribute(normals, 3));
geometry.setAttribute('color', new BufferAttribute(colors, 3));
geometry.setIndex(new BufferAttribute(indices, 1));
geometry.computeBoundingSphere();
const { center, radius } = geometry.boundingSphere!;

const scene = new Scene();
scene.add(new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, roughness: 0.6 })));
const sky = new HemisphereLight(0xffffff, 0x666666, 1.5);
sky.position.set(0, 0, 1);
scene.add(sky);
const sun = new DirectionalLight(0xffffff, 2);
sun.position.set(3, -4, 5);
scene.add(sun);

const canvas = document.querySelector('canvas')!;
const renderer = new WebGLRenderer({ canvas, antialias: true });
renderer.setClearColor(0xf2f1ef);
const camera = new PerspectiveCamera(35, 1, 0.01 * radius, 100 * radius);
// As in the scene.
camera.up.set(0, 0, 1);

function draw(time: number): void {
  const { clientWidth: width, clientHeight: height } = canvas;
  renderer.setSize(width, height, false);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  const angle = time / 4000;
  camera.position.set(Math.sin(angle), -Math.cos(angle), 0.3).multiplyScalar(3.4 * radius).add(center);
  camera.lookAt(center);
  renderer.render(scene, camera);
  document.documentElement.dataset.triangles = String(renderer.info.render.triangles);
  requestAnimationFrame(draw);
}
requestAnimationFrame(draw);
