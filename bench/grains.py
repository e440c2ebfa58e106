#!/usr/bin/env python3
"""Writes a LIGGGHTS text dump of N superquadrics: bench/grains.py N OUT.dump [random|row|same|concentric].

random: at random places in a cube, with random sizes and rotations and 64 pairs of blockiness (seeded), six digits
a number. The others are hard for builders of trees: equal spheres in a row of equal distances, in one place, or
around one centre with growing radii."""
import random
import sys

count, path = int(sys.argv[1]), sys.argv[2]
kind = sys.argv[3] if len(sys.argv) > 3 else "random"
numbers = random.Random(1)
powers = [(numbers.uniform(2, 12), numbers.uniform(2, 12)) for _ in range(64)]
spacing = count ** (-1 / 3)


def row(index):
    if kind == "random":
        position = [numbers.random() for _ in range(3)]
        quaternion = [numbers.gauss(0, 1) for _ in range(4)]
        length = sum(x * x for x in quaternion) ** 0.5
        radii = [spacing * numbers.uniform(0.2, 0.6) for _ in range(3)]
        velocity = [numbers.gauss(0, 0.1) for _ in range(3)]
        return position + velocity + radii + [x / length for x in quaternion] + list(numbers.choice(powers))
    position = [float(index) if kind == "row" else 0.0, 0.0, 0.0]
    radius = 1 + 1e-3 * index if kind == "concentric" else 0.4
    return position + [0.0] * 3 + [radius] * 3 + [1.0, 0.0, 0.0, 0.0, 2.0, 2.0]


with open(path, "w") as file:
    file.write(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n" + "0 1\n" * 3)
    file.write("ITEM: ATOMS id x y z vx vy vz shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2 \n")
    for index in range(count):
        file.write(f"{index + 1} " + " ".join(f"{x:.6g}" for x in row(index)) + " \n")
