"""Rendered pictures."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from superegg import _superegg

Float32s = NDArray[np.float32]
Number = TypeVar("Number", np.float32, np.uint32)


class Film:
    """A rendered picture: linear light, and what the pixels show.

    It is an array of its colours for numpy: ``np.asarray(film)``, ``film[y, x]``, ``film.shape``. A
    notebook shows it. Rows go from the top.
    """

    def __init__(self, core: _superegg.Film) -> None:
        self._core = core

    @property
    def shape(self) -> tuple[int, int, int]:
        """Height, width and 3."""
        height, width = self._core.size
        return height, width, 3

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    @property
    def dtype(self) -> np.dtype[np.float32]:
        """float32."""
        return np.dtype(np.float32)

    @cached_property
    def color(self) -> Float32s:
        """Linear light before exposure and tone mapping, shape (h, w, 3)."""
        return self._core.color().reshape(self.shape)

    @cached_property
    def alpha(self) -> Float32s:
        """The share of each pixel that is covered, shape (h, w); 1 unless the background is transparent."""
        return self._core.alpha().reshape(self.shape[:2])

    @cached_property
    def depth(self) -> Float32s:
        """World units along the line of sight, shape (h, w); inf where there is nothing."""
        return self._layer(self._core.depth(), ())

    @cached_property
    def normal(self) -> Float32s:
        """The unit normals of the first surface in world space, shape (h, w, 3); 0 where there is nothing."""
        return self._layer(self._core.normal(), (3,))

    @cached_property
    def albedo(self) -> Float32s:
        """The linear colour of the first surface, shape (h, w, 3)."""
        return self._layer(self._core.albedo(), (3,))

    @cached_property
    def instance_id(self) -> NDArray[np.uint32]:
        """The instance of the first surface, shape (h, w): `Hits.instance`; 0 where there is nothing."""
        return self._layer(self._core.instance_id(), ())

    @cached_property
    def instance_number(self) -> NDArray[np.uint32]:
        """The number of that instance in the order of children, shape (h, w).

        From 2 on, at most 2^24; 1 for the floor, 0 where there is nothing. It is the channel ``instance`` of an .exr.
        """
        return self._layer(self._core.instance_number(), ())

    @cached_property
    def object_number(self) -> NDArray[np.uint32]:
        """The number of the object that the instance belongs to, shape (h, w).

        It is the child of the selected object, or below objects of a single child, of the first that has several. It is
        the channel ``object`` of an .exr.
        """
        return self._layer(self._core.object_number(), ())

    @cached_property
    def emission(self) -> Float32s:
        """Light of the background and of surfaces that shine, straight to the camera, shape (h, w, 3).

        Of a picture with ``light="path"``. `emission`, `direct` and `indirect` add up to `color`.
        """
        return self._pass("emission")

    @cached_property
    def direct(self) -> Float32s:
        """Light by way of one surface, shape (h, w, 3): see `emission`."""
        return self._pass("direct")

    @cached_property
    def indirect(self) -> Float32s:
        """Light by way of two surfaces or more, shape (h, w, 3): see `emission`."""
        return self._pass("indirect")

    def _pass(self, name: str) -> Float32s:
        column = self._core.light_pass(name)
        if column.size == 0:
            raise ValueError('only pictures with light="path" and layers keep the parts of light apart')
        return column.reshape(self.shape)

    @cached_property
    def samples(self) -> NDArray[np.uint32]:
        """The number of samples of each pixel, shape (h, w)."""
        return self._core.samples().reshape(self.shape[:2])

    def _layer(self, column: NDArray[Number], width: tuple[int, ...]) -> NDArray[Number]:
        if not self._core.has_layers:
            raise ValueError("the picture was rendered with layers=False, so it has light alone")
        return column.reshape(self.shape[:2] + width)

    @cached_property
    def rgb8(self) -> NDArray[np.uint8]:
        """The picture as a screen shows it: exposed, tone mapped and encoded, shape (h, w, 3) uint8."""
        return self._core.rgb8().reshape(self.shape)

    def to_png(self) -> bytes:
        """The PNG file."""
        return self._core.to_png()

    def to_exr(self) -> bytes:
        """The OpenEXR file: linear light with depth, normals, albedo and instance ids."""
        return self._core.to_exr()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a ``.png`` or ``.exr`` file, the same bytes as those of the program.

        Raises
        ------
        ValueError
            Another ending.
        OSError
            The file cannot be written.
        """
        self._core.save(os.fspath(path))

    def _repr_png_(self) -> bytes:
        return self.to_png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        array: NDArray[Any] = self.color if dtype is None else self.color.astype(dtype, copy=False)
        if copy is False and array is not self.color:
            raise ValueError(f"the film is an array of {self.dtype}; one of {array.dtype} needs a copy")
        return array.copy() if copy else array

    # A film does not change.
    def __copy__(self) -> Film:
        return Film(self._core)

    def __deepcopy__(self, memo: Any) -> Film:
        return Film(self._core)

    def __reduce__(self) -> Any:
        raise TypeError("a film cannot be pickled; pickle its arrays, such as film.color, or film.to_exr()")

    def __getitem__(self, index: Any) -> Any:
        return self.color[index]

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        height, width, _ = self.shape
        return f"<Film: {width} x {height} pixels>"
