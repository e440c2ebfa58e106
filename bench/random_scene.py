#!/usr/bin/env python3
"""A scene of N primitives, each of its own shape and colour, in a cube: python3 bench/random_scene.py N > scene.scn"""
import random
import sys

count = int(sys.argv[1])
random.seed(count)
side = 10.0
radius = 0.45 * side / count ** (1 / 3)
lines = []
for i in range(count):
    lines.append(f"primitive p{i}")
    lines.append(" setCoeff " + " ".join(f"{radius * random.uniform(0.4, 1):.5f}" for _ in range(3)))
    lines.append(f" setExponent {random.uniform(0.1, 2):.3f} {random.uniform(0.1, 2):.3f}")
    lines.append(" setColor " + " ".join(f"{random.random():.3f}" for _ in range(3)))
lines.append("object scene")
for i in range(count):
    lines.append(f" addPrimitive p{i}")
    axis = " ".join(f"{random.uniform(-1, 1):.3f}" for _ in range(3))
    lines.append(f" rotate {axis} {random.uniform(0, 360):.1f}")
    lines.append(" translate " + " ".join(f"{random.uniform(-side / 2, side / 2):.4f}" for _ in range(3)))
lines.append("camera 0 0 16 0 0 0 45")
print("\n".join(lines))
