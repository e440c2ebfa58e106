"""Calls that the type checkers read: a user's code under strict rules."""

from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import superegg as se


def render(path: str) -> NDArray[np.float32]:
    scene = se.load(path, convention="superdec", color_by="id")
    assert_type(scene.intersect([0, 0, 0], np.ones((4, 3), np.float32)).t, NDArray[np.float64])
    film = scene.render(80, 60, samples=4, progress=True)
    film.save("a.png")
    assert_type(film.instance_id, NDArray[np.uint32])
    return film.color


def build(scene: se.Scene) -> str:
    shape = se.Superquadric((1, 1, 2), exponents=(0.5, 1))
    scene.add_light(se.SunLight((0, 0, 1)))
    scene.add_many(np.zeros((4, 3)), 1.0, ids=range(4), material=se.Material(color="red"))
    assert_type(shape.closest_point([0, 0, 3]).distance, NDArray[np.float64])
    assert_type(shape.mesh().faces, NDArray[np.uint32])
    assert_type(se.fit(shape.sample_surface(100)[0]).residuals([0, 0, 1]).distance, NDArray[np.float64])
    return scene.add(shape, position=(0, 0, 1), color=(1, 0, 0))
