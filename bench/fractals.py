"""Writes scenes of fractals whose parts overlap into a folder. usage: bench/fractals.py FOLDER"""
import random
import sys
from pathlib import Path

TRUNK = "prm trunk\ncoeff .12 .12 .5\nexp 1 .3\nobj all\nap trunk\nxs 0 0 .5\n"
BALL = "prm ball\nexp 1 .5\ncoeff .3 .3 .3\nobj all\nap ball\n"
UP_Z = "up z\n"


def tree(count, scale, camera):
    """A trunk with copies of the whole tree around its tip."""
    text = TRUNK
    for i in range(count):
        text += f"ao all b{i}\nss {scale} {scale} {scale}\nrs 0 1 0 35\nrs 0 0 1 {360 / count * i}\nxs 0 0 1\n"
    return text + UP_Z + f"camera {camera} 45\n"


def snowflake():
    """A ball with half-size balls on its six sides."""
    text = "prm ball\nexp 1 1\nobj all\nap ball\n"
    for axis in range(3):
        for sign in (-1.5, 1.5):
            at = [0.0, 0.0, 0.0]
            at[axis] = sign
            text += f"ao all b{axis}{'m' if sign < 0 else 'p'}\nss .5 .5 .5\nxs {at[0]} {at[1]} {at[2]}\n"
    return text + UP_Z + "camera 2.9 -6.4 2.85 .39 .27 .35 45\n"


def cluster(count, scale):
    """A ball with smaller copies of the whole at random places."""
    places = random.Random(5)
    text = BALL
    for i in range(count):
        angle = places.uniform(0, 360)
        x, y, z = (places.uniform(-1, 1) for _ in range(3))
        text += f"ao all b{i}\nss {scale} {scale} {scale}\nrs 1 2 3 {angle:.1f}\nxs {x:.3f} {y:.3f} {z:.3f}\n"
    return text + UP_Z + "camera 2 -5.2 2.1 0 0 .2 45\n"


SCENES = {
    "tree_3x0.7": tree(3, 0.7, "1.3 -3.45 2.9 0 0 1.6"),
    "tree_3x0.75": tree(3, 0.75, "1.6 -4.2 3.4 0 0 1.8"),
    "tree_4x0.65": tree(4, 0.65, "1.2 -2.9 2.5 .1 0 1.5"),
    "tree_8x0.6": tree(8, 0.6, "1 -2.6 2.3 0 0 1.3"),
    "tree_2x0.95": tree(2, 0.95, "12 -26 14 2 0 6"),
    "snowflake": snowflake(),
    "cluster_5x0.6": cluster(5, 0.6),
    "cluster_20x0.5": cluster(20, 0.5),
    "two_of_scale_1": BALL + "ao all a\nrs 0 0 1 50\nxs .6 0 0\nao all b\nrs 1 0 0 70\nxs 0 .5 .3\n" + UP_Z + "camera 9 -20 8 1 0 1 45\n",
}

for name, text in SCENES.items():
    (Path(sys.argv[1]) / f"{name}.scn").write_text(text)
