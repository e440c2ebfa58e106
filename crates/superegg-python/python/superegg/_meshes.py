"""Triangle meshes, and meshes of other packages."""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from superegg import _superegg
from superegg._arrays import Floats


class Mesh(NamedTuple):
    """A triangle mesh.

    Attributes
    ----------
    vertices : ndarray of float64, shape (V, 3)
        Points of the surface, each once.
    faces : ndarray of uint32, shape (F, 3)
        Indices of vertices, counter-clockwise as seen from outside.
    normals : ndarray of float64, shape (V, 3)
        The exact outward unit normals at the vertices.
    """

    vertices: Floats
    faces: NDArray[np.uint32]
    normals: Floats

    def to_trimesh(self) -> Any:
        """The mesh as a ``trimesh.Trimesh``; needs trimesh."""
        return _trimesh(self)

    def to_open3d(self) -> Any:
        """The mesh as an ``open3d.geometry.TriangleMesh``; needs open3d."""
        return _open3d(self)

    def to_pyvista(self) -> Any:
        """The mesh as a ``pyvista.PolyData``; needs pyvista."""
        return _pyvista(self)


class SceneMesh(NamedTuple):
    """The triangles of all instances of a scene, in world coordinates.

    Instances share no vertices, so each is a closed mesh of its own.

    Attributes
    ----------
    vertices : ndarray of float64, shape (V, 3)
        Points of the surfaces.
    faces : ndarray of uint32, shape (F, 3)
        Indices of vertices, counter-clockwise as seen from outside.
    normals : ndarray of float64, shape (V, 3)
        The exact outward unit normals at the vertices.
    instance : ndarray of uint32, shape (F,)
        The row of each face's instance in ``names`` and ``colors``.
    names : list of str
        The path of each instance, such as ``model/arm/hand``.
    colors : ndarray of float64, shape (I, 3)
        The colour of each instance in linear light.
    """

    vertices: Floats
    faces: NDArray[np.uint32]
    normals: Floats
    instance: NDArray[np.uint32]
    names: list[str]
    colors: Floats

    def face_colors(self) -> NDArray[np.uint8]:
        """The colour of each face in sRGB, shape (F, 3)."""
        encoded = _superegg.srgb8(np.ascontiguousarray(self.colors).reshape(-1)).reshape(self.colors.shape)
        return np.asarray(encoded[self.instance])

    def to_trimesh(self) -> Any:
        """The mesh as a ``trimesh.Trimesh`` with a colour for each face; needs trimesh."""
        mesh = _trimesh(self)
        mesh.visual.face_colors = self.face_colors()
        return mesh

    def to_open3d(self) -> Any:
        """The mesh as an ``open3d.geometry.TriangleMesh`` with a colour for each vertex; needs open3d."""
        mesh = _open3d(self)
        colors = np.zeros_like(self.vertices)
        colors[self.faces] = (self.face_colors() / 255.0)[:, None, :]
        mesh.vertex_colors = import_module("open3d").utility.Vector3dVector(colors)
        return mesh

    def to_pyvista(self) -> Any:
        """The mesh as a ``pyvista.PolyData`` with ``instance`` and ``RGB`` for each face; needs pyvista."""
        mesh = _pyvista(self)
        mesh.cell_data["instance"] = self.instance
        mesh.cell_data["RGB"] = self.face_colors()
        return mesh


def _trimesh(mesh: Mesh | SceneMesh) -> Any:
    trimesh: Any = import_module("trimesh")
    return trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_normals=mesh.normals, process=False)


def _open3d(mesh: Mesh | SceneMesh) -> Any:
    o3d: Any = import_module("open3d")
    result = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices), o3d.utility.Vector3iVector(mesh.faces.astype(np.int32))
    )
    result.vertex_normals = o3d.utility.Vector3dVector(mesh.normals)
    return result


def _pyvista(mesh: Mesh | SceneMesh) -> Any:
    pyvista: Any = import_module("pyvista")
    result = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces.astype(np.int64))
    result.point_data["Normals"] = mesh.normals
    return result


__all__ = ["Mesh", "SceneMesh"]
