#!/usr/bin/env python3
"""A scene of N children in a cube: python3 bench/random_scene.py N [SHAPES] > scene.scn

Each child has a primitive of its own shape and colour, or one of SHAPES primitives, which is chosen at random."""
import random
import sys

count = int(sys.argv[1])
shapes = int(sys.argv[2]) if len(sys.argv) > 2 else count
random.seed(count)
side = 10.0
radius = 0.45 * side / count ** (1 / 3)
out = sys.stdout
for i in range(shapes):
    out.write(f"primitive p{i}\n")
    out.write(" setCoeff " + " ".join(f"{radius * random.uniform(0.4, 1):.5f}" for _ in range(3)) + "\n")
    out.write(f" setExponent {random.uniform(0.1, 2):.3f} {random.uniform(0.1, 2):.3f}\n")
    out.write(" setColor " + " ".join(f"{random.random():.3f}" for _ in range(3)) + "\n")
out.write("object scene\n")
for i in range(count):
    target = f"p{i}" if shapes == count else f"p{random.randrange(shapes)} c{i}"
    out.write(f" addPrimitive {target}\n")
    axis = " ".join(f"{random.uniform(-1, 1):.3f}" for _ in range(3))
    out.write(f" rotate {axis} {random.uniform(0, 360):.1f}\n")
    position = " ".join(f"{random.uniform(-side / 2, side / 2):.4f}" for _ in range(3))
    out.write(f" translate {position}\n")
out.write("camera 0 0 16 0 0 0 45\n")
