"""Scenes: read, built, rendered, and hit by rays."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Sequence
from typing import Any, Protocol, Union, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from superegg import _superegg
from superegg._arrays import Floats, column, count, flag, floats, number, points, rays, text, vectors
from superegg._arrays import threads as threads_
from superegg._conventions import convention_of
from superegg._film import Film
from superegg._hits import Bools, Hits
from superegg._looks import Camera, Light, Material, PointLight, SpotLight, SunLight, color_text, material_lines, triple
from superegg._meshes import SceneMesh
from superegg._progress import Progress, shown
from superegg._rotation import placement, quaternions
from superegg._shape import Superquadric

PathLike = Union[str, "os.PathLike[str]"]


@runtime_checkable
class Readable(Protocol):
    """A file that is open."""

    def read(self) -> bytes | str:
        """All of it."""
        ...


_SETTINGS = {
    "samples": "samples",
    "noise": "noise",
    "most_samples": "mostSamples",
    "filter": "filter",
    "exposure": "exposure",
    "tone": "tone",
    "dither": "dither",
    "far_depth": "farDepth",
    "cryptomatte": "cryptomatte",
    "denoise": "denoise",
    "encoding": "encoding",
    "bits": "bits",
    "transparent": "transparent",
    "light": "light",
    "bounces": "bounces",
    "least_weight": "leastWeight",
    "light_rays": "lightRays",
    "gloss_rays": "glossRays",
}


_WORD = re.compile("[A-Za-z0-9]+|[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?|[-+]?inf|nan")
"""A value of a setting: a word, or a number."""

_EXPORTED = frozenset((".stl", ".ply", ".obj", ".glb", ".vtp", ".pov", ".csv", ".nrrd", ".vti"))
"""The endings of files that `Scene.save` exports. Others of `Scene.export` may be those of a scene's text."""


class FormatWarning(UserWarning):
    """What was left out of a file, or cannot be trusted."""


class Scene:
    """A scene: shapes, lights, camera, environment and picture settings.

    A new scene has no shape. `load` reads one. All that the modelling language can do, `run` does.

    Examples
    --------
    >>> import superegg as se
    >>> scene = se.Scene()
    >>> scene.add(se.Superquadric((1, 1, 1.3), (1, 0.9)), color="orange")
    'shape1'
    >>> scene.add(se.Superquadric(0.5), position=(1.5, 0, 0), name="ball")
    'ball'
    >>> scene.look_at((4, -5, 3), up=(0, 0, 1))
    >>> scene.render(80, 60)
    <Film: 80 x 60 pixels>
    >>> scene.intersect([0, 0, 5], [0, 0, -1]).names()
    array('model/shape1', dtype=object)
    """

    def __init__(self, *, _core: _superegg.Scene | None = None, _readings: Sequence[str] = ()) -> None:
        self._core = _superegg.Scene() if _core is None else _core
        self.readings: list[str] = list(_readings)
        """How the numbers of data files were understood, one line a file."""


    # Building.

    def add(
        self,
        shape: Superquadric,
        matrix: ArrayLike | None = None,
        *,
        position: ArrayLike | None = None,
        rotation: Any = None,
        color: Any = None,
        material: Material | None = None,
        name: str | None = None,
    ) -> str:
        """Add a shape.

        Parameters
        ----------
        shape : Superquadric
        matrix : array_like, shape (4, 4), (3, 4) or (3, 3), optional
            The affine map from the shape's space to the world; it must be invertible.
        position : array_like, shape (3,), optional
            The centre, instead of a matrix.
        rotation : optional
            A quaternion w x y z, a matrix of shape (3, 3), or a scipy ``Rotation``, from body to world.
        color : sequence of 3 numbers, or str, optional
            See `Material`, whose colour it replaces.
        material : Material, optional
        name : str, optional
            Default: the first free one of ``shape1``, ``shape2``, ...

        Returns
        -------
        str
            The name.

        Raises
        ------
        ValueError
            A name that is taken, a map that cannot be inverted, or a colour that is none.
        """
        if not isinstance(shape, Superquadric):
            raise TypeError(f"shape: expected a Superquadric, found {type(shape).__name__}")
        if name is not None:
            text(name, "name")
        place = placement(matrix, position, rotation)
        return self._core.add(shape._core, name, place, material_lines(color, material))

    def add_many(
        self,
        positions: ArrayLike,
        radii: ArrayLike,
        exponents: ArrayLike = (1.0, 1.0),
        rotations: Any = None,
        *,
        colors: ArrayLike | None = None,
        material: Material | None = None,
        ids: ArrayLike | None = None,
        convention: str | None = None,
        name: str = "table",
    ) -> str:
        """Add many superquadrics in one call: they are stored as columns, in about 100 bytes each.

        Parameters
        ----------
        positions : array_like, shape (N, 3)
        radii : array_like, shape (N, 3), (3,), (N, 1) or a number
            Semi-axes, or as the convention has them.
        exponents : array_like, shape (N, 2) or (2,)
            e and n, or as the convention has them.
        rotations : optional
            Quaternions w x y z (N, 4), matrices (N, 3, 3), or a scipy ``Rotation``; or as the convention has
            them. One rotation stands for all.
        colors : array_like, shape (N, 3) or (3,), optional
            Linear values in [0, 1]. More than 65,536 different ones are rounded to 64 steps a channel.
        material : Material, optional
            Of all of them.
        ids : array_like of int, shape (N,), optional
            They name the instances: ``p17``. Default: 1 to N.
        convention : str, optional
            Of another program: a key of `superegg.CONVENTIONS`.
        name : str
            The name of the table.

        Returns
        -------
        str
            The name.

        Examples
        --------
        >>> import numpy as np, superegg as se
        >>> scene = se.Scene()
        >>> grid = np.stack(np.meshgrid(*[np.arange(10.0)] * 3), axis=-1).reshape(-1, 3)
        >>> scene.add_many(grid, 0.4, (1, 0.5), name="grains")
        'grains'
        >>> scene.instance_count
        1000
        """
        text(name, "name")
        chosen = convention_of(convention)
        places = vectors(positions, "positions")
        if places.ndim != 2:
            raise ValueError(f"positions: expected shape (N, 3), found shape {places.shape}")
        n = len(places)
        sizes = floats(radii, "radii")
        if sizes.ndim == 0 or (sizes.ndim == 1 and sizes.shape != (3,) and len(sizes) == n):
            sizes = np.repeat(sizes[..., None], 3, axis=-1)
        elif sizes.ndim == 2 and sizes.shape[1] == 1:
            sizes = np.repeat(sizes, 3, axis=1)
        columns = {
            "radii": chosen.radii(sizes),
            "exponents": chosen.own_exponents(exponents),
            "rotations": _turns(rotations, chosen),
        }
        if colors is not None:
            columns["colors"] = _colors(colors)
        for what, array in columns.items():
            if array.shape[:-1] not in ((), (1,), (n,)):
                raise ValueError(
                    f"{what}: expected one row for each of positions {places.shape} or one for all, "
                    f"found shape {array.shape}"
                )
        numbers = None
        if ids is not None:
            try:
                whole = np.asarray(ids)
            except ValueError as error:
                raise ValueError("ids: rows of different lengths make no array") from error
            if (whole.dtype.kind not in "iu" and whole.size > 0) or whole.shape != (n,):
                raise ValueError(f"ids: expected {n} whole numbers, found {whole.dtype} of shape {whole.shape}")
            numbers = [int(i) for i in whole]
            if numbers and not -(2**63) <= min(numbers) <= max(numbers) < 2**63:
                raise ValueError(f"ids: expected numbers below 2^63, found {max(numbers)}")
        flat = {what: column(array, array.shape) for what, array in columns.items()}
        table = {"positions": column(places, places.shape), "colors": None, **flat}
        return self._core.add_table(name, table, numbers, material_lines(None, material))

    def add_light(self, light: Light, name: str | None = None) -> str:
        """Add a light, or replace the one of this name; returns its name.

        Without any light a scene has a white one at (3, 4, 5).
        """
        if not isinstance(light, (PointLight, SpotLight, SunLight)):
            raise TypeError(f"light: expected a PointLight, SpotLight or SunLight, found {type(light).__name__}")
        taken = set(self._core.lights())
        if name is None:
            name = next(free for i in range(1, len(taken) + 2) if (free := f"light{i}") not in taken)
        self._core.run(light.lines(_word(name)))
        return name

    def remove_light(self, name: str) -> None:
        """Remove a light."""
        self._core.run([f"unlight {_word(name)}"])

    @property
    def lights(self) -> list[str]:
        """The names of the lights."""
        return self._core.lights()

    @property
    def camera(self) -> Camera:
        """The camera. A scene that sets none is framed when it is rendered."""
        position, target, up, fov, height, lens = self._core.camera()
        at, towards, above = ((x, y, z) for x, y, z in (position, target, up))
        return Camera(at, towards, above, fov, height, lens)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera):
            raise TypeError(f"camera: expected a Camera, found {type(camera).__name__}")
        self._core.run(camera.lines())

    def look_at(
        self,
        position: ArrayLike,
        target: ArrayLike = (0.0, 0.0, 0.0),
        *,
        up: ArrayLike | None = None,
        fov: float | None = None,
    ) -> None:
        """Place the camera. What is left out stays as it is.

        Parameters
        ----------
        position, target, up : array_like, shape (3,)
        fov : float
            The vertical field of view, in degrees.
        """
        now = self.camera
        angle = number(now.fov if fov is None else fov, "fov")
        lines = [f"camera {triple(position, 'position')} {triple(target, 'target')} {angle!r}"]
        lines.append(f"cameraUp {triple(now.up if up is None else up, 'up')}")
        self._core.run(lines)

    def frame(self, width: int = 4, height: int = 3) -> None:
        """Place the camera, and a light if there is none, so that all is in sight.

        `render` does this in its own copy of a scene that sets no camera and is not in sight of the default
        one. A scene that sets its camera stays as it is.

        Parameters
        ----------
        width, height : int
            The size of the picture, of which the shape counts.
        """
        self._core.frame(_side(width, "width"), _side(height, "height"))

    def set(self, **settings: Any) -> None:
        """Change settings of the picture: those of `settings`.

        Examples
        --------
        >>> import superegg as se
        >>> scene = se.Scene()
        >>> scene.set(samples=16, tone="filmic")
        >>> scene.settings["samples"], scene.settings["tone"]
        ('16', 'filmic')
        """
        self._core.run(_setting_lines(settings))

    @property
    def settings(self) -> dict[str, str]:
        """The settings of the picture, as text."""
        lines = [f"get {theirs}" for theirs in _SETTINGS.values()]
        printed = self._core.run(lines)
        return {ours: _value(text) for ours, text in zip(_SETTINGS, printed, strict=True)}

    def set_background(self, color: ArrayLike) -> None:
        """Set the linear colour of rays that hit nothing."""
        self._core.run([f"background {triple(color, 'color')}"])

    def set_sky(
        self, horizon: ArrayLike, zenith: ArrayLike | None = None, up: ArrayLike | None = None
    ) -> None:
        """Set the sky: one colour, or a gradient from the horizon to the zenith. Linear values."""
        line = f"sky {triple(horizon, 'horizon')} {triple(horizon if zenith is None else zenith, 'zenith')}"
        self._core.run([line if up is None else f"{line} {triple(up, 'up')}"])

    def set_daylight(self, elevation: float, turbidity: float = 3.0, azimuth: float = 0.0) -> None:
        """Set sun and sky as light of the surroundings, for ``light="path"``.

        Parameters
        ----------
        elevation : float
            The angle of the sun above the horizon in degrees, 0 to 90.
        turbidity : float
            The haze of the air, 1.7 to 10: 2 is clear, 6 hazy.
        azimuth : float
            The angle of the sun to the right of the direction -z (y, if z is up), in degrees.
        """
        numbers = (number(elevation, "elevation"), number(turbidity, "turbidity"), number(azimuth, "azimuth"))
        self._core.run([f"daylight {' '.join(repr(x) for x in numbers)}"])

    def set_environment(self, path: PathLike, rotation: float = 0.0, scale: float = 1.0) -> None:
        """Set a picture of the surroundings (.hdr or .exr, equirectangular), which is read when the scene is rendered.

        Parameters
        ----------
        path : str or path
            The picture.
        rotation : float
            The angle by which it is turned to the right around the up direction, in degrees.
        scale : float
            The factor of its values.
        """
        name = os.fsdecode(path)
        if '"' in name or "\n" in name:
            raise ValueError(f"path: a scene cannot name a file with a quotation mark or a line break, found {name!r}")
        line = f'environment "{name}" {number(rotation, "rotation")!r} {number(scale, "scale")!r}'
        self._core.run([line])

    def set_floor(self, height: float, up: ArrayLike | None = None, *, material: Material | None = None) -> None:
        """Add an infinite floor at this height along its normal ``up``."""
        surface, root = "floor_surface", self.root
        lines = [f"primitive {surface}", *material_lines(None, material)]
        lines.append(f"floor {number(height, 'height')!r} {surface}")
        if up is not None:
            lines.append(f"floorUp {triple(up, 'up')}")
        self._core.run(lines)
        if root is not None:
            self._core.show(root)

    def set_ambient_occlusion(self, samples: int, distance: float) -> None:
        """Set ambient occlusion: rays from each point, and how far they look. 0 samples turn it off."""
        line = f"ambientOcclusion {count(samples, 'samples')} {number(distance, 'distance')!r}"
        self._core.run([line])

    def run(self, text: str) -> str:
        """Carry out lines of the modelling language, all or none; returns what they print.

        Raises
        ------
        FormatError
            A line is wrong; ``line`` of the error is its number.

        Examples
        --------
        >>> import superegg as se
        >>> scene = se.Scene()
        >>> scene.run('''primitive egg
        ... setCoeff 1 1 1.3
        ... object nest
        ... addPrimitive egg''')
        ''
        >>> scene.root
        'nest'
        """
        if not isinstance(text, str):
            raise TypeError(f"text: expected lines of the modelling language, found {type(text).__name__}")
        return "\n".join(self._core.run(re.split("\r\n|\n|\r", text)))

    # Keyframes.

    def key(self, frame: float, line: str) -> None:
        """Set a key: what a line of the modelling language sets at a frame. Between keys numbers follow a smooth curve.

        The line is about what is selected: `root`, and the child at its cursor.

        Parameters
        ----------
        frame : float
        line : str
            A command with numbers, such as ``"rotate z 90"`` or ``"camera 3 4 5 0 0 0"``.

        Raises
        ------
        FormatError
            The line is wrong, or no key can be set with it.

        Examples
        --------
        >>> import superegg as se
        >>> scene = se.Scene()
        >>> _ = scene.add(se.Superquadric((1, 1, 2)), name="egg")
        >>> scene.key(0, "translate 0 0 0")
        >>> scene.key(10, "translate 4 0 0")
        >>> scene.key_frames
        [0.0, 10.0]
        >>> scene.at(5).bounds[:, 0].round(6)
        array([1., 3.])
        """
        if "\n" in text(line, "line"):
            raise ValueError(f"line: expected one line, found {line!r}")
        self._core.run([f"key {number(frame, 'frame')!r} {line}"])

    @property
    def key_frames(self) -> list[float]:
        """The frames that have keys, sorted."""
        return self._core.key_frames()

    def at(self, frame: float) -> Scene:
        """The scene at a frame of its keys, without them: for a picture, a mesh or rays."""
        return _scene_of(self._core.at(number(frame, "frame")), self.readings)

    # What there is.

    @property
    def root(self) -> str | None:
        """The name of the object, table or primitive that is shown."""
        return self._core.root

    @root.setter
    def root(self, name: str) -> None:
        self._core.show(text(name, "root"))

    def names(self) -> dict[str, str]:
        """The names of what the scene has, each with its kind: primitive, object or table."""
        return dict(self._core.names())

    def table(self, name: str | None = None) -> dict[str, NDArray[Any]]:
        """The columns of a table of instances, in our conventions.

        Parameters
        ----------
        name : str, optional
            Default: the only table.

        Returns
        -------
        dict
            ``positions`` (N, 3), ``radii`` (N, 3), ``exponents`` (N, 2), ``rotations`` (N, 4) as w x y z,
            ``colors`` (N, 3), ``ids`` (N,).
        """
        if name is None:
            tables = [table for table, kind in self._core.names() if kind == "table"]
            if len(tables) != 1:
                raise KeyError(f"the scene has {len(tables)} tables; name one of {tables}")
            name = tables[0]
        columns: dict[str, NDArray[Any]] = self._core.table(text(name, "name"))
        for what, width in (("positions", 3), ("radii", 3), ("exponents", 2), ("rotations", 4), ("colors", 3)):
            columns[what] = columns[what].reshape((-1, width))
        columns["rotations"] = np.roll(columns["rotations"], 1, axis=-1)
        return columns

    @property
    def instance_count(self) -> int:
        """The number of instances that rays can hit."""
        text = self._core.instance_count()
        return int(text) if text.isdigit() else int(float(text))

    @property
    def bounds(self) -> Floats | None:
        """The box around all of it, shape (2, 3), up to 1e-6 of its size too large.

        ``None`` for a scene without shapes.
        """
        bounds = self._core.bounds()
        return None if bounds is None else np.array(bounds)

    def primitive_name(self, index: int) -> str | None:
        """The name of a primitive by `Hits.primitive`."""
        which = count(index, "index")
        return None if which >= 2**32 else self._core.primitive_name(which)

    # Rays and points.

    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike | None = None,
        t_max: ArrayLike | None = None,
        uv: bool = False,
        threads: int = 0,
    ) -> Hits:
        """The closest hit of each ray ``origin + t direction``.

        Parameters
        ----------
        origins, directions : array_like, shape (..., 3)
            They broadcast. A direction need not have length 1; one of 0 hits nothing.
        t_min, t_max : array_like, optional
            Hits count for ``t_min <= t < t_max``; default: from 0 on.
        uv : bool
            Whether hits have longitude and latitude, which take time; otherwise they are nan.
        threads : int
            0 for one for each core.

        Returns
        -------
        Hits

        Raises
        ------
        ValueError
            Shapes that do not broadcast, or numbers that are not finite.
        """
        start, way, least, most, shape = rays(origins, directions, t_min, t_max)
        query = threads_(threads), bool(uv)
        return Hits(tuple(self._core.intersect(start, way, least, most, query)), shape)

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike | None = None,
        t_max: ArrayLike | None = None,
        threads: int = 0,
    ) -> Bools:
        """Whether each ray hits anything for ``t_min <= t < t_max``, shape (...): faster than a hit."""
        start, way, least, most, shape = rays(origins, directions, t_min, t_max)
        found = self._core.occluded(start, way, least, most, threads_(threads))
        return found.reshape(shape)

    def inside(self, points_: ArrayLike, /, *, threads: int = 0) -> Bools:
        """Whether points of shape (..., 3) are inside any shape, shape (...)."""
        at, shape = points(points_)
        return self._core.inside(at, threads_(threads)).reshape(shape)

    def signed_distance(self, points_: ArrayLike, /, *, threads: int = 0) -> Floats:
        """The distance to the nearest surface, shape (...) for points of shape (..., 3).

        Outside of all shapes it is exact. Inside it is minus the greatest depth in any one shape: where
        shapes overlap, the surface of the union is at least that far. A scene without shapes is at inf.
        """
        at, shape = points(points_)
        return self._core.signed_distance(at, threads_(threads))[0].reshape(shape)

    # Pictures and files.

    def render(
        self,
        width: int | None = None,
        height: int | None = None,
        *,
        output: str = "light",
        layers: bool = True,
        threads: int = 0,
        progress: Progress = None,
        **settings: Any,
    ) -> Film:
        """Render a picture, the same as the program's to the bit.

        Parameters
        ----------
        width, height : int, optional
            Pixels; default: those of the scene.
        output : str
            ``light``, ``normal``, ``depth``, ``albedo``, ``id``, ``steps`` or ``occlusion``: what the picture shows.
        layers : bool
            Whether the film keeps depth, normal, albedo and instance id beside light.
        threads : int
            0 for one for each core. The picture does not depend on it.
        progress : bool or callable, optional
            ``True`` for a bar (of tqdm if it is installed), or a function of the finished and all pixels.
        **settings
            Of this picture alone: ``samples``, ``noise``, ``exposure``, ``tone``, ... as in `settings`.

        Returns
        -------
        Film

        Raises
        ------
        ValueError
            A size of 0 or too large, or a setting that is out of range.
        KeyboardInterrupt
            Ctrl-c stops the render within a second.
        """
        size = None
        if width is not None or height is not None:
            if width is None or height is None:
                raise ValueError(f"give both width and height, found {width} and {height}")
            size = _side(width, "width"), _side(height, "height")
        request = {"size": size, "output": text(output, "output"), "layers": flag(layers, "layers"), "lines": _setting_lines(settings)}
        with shown(progress) as tick:
            core = self._core.render(request, threads_(threads), tick)
        return Film(core)

    def view(self, width: int = 480, height: int = 360, *, where: str = "kernel", **settings: Any) -> Any:
        """A picture in a notebook that a drag turns and the wheel zooms; needs anywidget.

        The widget shows a copy of the scene, coarse while it moves and then in full; its ``camera`` is the view, so
        ``scene.camera = view.camera`` takes it over.

        Parameters
        ----------
        width, height : int
            Pixels.
        where : str
            ``kernel``: this process traces the rays. ``browser``: the browser does, by the same engine in
            WebAssembly, so that the view turns while a cell runs and the kernel is far away. Its ``text``,
            ``files``, ``frame``, ``output``, ``size`` and ``camera`` can be set and observed, and ``hit`` is that of
            the last click: t, point, normal, path, primitive, steps.
        **settings
            Of the full picture: ``samples``, ``exposure``, ... as in `settings`.

        Raises
        ------
        ImportError
            anywidget is not installed.
        FileNotFoundError
            With ``where="browser"``: this wheel was built without the module for browsers, and the environment
            variable ``SUPEREGG_WEB`` names none.
        """
        from superegg._view import view

        sides = _side(width, "width"), _side(height, "height")
        if where == "kernel":
            return view(self, *sides, settings)
        if where == "browser":
            from superegg._browser import browser_view

            return browser_view(self, *sides, settings)
        raise ValueError(f"where: expected 'kernel' or 'browser', found {where!r}")

    def to_text(self) -> str:
        """The scene in the modelling language."""
        return self._core.text()

    def to_bytes(self) -> bytes:
        """The scene as a binary file (.sqb), which is small for tables."""
        return self._core.to_bytes()

    def save(self, path: PathLike) -> None:
        """Write the scene.

        ``.sqb`` in binary; ``.stl``, ``.ply``, ``.obj``, ``.glb``, ``.vtp``, ``.pov``, ``.csv``, ``.nrrd`` and
        ``.vti`` as `export` does; anything else as text (``.scn``). Textures and surroundings get the names by which
        they are found from there.
        """
        name = os.fspath(path)
        ending = os.path.splitext(name)[1].lower()
        if ending in _EXPORTED:
            self.export(name)
            return
        folder = os.path.dirname(name)
        data = self._core.to_bytes(folder) if ending == ".sqb" else self._core.text(folder).encode()
        with open(name, "wb") as file:
            file.write(data)

    def export(
        self,
        path: PathLike,
        *,
        tolerance: float = 1e-3,
        absolute: bool = False,
        double: bool = False,
        grid: int = 64,
        value: str = "distance",
        depth: int | None = None,
    ) -> list[str]:
        """Write the scene for another program, in the format of the file's ending.

        Parameters
        ----------
        path : str or path
            ``.stl``, ``.ply``, ``.obj``, ``.glb``: meshes; ``.vtp``: particles for OVITO and ParaView; ``.pov``;
            ``.liggghts``, ``.data``: LIGGGHTS; ``.txt``, ``.npy``: EMS vectors; ``.csv``; ``.nrrd``, ``.vti``: grids.
        tolerance : float
            The greatest distance between a mesh and the exact surface, as a part of each instance's largest
            semi-axis; in world units with ``absolute``.
        double : bool
            Whether .ply and .obj get float64 coordinates.
        grid : int
            The samples of a grid along its longest side, 4 to 512.
        value : str
            The value of a grid: ``distance`` (negative inside) or ``inside-outside``.
        depth : int, optional
            The levels that objects are opened, 0 to 64; default: that of the scene.

        Returns
        -------
        list of str
            What the format loses, one sentence each.

        Raises
        ------
        ValueError
            An unknown ending, an empty scene, or more triangles than a file may have.
        """
        name = os.fspath(path)
        request = _export_request(tolerance, absolute, depth)
        request |= {"double": flag(double, "double"), "grid": count(grid, "grid"), "value": text(value, "value")}
        data, materials, losses = self._core.export(name, request)
        if materials is not None:
            with open(os.path.splitext(name)[0] + ".mtl", "wb") as file:
                file.write(materials)
        with open(name, "wb") as file:
            file.write(data)
        return losses

    def mesh(self, tolerance: float = 1e-2, *, absolute: bool = False, depth: int | None = None) -> SceneMesh:
        """The triangles of all instances in world coordinates.

        Parameters
        ----------
        tolerance : float
            The greatest distance between mesh and exact surface, as a part of each instance's largest
            semi-axis; in world units with ``absolute``.
        depth : int, optional
            The levels that objects are opened, 0 to 64; default: that of the scene.

        Raises
        ------
        ValueError
            An empty scene, or more than 20,000,000 triangles.

        Examples
        --------
        >>> import superegg as se
        >>> scene = se.Scene()
        >>> _ = scene.add(se.Superquadric(1), name="ball", position=(2, 0, 0))
        >>> mesh = scene.mesh(0.01)
        >>> bool(mesh.vertices[:, 0].min() >= 1.0), mesh.names
        (True, ['model/ball'])
        """
        vertices, normals, faces, instance, names, colors = self._core.mesh(
            _export_request(tolerance, absolute, depth)
        )
        return SceneMesh(
            vertices.reshape((-1, 3)),
            faces.reshape((-1, 3)),
            normals.reshape((-1, 3)),
            instance,
            names,
            colors.reshape((-1, 3)),
        )

    def to_trimesh(self, tolerance: float = 1e-2) -> Any:
        """The mesh as a ``trimesh.Trimesh`` with a colour for each face; needs trimesh."""
        return self.mesh(tolerance).to_trimesh()

    def to_open3d(self, tolerance: float = 1e-2) -> Any:
        """The mesh as an ``open3d.geometry.TriangleMesh``; needs open3d."""
        return self.mesh(tolerance).to_open3d()

    def to_pyvista(self, tolerance: float = 1e-2) -> Any:
        """The mesh as a ``pyvista.PolyData``; needs pyvista."""
        return self.mesh(tolerance).to_pyvista()

    def copy(self) -> Scene:
        """A copy, which shares its content: it takes no time."""
        return _scene_of(self._core.copy(), self.readings)

    def __copy__(self) -> Scene:
        return self.copy()

    def __deepcopy__(self, memo: Any) -> Scene:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.to_bytes(), self._core.data_bounds(), self.readings)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self.to_bytes() == other.to_bytes()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<Scene: {self.root!r}, {len(self._core.names())} names>"


def load(
    files: PathLike | Iterable[PathLike] | Readable,
    *,
    convention: str | None = None,
    columns: str | None = None,
    frame: int | None = None,
    color_by: str | None = None,
    colormap: str | None = None,
    range: tuple[float, float] | None = None,
    type_colors: bool = False,
    min_axis: float | None = None,
    point_radius: float | None = None,
    images: tuple[int, int, int] | None = None,
    box: bool = False,
) -> Scene:
    """Read a scene (.scn, .sqb) or data of another program: everything that ``superegg import`` reads.

    Parameters
    ----------
    files : path, paths, or a file open for bytes
        Several data files become one scene. The format is found by the content, not by the name.
    convention : str, optional
        Take the data as this format: a key of `superegg.FORMATS`. Needed only where the content leaves a
        doubt, as for SuperDec against others.
    columns : str, optional
        The columns of a table: ``"position=x,y,z;semi-axes=a,b,c;exponents=e,n;quaternion=w,x,y,z"``.
    frame : int, optional
        Of a file with several, from 0; default: the first that is not empty.
    color_by : str, optional
        Colour by a numeric column, ``speed``, ``force``, ``id``, or names joined by commas.
    colormap : str, optional
        A key of `superegg.COLORMAPS`; default: viridis.
    range : two numbers, optional
        The values at the ends of the colour map; default: those of the data.
    type_colors : bool
        Colour by the column ``type``.
    min_axis : float, optional
        Raise smaller semi-axes to this.
    point_radius : float, optional
        The radius of the spheres that stand for points; default: from their spacing.
    images : three ints, optional
        Repeat a periodic box along its edges, 1 to 64 times.
    box : bool
        Show the edges of the simulation box.

    Returns
    -------
    Scene
        ``readings`` says how the numbers were understood. What was left out is a `FormatWarning`.

    Raises
    ------
    FormatError
        A file is in no known format, in one of several, or wrong: see its ``file`` and ``line``.
    OSError
        A file cannot be read.
    """
    keywords = _keywords(locals())
    if isinstance(files, (str, os.PathLike)):
        names = [os.fspath(files)]
    elif isinstance(files, Readable):
        return loads(files.read(), name=str(getattr(files, "name", "data")), **keywords)
    elif isinstance(files, Iterable):  # pyright: ignore[reportUnnecessaryIsInstance]
        names = [os.fspath(path) for path in files]
    else:
        raise TypeError(f"files: expected a path, paths or an open file, found {type(files).__name__}")
    if not names:
        raise ValueError("expected a file, found an empty sequence")
    for name in names:
        if os.path.isdir(name):
            raise IsADirectoryError(21, "it is a folder", name)
    return _loaded(*_superegg.load_files(names, keywords))


def loads(data: str | bytes, *, name: str = "text", **keywords: Any) -> Scene:
    """Read a scene or data from text or bytes.

    Parameters
    ----------
    data : str or bytes
        Lines of the modelling language, or what a data file has.
    name : str
        Stands for the file in messages.
    **keywords
        Those of `load`.

    Examples
    --------
    >>> import superegg as se
    >>> scene = se.loads("primitive egg\\nsetCoeff 1 1 1.3\\n")
    >>> scene.root
    'egg'
    >>> se.loads("primitive egg\\nsetCoeff 1 1\\n", name="egg.scn")
    Traceback (most recent call last):
    ...
    superegg.FormatError: egg.scn:2:...
    """
    if isinstance(data, str):
        content = data.encode()
    elif isinstance(data, (bytes, bytearray, memoryview)):
        content = bytes(data)
    else:
        raise TypeError(f"data: expected a text or bytes, found {type(data).__name__}")
    text(name, "name")
    return _loaded(*_superegg.load_bytes(name, content, _keywords(keywords)))


_LOAD_KEYWORDS = (
    "convention",
    "columns",
    "frame",
    "color_by",
    "colormap",
    "range",
    "type_colors",
    "min_axis",
    "point_radius",
    "images",
    "box",
)


def _keywords(given: dict[str, Any]) -> dict[str, Any]:
    """The keywords of a load that are given, checked."""
    unknown = set(given) - set(_LOAD_KEYWORDS) - {"files"}
    if unknown:
        raise TypeError(f"unexpected keywords {sorted(unknown)}; known are {', '.join(_LOAD_KEYWORDS)}")
    keywords = {name: given[name] for name in _LOAD_KEYWORDS if given.get(name) is not None}
    for name in ("convention", "columns", "color_by", "colormap"):
        if name in keywords:
            text(keywords[name], name)
    for name in ("type_colors", "box"):
        if name in keywords:
            keywords[name] = flag(keywords[name], name)
    for name in ("min_axis", "point_radius"):
        if name in keywords:
            keywords[name] = number(keywords[name], name)
            if keywords[name] <= 0:
                raise ValueError(f"{name}: expected a number above 0, found {keywords[name]}")
    if "range" in keywords:
        ends = floats(keywords["range"], "range")
        if ends.shape != (2,):
            raise ValueError(f"range: expected two numbers, found an array of shape {ends.shape}")
        keywords["range"] = [float(x) for x in ends]
    if "images" in keywords:
        try:
            counts = [count(i, "images", 1) for i in keywords["images"]]
        except TypeError:
            raise TypeError(f"images: expected three counts from 1 to 64, found {keywords['images']!r}") from None
        if len(counts) != 3 or max(counts) > 64:
            raise ValueError(f"images: expected three counts from 1 to 64, found {counts}")
        keywords["images"] = counts
    if "frame" in keywords:
        keywords["frame"] = count(keywords["frame"], "frame")
    return keywords


def _loaded(core: _superegg.Scene, readings: list[str], found: list[str]) -> Scene:
    for text in found:
        warnings.warn(text, FormatWarning, stacklevel=3)
    return _scene_of(core, readings)


def _scene_of(core: _superegg.Scene, readings: Sequence[str]) -> Scene:
    return Scene(_core=core, _readings=readings)


def _restored(data: bytes, bounds: Any, readings: list[str]) -> Scene:
    core, _, _ = _superegg.load_bytes("pickle", data, {})
    core.set_data_bounds(bounds)
    return _scene_of(core, readings)


def _turns(rotations: Any, chosen: Any) -> Floats:
    if rotations is None:
        return np.array([0.0, 0.0, 0.0, 1.0])
    plain = chosen.euler is None and not chosen.from_world and chosen.quaternion == "wxyz"
    return quaternions(rotations if plain else chosen.rotations(rotations, "rotations"))


def _colors(colors: ArrayLike) -> Floats:
    if isinstance(colors, str):
        raise ValueError(f"colors: expected linear values of shape (N, 3), found the text {color_text(colors)!r}")
    array = vectors(colors, "colors")
    if array.size and (array.min() < 0.0 or array.max() > 1.0):
        raise ValueError(f"colors: expected values from 0 to 1, found {array.min()} to {array.max()}")
    return array


def _setting_lines(settings: dict[str, Any]) -> list[str]:
    lines: list[str] = []
    for name, value in settings.items():
        if name == "size":
            try:
                width, height = value
            except (TypeError, ValueError):
                raise ValueError(f"size: expected width and height in pixels, found {value!r}") from None
            lines.append(f"set size {_side(width, 'width')}x{_side(height, 'height')}")
        elif name not in _SETTINGS:
            raise TypeError(f"there is no setting {name!r}; choose one of size, {', '.join(_SETTINGS)}")
        elif value is not None:
            word = ("on" if value else "off") if isinstance(value, (bool, np.bool_)) else str(value)
            if not _WORD.fullmatch(word):
                raise ValueError(f"{name}: expected a word or a number, found {value!r}")
            lines.append(f"set {_SETTINGS[name]} {word}")
    return lines


def _export_request(tolerance: float, absolute: bool, depth: int | None) -> dict[str, Any]:
    """The settings of an export, those of other formats at their defaults."""
    levels = None if depth is None else count(depth, "depth")
    if levels is not None and levels > 64:
        raise ValueError(f"depth: expected 0 to 64, found {levels}")
    tolerance = number(tolerance, "tolerance")
    if not tolerance > 0:
        raise ValueError(f"tolerance: expected a number above 0, found {tolerance}")
    return {
        "depth": levels,
        "tolerance": tolerance,
        "absolute": flag(absolute, "absolute"),
        "double": False,
        "grid": 64,
        "value": "distance",
    }


def _side(value: Any, name: str) -> int:
    side = count(value, name)
    if not 1 <= side <= 32768:
        raise ValueError(f"{name}: expected 1 to 32768 pixels, found {side}")
    return side


def _value(text: str) -> str:
    """The value in what `get` prints: name, value, meaning."""
    return text.split()[1]


def _word(name: str) -> str:
    text(name, "name")
    if not name or any(c.isspace() or c == "#" for c in name):
        raise ValueError(f"{name!r} cannot be a name: a name is one word without blanks and #")
    return name
