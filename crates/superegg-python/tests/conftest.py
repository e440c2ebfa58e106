"""Data for the tests: small files of other programs, made here."""

from __future__ import annotations

import numpy as np
import pytest

import superegg as se

DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
3
ITEM: BOX BOUNDS ff ff ff
-2 4
-2 2
-2 2
ITEM: ATOMS id type x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2 vx vy vz
7 1 0 0 0 .3 .2 .4 1 0 0 0 8 2 0 0 1
3 2 1 0 0 .3 .2 .4 0.7071068 0 0 0.7071068 2 8 0 2 0
5 1 2 0 0 .5 .5 .5 1 0 0 0 2 2 3 0 0
"""


@pytest.fixture
def dump(tmp_path):
    path = tmp_path / "grains.dump"
    path.write_text(DUMP)
    return path


@pytest.fixture
def superdec(tmp_path):
    path = tmp_path / "fits.npz"
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.savez(
        path,
        names=np.array(["chair"]),
        scale=np.array([[[1.0, 0.5, 0.25], [9, 9, 9]]], dtype=np.float32),
        rotation=np.array([[turn, np.eye(3)]], dtype=np.float32),
        translation=np.array([[[1.0, 2, 3], [0, 0, 0]]], dtype=np.float32),
        exponents=np.array([[[0.5, 1.5], [1, 1]]], dtype=np.float32),
        exist=np.array([[[0.9], [0.1]]], dtype=np.float32),
    )
    return path


@pytest.fixture
def cloud():
    """A thousand shapes of all kinds."""
    rng = np.random.default_rng(3)
    scene = se.Scene()
    scene.add_many(
        rng.uniform(-5, 5, (1000, 3)),
        rng.uniform(0.1, 0.4, (1000, 3)),
        rng.uniform(0.2, 2.0, (1000, 2)),
        rng.normal(size=(1000, 4)),
        colors=rng.uniform(size=(1000, 3)),
    )
    return scene
