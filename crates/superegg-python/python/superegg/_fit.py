"""A superquadric from points of its surface."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from superegg import _superegg
from superegg._arrays import Floats, number, points, vector
from superegg._arrays import count as whole
from superegg._rotation import matrices
from superegg._shape import Superquadric

COVARIANCE_ROWS: tuple[str, ...] = tuple(_superegg.covariance_rows())
"""The parameters of the rows and columns of `Fit.covariance`."""


class Residuals(NamedTuple):
    """How far points are from a fitted surface.

    Attributes
    ----------
    distance : ndarray of float64, shape (...)
        The signed distance: negative inside.
    inlier : ndarray of float64, shape (...)
        The probability that the point is of the surface and no outlier.
    """

    distance: Floats
    inlier: Floats

    @property
    def rms(self) -> float:
        """The root mean square of the distances, each weighted by its probability; nan if no point is of the surface."""
        if not np.any(self.inlier > 0.0):
            return float("nan")
        return float(np.sqrt(np.average(self.distance**2, weights=self.inlier)))

    @property
    def hausdorff(self) -> float:
        """The largest distance of a point that is more probably of the surface than not."""
        return float(np.max(np.abs(self.distance), initial=0.0, where=self.inlier >= 0.5))


class Fit:
    """A superquadric that fits points: the answer of `fit`.

    Attributes
    ----------
    shape : Superquadric
        Semi-axes, in the unit of the points, and exponents.
    rotation : ndarray of float64, shape (3, 3)
        The rotation from the shape's own axes to those of the points.
    quaternion : ndarray of float64, shape (4,)
        The same as w x y z.
    center : ndarray of float64, shape (3,)
    noise : float
        The standard deviation of the distances of inliers.
    outliers : float
        The share of outliers.
    surface_error : float
        The standard error of the surface, its root mean square over the whole of it, hidden sides included.
    covariance : ndarray of float64, shape (11, 11)
        The covariance of the parameters ``COVARIANCE_ROWS``: centre, a rotation vector about the shape's own
        axes in radians, semi-axes, exponents.
    used : int
        The number of points that were fitted.
    warnings : tuple of str
        What the points leave in doubt.
    """

    shape: Superquadric
    rotation: Floats
    quaternion: Floats
    center: Floats
    noise: float
    outliers: float
    surface_error: float
    covariance: Floats
    used: int
    warnings: tuple[str, ...]

    def __init__(self, core: _superegg.Fit) -> None:
        self._core = core
        self.shape = Superquadric(core.radii(), core.exponents())
        self.quaternion = np.array(core.rotation())
        self.rotation = matrices(self.quaternion, "rotation")
        self.center = np.array(core.center())
        self.noise = core.noise()
        self.outliers = core.outliers()
        self.surface_error = core.surface_error()
        self.covariance = core.covariance().reshape(11, 11)
        self.used = core.used()
        self.warnings = tuple(core.warnings())

    def residuals(self, points_: ArrayLike, /) -> Residuals:
        """The distances of points of shape (..., 3) from the surface, and their probabilities to be of it."""
        at, shape = points(points_)
        distance, inlier = self._core.residuals(at)
        return Residuals(distance.reshape(shape), inlier.reshape(shape))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._core.kept(),)

    def __repr__(self) -> str:
        a, b, c = (f"{x:.6g}" for x in self.shape.radii)
        e, n = (f"{x:.4g}" for x in self.shape.exponents)
        at = ", ".join(f"{x:.6g}" for x in self.center)
        return f"<Fit: radii ({a}, {b}, {c}), exponents ({e}, {n}), center ({at}), noise {self.noise:.3g}>"


def _restored(kept: tuple[Any, ...]) -> Fit:
    return Fit(_superegg.Fit.restored(kept))


def fit(
    points_: ArrayLike,
    /,
    *,
    seed: int = 0,
    outliers: float = 0.2,
    exponents: ArrayLike = (0.05, 2.0),
    most_points: int = 20_000,
) -> Fit:
    """Fit a superquadric to points of its surface with noise, outliers and hidden sides.

    Parameters
    ----------
    points : array_like, shape (..., 3)
        At least 12 different points that do not lie on a plane.
    seed : int
        The same points, in any order, and the same seed give the same fit.
    outliers : float
        The share of outliers to begin with, 0 to 0.9; the share of the points is found.
    exponents : (least, most)
        The range of both exponents, within 0.01 to 8.
    most_points : int
        Of more points an even random choice of this many is fitted; at least 1000.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        Too few different points, points on a plane or a line, or numbers that are not finite.

    Examples
    --------
    >>> import superegg as se
    >>> points, _ = se.Superquadric((1, 2, 3), (0.5, 1.3)).sample_surface(1000)
    >>> found = se.fit(points + 10.0)
    >>> sorted(round(radius, 3) for radius in found.shape.radii)
    [1.0, 2.0, 3.0]
    >>> found.center.round(3)
    array([10., 10., 10.])
    >>> found.warnings
    ()
    """
    at, _ = points(points_)
    least, most = vector(exponents, "exponents", 2)
    return Fit(
        _superegg.fit(
            at,
            whole(seed, "seed"),
            number(outliers, "outliers"),
            [least, most],
            whole(most_points, "most_points"),
        )
    )


def fit_parts(
    points_: ArrayLike,
    /,
    count: int | Literal["auto"] = "auto",
    *,
    seed: int = 0,
    outliers: float = 0.2,
    exponents: ArrayLike = (0.05, 2.0),
    most_points: int = 20_000,
) -> list[Fit]:
    """Fit superquadrics to points of several objects, or of one object in parts.

    Parameters
    ----------
    points : array_like, shape (..., 3)
    count : int or "auto"
        The number of shapes, 1 to 64, fewer where the points do not show as many; or as many as shorten the
        description of the points.
    seed, outliers, exponents, most_points
        As for `fit`.

    Returns
    -------
    list of Fit
        The shapes, those of the most points first. Ctrl-c stops the search.

    Raises
    ------
    ValueError
        As for `fit`, and a number of shapes out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import superegg as se
    >>> ball, _ = se.Superquadric((1, 1, 1), (1, 1)).sample_surface(600)
    >>> box, _ = se.Superquadric((1, 2, 1), (0.2, 0.2)).sample_surface(900)
    >>> parts = se.fit_parts(np.vstack([ball, box + [5, 0, 0]]))
    >>> [(part.center.round(1) + 0).tolist() for part in parts]
    [[5.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    """
    at, _ = points(points_)
    least, most = vector(exponents, "exponents", 2)
    if isinstance(count, str) and count != "auto":
        raise ValueError(f"count must be 'auto' or a whole number from 1 to 64, not {count!r}")
    parts = _superegg.fit_parts(
        at,
        None if isinstance(count, str) else whole(count, "count"),
        whole(seed, "seed"),
        number(outliers, "outliers"),
        [least, most],
        whole(most_points, "most_points"),
    )
    return [Fit(part) for part in parts]
