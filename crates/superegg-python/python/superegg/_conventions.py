"""Other programs' conventions for sizes, exponents and rotations, by name.

See docs/formats.md of the project for where they come from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from superegg._arrays import Floats, vectors
from superegg._rotation import euler, matrices


@dataclass(frozen=True)
class Convention:
    """How a program writes a superquadric."""

    sizes: str = "semi-axes"
    """``semi-axes`` or ``diameters``."""
    exponents: str = "e n"
    """``e n``, ``n e``, or ``2/n 2/e`` for blockiness."""
    quaternion: str = "wxyz"
    """``wxyz`` or ``xyzw``."""
    euler: str | None = None
    """The axes of R = R_A R_B R_C; rotations of shape (..., 3) are then three angles in radians."""
    from_world: bool = False
    """Whether a rotation leads from world to body."""
    zero_is_round: bool = False
    """Whether an exponent of 0 stands for 1."""

    def radii(self, sizes: Any) -> Floats:
        """The semi-axes."""
        array = vectors(sizes, "radii")
        return 0.5 * array if self.sizes == "diameters" else array

    def own_exponents(self, pairs: Any) -> Floats:
        """The exponents (e, n)."""
        array = vectors(pairs, "exponents", 2)
        if self.zero_is_round:
            array = np.where(array == 0, 1.0, array)
        if self.exponents == "2/n 2/e":
            if array.size and not array.min() > 0:
                raise ValueError(f"exponents: a blockiness of the array of shape {array.shape} is not above 0")
            array = 2.0 / array
        return array if self.exponents == "e n" else array[..., ::-1]

    def rotations(self, rotation: Any, name: str) -> Floats:
        """Rotation matrices from body to world."""
        if not hasattr(rotation, "as_matrix"):
            array = np.asarray(rotation)
            if self.euler is not None and array.shape[-1:] == (3,) and array.shape[-2:] != (3, 3):
                return euler(rotation, self.euler, name)
            if self.quaternion == "xyzw" and array.shape[-1:] == (4,):
                rotation = np.roll(vectors(rotation, name, 4), 1, axis=-1)
        turned = matrices(rotation, name)
        return np.swapaxes(turned, -1, -2) if self.from_world else turned


OWN = Convention()

CONVENTIONS: dict[str, Convention] = {
    "superegg": OWN,
    "povray": OWN,
    "liggghts": Convention(exponents="2/n 2/e"),
    "lammps": Convention(sizes="diameters", exponents="2/n 2/e"),
    "ovito": Convention(quaternion="xyzw", zero_is_round=True),
    "mercurydpm": Convention(sizes="diameters"),
    "sudodem": Convention(),
    "ems": Convention(exponents="n e", euler="zyx"),
    "superdec": Convention(exponents="n e"),
    "superquadric-parsing": Convention(exponents="n e", from_world=True),
    "superquadric-lib": Convention(exponents="n e", euler="zyz"),
    "sage": Convention(exponents="n e", euler="xyz"),
    "vtk": Convention(exponents="n e"),
    "pyvista": Convention(exponents="n e"),
}


def convention_of(name: str | None) -> Convention:
    """The convention of a name; ours for ``None``."""
    if name is None:
        return OWN
    try:
        return CONVENTIONS[name]
    except (KeyError, TypeError):
        known = ", ".join(CONVENTIONS)
        raise ValueError(f"there is no convention {name!r} for arrays; choose one of {known}") from None
