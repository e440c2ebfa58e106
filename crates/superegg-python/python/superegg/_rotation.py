"""Rotations and placements in all the forms that Python has for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from superegg._arrays import Floats, floats, vectors

# How far from orthonormal a matrix may be: six digits, as files write them.
TOLERANCE = 1e-4


def matrices(rotation: Any, name: str = "rotation") -> Floats:
    """Rotation matrices, shape (..., 3, 3), from body to world.

    Takes a scipy ``Rotation``, quaternions w x y z of shape (..., 4), or matrices of shape (..., 3, 3).
    """
    if hasattr(rotation, "as_matrix"):
        return floats(rotation.as_matrix(), name)
    array = floats(rotation, name)
    if array.ndim >= 2 and array.shape[-2:] == (3, 3):
        return _checked(array, name)
    if array.ndim >= 1 and array.shape[-1] == 4:
        return _of_quaternions(array, name)
    raise ValueError(
        f"{name}: expected quaternions w x y z of shape (..., 4), matrices of shape (..., 3, 3) or a scipy "
        f"Rotation, found an array of shape {array.shape}"
    )


def _checked(array: Floats, name: str) -> Floats:
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(array @ np.swapaxes(array, -1, -2) - np.eye(3))
    if array.size and (not off.max() <= TOLERANCE or np.linalg.det(array).min() < 0):  # inf and nan, too
        raise ValueError(
            f"{name}: expected rotation matrices; one of shape {array.shape} is not orthonormal or mirrors. "
            "Scale and shear go into 'matrix'"
        )
    return array


def _of_length_one(array: Floats, name: str) -> Floats:
    # The square of a length may leave the range of float64 though the length does not.
    largest = np.abs(array).max(axis=-1, keepdims=True, initial=0.0)
    if array.size and not largest.min() > 0:
        raise ValueError(f"{name}: a quaternion of the array of shape {array.shape} has length 0")
    scaled = array / largest
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def _of_quaternions(array: Floats, name: str) -> Floats:
    w, x, y, z = np.moveaxis(_of_length_one(array, name), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternions(rotation: Any, name: str = "rotations") -> Floats:
    """Unit quaternions x y z w, shape (..., 4), of the same forms as `matrices`."""
    if hasattr(rotation, "as_quat"):
        return floats(rotation.as_quat(), name)
    array = floats(rotation, name)
    if array.ndim >= 2 and array.shape[-2:] == (3, 3):
        return _of_matrices(_checked(array, name))
    if array.ndim >= 1 and array.shape[-1] == 4:
        return np.roll(_of_length_one(array, name), -1, axis=-1)
    return matrices(array, name)  # which says what is wrong


def _of_matrices(m: Floats) -> Floats:
    """The quaternion from the largest of its four squares, so that nothing small is divided by."""
    d = np.einsum("...ii->...i", m)
    trace = d.sum(axis=-1)
    squares = np.stack([*(1 + 2 * d[..., i] - trace for i in range(3)), 1 + trace], axis=-1)
    off = {
        "x": m[..., 2, 1] - m[..., 1, 2],
        "y": m[..., 0, 2] - m[..., 2, 0],
        "z": m[..., 1, 0] - m[..., 0, 1],
    }
    xy, xz, yz = (m[..., i, j] + m[..., j, i] for i, j in ((0, 1), (0, 2), (1, 2)))
    rows = np.stack(
        [
            np.stack([squares[..., 0], xy, xz, off["x"]], axis=-1),
            np.stack([xy, squares[..., 1], yz, off["y"]], axis=-1),
            np.stack([xz, yz, squares[..., 2], off["z"]], axis=-1),
            np.stack([off["x"], off["y"], off["z"], squares[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    largest = np.argmax(squares, axis=-1)[..., None, None]
    best = np.take_along_axis(rows, largest, axis=-2)[..., 0, :]
    return np.asarray(best / np.linalg.norm(best, axis=-1, keepdims=True))


def euler(angles: Any, order: str, name: str) -> Floats:
    """R = R_a(first) R_b(second) R_c(third) from angles in radians of shape (..., 3)."""
    array = vectors(angles, name)
    result = np.broadcast_to(np.eye(3), (*array.shape[:-1], 3, 3))
    for i, axis in enumerate(order):
        result = result @ _about(axis, array[..., i])
    return np.asarray(result)


def _about(axis: str, angle: Floats) -> Floats:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = {
        "x": [[i, o, o], [o, c, -s], [o, s, c]],
        "y": [[c, o, s], [o, i, o], [-s, o, c]],
        "z": [[c, -s, o], [s, c, o], [o, o, i]],
    }[axis]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def placement(matrix: Any, position: Any, rotation: Any) -> list[float] | None:
    """The 3 x 4 map of a part, row by row; ``None`` for the identity."""
    if matrix is not None:
        if position is not None or rotation is not None:
            raise ValueError("give either matrix, or position and rotation, not both")
        array = floats(matrix, "matrix")
        if array.shape == (4, 4):
            if not np.array_equal(array[3], [0, 0, 0, 1]):
                raise ValueError("matrix: the last row of a matrix of shape (4, 4) must be 0 0 0 1")
        elif array.shape == (3, 3):
            array = np.hstack([array, np.zeros((3, 1))])
        elif array.shape != (3, 4):
            raise ValueError(f"matrix: expected shape (4, 4), (3, 4) or (3, 3), found shape {array.shape}")
        return [float(x) for x in array[:3].reshape(-1)]
    if position is None and rotation is None:
        return None
    turn = np.eye(3) if rotation is None else matrices(rotation)
    if turn.shape != (3, 3):
        raise ValueError(f"rotation: expected one rotation, found an array of shape {turn.shape[:-2]} of them")
    at = np.zeros(3) if position is None else floats(position, "position")
    if at.shape != (3,):
        raise ValueError(f"position: expected 3 numbers, found an array of shape {at.shape}")
    return [float(x) for x in np.hstack([turn, at[:, None]]).reshape(-1)]
