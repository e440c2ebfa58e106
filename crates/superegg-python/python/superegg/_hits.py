"""The answers of ray queries."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from superegg import _superegg
from superegg._arrays import Floats, Shape

Bools = NDArray[np.bool_]


class ShapeHits:
    """The first hits of rays with one superquadric, as arrays of the rays' shape.

    Attributes
    ----------
    t : ndarray of float64, shape (...)
        The ray parameter, in lengths of the ray's direction; inf for a miss.
    position : ndarray of float64, shape (..., 3)
        The point of the hit; nan for a miss.
    normal : ndarray of float64, shape (..., 3)
        The outward unit normal; nan for a miss.
    uv : ndarray of float64, shape (..., 2)
        Longitude and latitude on the shape, in radians; nan for a miss.
    leaving : ndarray of bool, shape (...)
        Whether the ray leaves the shape there.
    """

    t: Floats
    position: Floats
    normal: Floats
    uv: Floats
    leaving: Bools

    def __init__(self, columns: tuple[Any, ...], shape: Shape) -> None:
        self.t = columns[0].reshape(shape)
        self.position = columns[1].reshape((*shape, 3))
        self.normal = columns[2].reshape((*shape, 3))
        self.uv = columns[3].reshape((*shape, 2))
        self.leaving = columns[4].reshape(shape)

    @property
    def hit(self) -> Bools:
        """Whether each ray hits, shape (...)."""
        return np.asarray(self.t < np.inf)

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        hits = int(np.count_nonzero(self.t < np.inf))
        return f"<{type(self).__name__}: {hits} hits of {self.t.size} rays>"


class Hits(ShapeHits):
    """The first hits of rays with a scene, as arrays of the rays' shape.

    The attributes of `ShapeHits`, and:

    Attributes
    ----------
    primitive : ndarray of int32, shape (...)
        The index of the primitive, for `Scene.primitive_name`; -1 for a miss.
    uv : ndarray of float64, shape (..., 2)
        As for `ShapeHits`, but nan unless ``uv=True`` was asked for.
    instance : ndarray of uint32, shape (...)
        The instance id, the same as in `Film.instance_id`; 0 for a miss.
    """

    primitive: NDArray[np.int32]
    instance: NDArray[np.uint32]

    def __init__(self, columns: tuple[Any, ...], shape: Shape) -> None:
        super().__init__(columns, shape)
        self.primitive = columns[5].reshape(shape)
        self.instance = columns[6].reshape(shape)
        # Once names are made, or the hits are copied or pickled: the names, and each ray's among them.
        self._named: tuple[list[str | None], NDArray[np.intp]] | None = None
        self._paths: _superegg.Paths | None = columns[7]

    def names(self) -> NDArray[np.object_]:
        """The names of the instances, such as ``grains/p17``, shape (...); ``None`` for a miss.

        Each instance is named once, so this takes little for many rays.
        """
        texts, which = self._names_and_rows()
        names = np.empty(len(texts), dtype=object)
        names[:] = texts
        return np.asarray(names[which].reshape(self.t.shape), dtype=object)

    def _names_and_rows(self) -> tuple[list[str | None], NDArray[np.intp]]:
        """The names of instances, and the one among them of each ray."""
        if self._named is None:
            assert self._paths is not None
            ids = self.instance.reshape(-1)
            _, first, rows = np.unique(ids, return_index=True, return_inverse=True)
            self._named = self._paths.names([int(ray) for ray in first]), rows
        return self._named

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_named": self._names_and_rows(), "_paths": None}


class Closest(NamedTuple):
    """The closest points of a surface.

    Attributes
    ----------
    position : ndarray of float64, shape (..., 3)
        The point of the surface.
    distance : ndarray of float64, shape (...)
        The signed distance to it: negative inside.
    error : ndarray of float64, shape (...)
        The proven error of the distance.
    """

    position: Floats
    distance: Floats
    error: Floats
