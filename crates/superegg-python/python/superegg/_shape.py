"""One superquadric: its geometry on arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from superegg import _superegg
from superegg._arrays import Floats, column, common_shape, count, floats, number, points, rays
from superegg._arrays import threads as threads_
from superegg._conventions import convention_of
from superegg._hits import Bools, Closest, ShapeHits
from superegg._meshes import Mesh


class Area(NamedTuple):
    """A surface area and its proven error."""

    value: float
    error: float


class Superquadric:
    """A superquadric centred at the origin, its axes along x, y and z.

    The surface is ``((x/a)^(2/e) + (y/b)^(2/e))^(e/n) + (z/c)^(2/n) = 1``.

    Parameters
    ----------
    radii : array_like, shape (3,) or a number
        The semi-axes a, b, c, above 0.
    exponents : array_like, shape (2,), default (1, 1)
        e shapes the section in the xy plane, n the profile along z: 1 is round, near 0 square,
        2 pointed, above 2 a star.
    convention : str, optional
        Another program's convention for both, such as ``"liggghts"`` or ``"ems"``: see
        `superegg.CONVENTIONS`.

    Raises
    ------
    ValueError
        Semi-axes or exponents that make no superquadric.

    Examples
    --------
    >>> import superegg as se
    >>> egg = se.Superquadric((1, 1, 1.3), (1, 0.9))
    >>> egg.inside([[0, 0, 1.2], [0, 0, 1.4]])
    array([ True, False])
    >>> se.Superquadric((1, 1, 2), (8, 2), convention="liggghts")  # n = 2/8, e = 2/2
    Superquadric(radii=(1.0, 1.0, 2.0), exponents=(1.0, 0.25))
    """

    __slots__ = ("_core", "_exponents", "_radii")

    def __init__(
        self, radii: ArrayLike, exponents: ArrayLike = (1.0, 1.0), *, convention: str | None = None
    ) -> None:
        sizes = floats(radii, "radii")
        if sizes.shape == ():
            sizes = np.full(3, sizes)
        pair = floats(exponents, "exponents")
        if sizes.shape != (3,) or pair.shape != (2,):
            raise ValueError(
                f"expected radii of shape (3,) and exponents of shape (2,), found {sizes.shape} and {pair.shape}"
            )
        chosen = convention_of(convention)
        a, b, c = (float(x) for x in chosen.radii(sizes))
        e, n = (float(x) for x in chosen.own_exponents(pair))
        self._radii, self._exponents = (a, b, c), (e, n)
        self._core = _superegg.Shape([a, b, c], [e, n])

    @property
    def radii(self) -> tuple[float, float, float]:
        """The semi-axes a, b, c."""
        return self._radii

    @property
    def exponents(self) -> tuple[float, float]:
        """The exponents e and n."""
        return self._exponents

    @property
    def is_convex(self) -> bool:
        """Whether e and n are at most 2."""
        return max(self._exponents) <= 2.0

    @property
    def bounds(self) -> Floats:
        """The smallest box around the shape, shape (2, 3): its least and its greatest corner."""
        half = np.array(self._radii)
        return np.stack([-half, half])

    def value(self, points_: ArrayLike, /) -> Floats:
        """The inside-outside function.

        Parameters
        ----------
        points : array_like, shape (..., 3)

        Returns
        -------
        ndarray of float64, shape (...)
            Below 0 inside, 0 on the surface, above 0 outside; inf where it leaves the range.

        Examples
        --------
        >>> import superegg as se
        >>> se.Superquadric(1).value([[0, 0, 0], [2, 0, 0]])
        array([-1.,  3.])
        """
        at, shape = points(points_)
        return self._core.value(at).reshape(shape)

    def inside(self, points_: ArrayLike, /) -> Bools:
        """Whether points are inside or on the surface, shape (...) for points of shape (..., 3)."""
        return np.asarray(self.value(points_) <= 0.0)

    def signed_distance(
        self, points_: ArrayLike, /, *, tolerance: float = 1e-9, threads: int = 0
    ) -> Floats:
        """The distance to the surface, negative inside.

        Parameters
        ----------
        points : array_like, shape (..., 3)
        tolerance : float
            The error that is small enough, as a part of the distance.
        threads : int
            0 for one for each core.

        Returns
        -------
        ndarray of float64, shape (...)

        Examples
        --------
        >>> import superegg as se
        >>> float(se.Superquadric((1, 1, 1), (3, 3)).signed_distance([0, 0, 1.5]))
        0.5
        """
        return self.closest_point(points_, tolerance=tolerance, threads=threads).distance

    def closest_point(self, points_: ArrayLike, /, *, tolerance: float = 1e-9, threads: int = 0) -> Closest:
        """The closest points of the surface, with the signed distances and their proven errors.

        Parameters and errors are those of `signed_distance`.

        Returns
        -------
        Closest
            ``position`` of shape (..., 3), ``distance`` and ``error`` of shape (...).

        Notes
        -----
        Branch and bound over the surface, whatever the exponents: no start value, no local minimum.
        """
        at, shape = points(points_)
        small = number(tolerance, "tolerance")
        if not 0.0 < small < 1.0:
            raise ValueError(f"tolerance: expected a number between 0 and 1, found {small}")
        found = self._core.closest(at, small, threads_(threads))
        return Closest(found[0].reshape((*shape, 3)), found[1].reshape(shape), found[2].reshape(shape))

    def normal(self, points_: ArrayLike, /) -> Floats:
        """The outward unit normals, shape (..., 3), at points of the surface of shape (..., 3).

        Elsewhere it is the direction of the gradient.
        """
        at, shape = points(points_)
        return self._core.normal(at).reshape((*shape, 3))

    def point(self, u: ArrayLike, v: ArrayLike) -> Floats:
        """The points of longitude u and latitude v.

        Parameters
        ----------
        u, v : array_like
            Radians: u in (-pi, pi], v in [-pi/2, pi/2]. They broadcast.

        Returns
        -------
        ndarray of float64, shape (..., 3)

        Examples
        --------
        >>> import superegg as se
        >>> se.Superquadric((1, 2, 3)).point([0, 0], [0, 0])
        array([[1., 0., 0.],
               [1., 0., 0.]])
        """
        return self._at(u, v)[0]

    def normal_at(self, u: ArrayLike, v: ArrayLike) -> Floats:
        """The outward unit normals at longitude u and latitude v, shape (..., 3).

        More exact than the normal at that point, whose coordinates cannot resolve the edges of a box.
        """
        return self._at(u, v)[1]

    def _at(self, u: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        us, vs = floats(u, "u"), floats(v, "v")
        shape = common_shape({"u": us.shape, "v": vs.shape})
        pairs = np.stack([np.broadcast_to(us, shape), np.broadcast_to(vs, shape)], axis=-1)
        where, normals = self._core.point(column(pairs, pairs.shape))
        return where.reshape((*shape, 3)), normals.reshape((*shape, 3))

    def uv(self, points_: ArrayLike, /) -> tuple[Floats, Floats]:
        """Longitude and latitude of points of the surface, in radians: the inverse of `point`."""
        at, shape = points(points_)
        u, v = self._core.uv(at)
        return u.reshape(shape), v.reshape(shape)

    def sample_surface(self, n: int, seed: int = 0) -> tuple[Floats, Floats]:
        """Independent points spread evenly over the surface by area.

        Parameters
        ----------
        n : int
            The number of points.
        seed : int
            The same seed gives the same points.

        Returns
        -------
        points, normals : ndarray of float64, shape (n, 3)
        """
        where, normals = self._core.sample_surface(_most(n), count(seed, "seed"))
        return where.reshape((-1, 3)), normals.reshape((-1, 3))

    def sample_inside(self, n: int, seed: int = 0) -> Floats:
        """Independent points spread evenly over the inside, shape (n, 3)."""
        return self._core.sample_inside(_most(n), count(seed, "seed")).reshape((-1, 3))

    @property
    def volume(self) -> float:
        """The volume, to about 14 digits.

        Examples
        --------
        >>> import superegg as se
        >>> round(se.Superquadric((1, 1, 1), (2, 2)).volume, 12)  # an octahedron
        1.333333333333
        """
        return self._core.volume()

    @property
    def area(self) -> float:
        """The surface area; `area_with_error` has its error too."""
        return self._core.area()[0]

    def area_with_error(self) -> Area:
        """The surface area with its proven error."""
        return Area(*self._core.area())

    def inertia(self, mass: float | None = None) -> Floats:
        """The principal moments of inertia about x, y and z through the centre, shape (3,).

        Parameters
        ----------
        mass : float, optional
            The mass, at least 0; without it the density is 1.

        Examples
        --------
        >>> import superegg as se
        >>> se.Superquadric(1).inertia(mass=5.0).round(9)
        array([2., 2., 2.])
        """
        if mass is None:
            return np.array(self._core.inertia())
        weight = number(mass, "mass")
        if weight < 0.0:
            raise ValueError(f"mass: expected a number of at least 0, found {weight}")
        # Of the shape of size 1, whose volume and fifth powers are within the range of float64.
        unit = max(self._radii)
        shape = Superquadric([max(radius / unit, 1e-200) for radius in self._radii], self._exponents)
        return np.array(shape._core.inertia()) / shape.volume * weight * unit * unit

    def mesh(self, tolerance: float = 1e-2) -> Mesh:
        """A closed triangle mesh.

        Parameters
        ----------
        tolerance : float
            The greatest distance between mesh and surface, both ways, as a part of the largest semi-axis.

        Returns
        -------
        Mesh
            ``vertices`` (V, 3), ``faces`` (F, 3), ``normals`` (V, 3).

        Raises
        ------
        ValueError
            A tolerance not above 0, or one that needs more than 4,000,000 triangles.
        """
        fine = number(tolerance, "tolerance") * max(self._radii)
        vertices, normals, faces = self._core.mesh(fine)
        return Mesh(vertices.reshape((-1, 3)), faces.reshape((-1, 3)), normals.reshape((-1, 3)))

    def to_trimesh(self, tolerance: float = 1e-2) -> Any:
        """The mesh as a ``trimesh.Trimesh``; needs trimesh."""
        return self.mesh(tolerance).to_trimesh()

    def to_open3d(self, tolerance: float = 1e-2) -> Any:
        """The mesh as an ``open3d.geometry.TriangleMesh``; needs open3d."""
        return self.mesh(tolerance).to_open3d()

    def to_pyvista(self, tolerance: float = 1e-2) -> Any:
        """The mesh as a ``pyvista.PolyData``; needs pyvista."""
        return self.mesh(tolerance).to_pyvista()

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike | None = None,
        t_max: ArrayLike | None = None,
        threads: int = 0,
    ) -> ShapeHits:
        """The first hit of each ray ``origin + t direction``.

        Parameters
        ----------
        origins, directions : array_like, shape (..., 3)
            They broadcast. A direction need not have length 1; one of 0 hits nothing.
        t_min, t_max : array_like, optional
            Hits count for ``t_min <= t < t_max``; default: from 0 on.
        threads : int
            0 for one for each core.

        Returns
        -------
        ShapeHits

        Examples
        --------
        >>> import superegg as se
        >>> se.Superquadric(1).intersect([[0, 0, 5], [3, 0, 5]], [0, 0, -1]).t
        array([ 4., inf])
        """
        start, way, least, most, shape = rays(origins, directions, t_min, t_max)
        return ShapeHits(self._core.intersect(start, way, least, most, threads_(threads)), shape)

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike | None = None,
        t_max: ArrayLike | None = None,
    ) -> Bools:
        """Whether each ray hits anything for ``t_min <= t < t_max``, shape (...)."""
        start, way, least, most, shape = rays(origins, directions, t_min, np.inf if t_max is None else t_max)
        assert most is not None
        return self._core.occluded(start, way, least, most).reshape(shape)

    def __repr__(self) -> str:
        return f"Superquadric(radii={self._radii}, exponents={self._exponents})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Superquadric):
            return NotImplemented
        return self._radii == other._radii and self._exponents == other._exponents

    def __hash__(self) -> int:
        return hash((self._radii, self._exponents))

    def __reduce__(self) -> tuple[Any, ...]:
        return Superquadric, (self._radii, self._exponents)


def _most(n: int) -> int:
    """A number of points that a machine can hold."""
    n = count(n, "n")
    if n > 10**9:
        raise ValueError(f"n: expected at most 1000000000 points, found {n}")
    return n


__all__ = ["Area", "Superquadric"]
