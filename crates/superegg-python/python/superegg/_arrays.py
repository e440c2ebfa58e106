"""Arrays from users as the contiguous columns that the compiled half takes."""

from __future__ import annotations

from operator import index
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Shape = tuple[int, ...]

MOST_THREADS = 1024
"""The most threads of a call, as of the program's ``--threads``."""


def floats(values: ArrayLike, name: str, *, allow_infinite: bool = False) -> Floats:
    """Numbers of any real type as float64, none of them nan."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name}: values of an array of shape {np.shape(values)} are masked; leave them out or fill them")
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError(f"{name}: rows of different lengths make no array") from error
    if array.dtype.kind not in "fiub":
        kind = "empty" if array.size == 0 else f"of type {array.dtype}"
        raise ValueError(f"{name}: expected real numbers, found an array {kind} of shape {array.shape}")
    array = np.asarray(array, dtype=np.float64)
    is_fine = not np.isnan(array).any() if allow_infinite else np.isfinite(array).all()
    if not is_fine:
        wrong = np.isnan(array) if allow_infinite else ~np.isfinite(array)
        first = tuple(int(i) for i in np.argwhere(wrong)[0])
        at = f" at index {first}" if first else ""
        raise ValueError(
            f"{name}: expected finite numbers, found {array[first]}{at} of an array of shape {array.shape}"
        )
    return array


def vectors(values: ArrayLike, name: str, width: int = 3) -> Floats:
    """An array of shape (..., width)."""
    array = floats(values, name)
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name}: expected an array of shape (..., {width}), found shape {array.shape}")
    return array


def vector(values: ArrayLike, name: str, width: int = 3) -> tuple[float, ...]:
    """One vector."""
    array = floats(values, name)
    if array.shape != (width,):
        raise ValueError(f"{name}: expected {width} numbers, found an array of shape {array.shape}")
    return tuple(float(x) for x in array)


def number(value: Any, name: str) -> float:
    """One finite number."""
    array = floats(value, name)
    if array.shape != ():
        raise ValueError(f"{name}: expected one number, found an array of shape {array.shape}")
    return float(array)


def count(value: Any, name: str, least: int = 0) -> int:
    """One whole number."""
    try:
        whole = index(value)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, found {value!r}") from None
    if not least <= whole < 2**63:
        raise ValueError(f"{name}: expected a whole number of at least {least} and below 2^63, found {whole}")
    return whole


def threads(value: Any) -> int:
    """A number of threads. More than the most do not help, and a system may not have them."""
    return min(count(value, "threads"), MOST_THREADS)


def flag(value: Any, name: str) -> bool:
    """True or False. A text such as "no" is neither."""
    if not isinstance(value, (bool, np.bool_, int, np.integer)):
        raise TypeError(f"{name}: expected True or False, found {value!r}")
    return bool(value)


def text(value: Any, name: str) -> str:
    """One text."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected a text, found {type(value).__name__}")
    return value


def common_shape(shapes: dict[str, Shape]) -> Shape:
    """The shape that all broadcast to."""
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"shapes do not broadcast: {found}") from None


def column(array: Floats, shape: Shape) -> Floats:
    """The numbers of an array that broadcasts to a shape, contiguous and of one dimension."""
    if array.shape != shape:
        array = np.broadcast_to(array, shape)
    return np.ascontiguousarray(array).reshape(-1)


def rays(
    origins: ArrayLike, directions: ArrayLike, t_min: ArrayLike | None, t_max: ArrayLike | None
) -> tuple[Floats, Floats, Floats | None, Floats | None, Shape]:
    """The columns of rays, and the shape of a column of answers."""
    starts = vectors(origins, "origins")
    ways = vectors(directions, "directions")
    shapes = {"origins": starts.shape[:-1], "directions": ways.shape[:-1]}
    ends: dict[str, Floats] = {}
    for name, values in (("t_min", t_min), ("t_max", t_max)):
        if values is not None:
            ends[name] = floats(values, name, allow_infinite=True)
            shapes[name] = ends[name].shape
    shape = common_shape(shapes)
    start, end = (column(ends[name], shape) if name in ends else None for name in ("t_min", "t_max"))
    return column(starts, (*shape, 3)), column(ways, (*shape, 3)), start, end, shape


def points(values: ArrayLike, name: str = "points") -> tuple[Floats, Shape]:
    """The column of points, and the shape of a column of answers."""
    array = vectors(values, name)
    shape = array.shape[:-1]
    return column(array, array.shape), shape
