"""Exact superquadrics: distances, rays and pictures without triangles.

>>> import superegg as se
>>> scene = se.loads("primitive egg\\nsetCoeff 1 1 1.3\\n")   # or se.load("fits.npz")
>>> img = scene.render(80, 60, samples=4)
>>> img.shape
(60, 80, 3)
>>> hit = scene.intersect([[0, 0, 5]], [[0, 0, -1]])
>>> hit.t
array([3.7])

Conventions: semi-axes; the exponent e shapes the section in the xy plane, n the profile along z;
quaternions are w x y z; matrices and quaternions lead from body to world. All arrays of numbers may be of
any real type, any strides, or lists; answers are float64.
"""

from superegg import _superegg
from superegg._conventions import CONVENTIONS, Convention
from superegg._film import Film
from superegg._fit import COVARIANCE_ROWS, Fit, Residuals, fit, fit_parts
from superegg._hits import Closest, Hits, ShapeHits
from superegg._looks import Camera, Material, PointLight, SpotLight, SunLight
from superegg._meshes import Mesh, SceneMesh
from superegg._scene import FormatWarning, Scene, load, loads
from superegg._shape import Area, Superquadric
from superegg._superegg import FormatError

__version__: str = _superegg.__version__

FORMATS: dict[str, str] = dict(_superegg.formats())
"""The formats of other programs that `load` reads: the names for ``convention``, with what they are."""

COLORMAPS: tuple[str, ...] = tuple(_superegg.colormaps())
"""The colour maps of ``load(color_by=..)``."""

__all__ = [
    "COLORMAPS",
    "CONVENTIONS",
    "COVARIANCE_ROWS",
    "FORMATS",
    "Area",
    "Camera",
    "Closest",
    "Convention",
    "Film",
    "Fit",
    "FormatError",
    "FormatWarning",
    "Hits",
    "Material",
    "Mesh",
    "PointLight",
    "Residuals",
    "Scene",
    "SceneMesh",
    "ShapeHits",
    "SpotLight",
    "SunLight",
    "Superquadric",
    "fit",
    "fit_parts",
    "load",
    "loads",
]
