// The scenes to begin with. Their texts are those of the gallery.

import colourBleeding from '../../../../scenes/colour_bleeding.scn?raw';
import craneArm from '../../../../scenes/crane_arm.scn?raw';
import city from '../../../../scenes/city.scn?raw';
import exponentGrid from '../../../../scenes/exponent_grid.scn?raw';
import fiveSolids from '../../../../scenes/five_solids.scn?raw';
import fractalTree from '../../../../scenes/fractal_tree.scn?raw';
import glassLens from '../../../../scenes/glass_lens.scn?raw';
import snowman from '../../../../scenes/snowman.scn?raw';
import sphereFlake from '../../../../scenes/sphere_flake.scn?raw';
import stars from '../../../../scenes/stars.scn?raw';
import superegg from '../../../../scenes/superegg.scn?raw';
import arm from './scenes/arm.scn?raw';
import welcome from './scenes/welcome.scn?raw';

export const WELCOME = welcome;

/** Title, name in links (`?scene=`) and text. */
export const EXAMPLES: readonly { title: string; name: string; text: string }[] = [
  { title: 'Welcome', name: 'welcome', text: welcome },
  { title: 'One superquadric', name: 'one', text: 'primitive egg\ncoeff 1 1 1.3\nexp 1 .8\n' },
  { title: 'Cube, cylinder, sphere, octahedron, star', name: 'five_solids', text: fiveSolids },
  { title: 'All exponents', name: 'exponent_grid', text: exponentGrid },
  { title: 'Robot arm', name: 'crane_arm', text: craneArm },
  { title: 'An arm that moves', name: 'arm', text: arm },
  { title: 'Snowman', name: 'snowman', text: snowman },
  { title: 'Superegg', name: 'superegg', text: superegg },
  { title: 'Stars', name: 'stars', text: stars },
  { title: 'City', name: 'city', text: city },
  { title: 'Fractal tree', name: 'fractal_tree', text: fractalTree },
  { title: 'Sphere flake', name: 'sphere_flake', text: sphereFlake },
  { title: 'Glass lens', name: 'glass_lens', text: glassLens },
  { title: 'Path traced room', name: 'colour_bleeding', text: colourBleeding },
];

/** Scenes of the gallery that are fetched when they are chosen. */
export const GALLERY: readonly { title: string; name: string }[] = [
  { title: 'Brass and glass, path traced', name: 'brass_and_glass' },
  { title: 'Chess through a lens', name: 'chess' },
  { title: 'Coral', name: 'coral' },
  { title: 'Nest', name: 'nest' },
  { title: 'Spiral', name: 'spiral' },
  { title: 'Still life', name: 'still_life' },
  { title: 'Sunset', name: 'sunset' },
];
