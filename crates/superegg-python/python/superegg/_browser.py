"""A view of a scene in a notebook whose rays the browser traces, by the engine in WebAssembly. It needs anywidget."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from superegg._looks import Camera

if TYPE_CHECKING:
    from superegg._scene import Scene

SCRIPT = "widget.js"
MODULE = "superegg.wasm.gz"
CARRIED = Path(__file__).with_name("web")
"""The folder that a wheel carries if the module was built before it."""


def browser_view(scene: Scene, width: int, height: int, settings: dict[str, Any]) -> Any:
    """The widget of a scene."""
    try:
        widget = _widget()
    except ImportError as error:
        raise ImportError("Scene.view needs anywidget: pip install anywidget") from error
    shown = scene.copy()
    output = settings.pop("output", "light")
    # As the kernel's view: framed for this shape, and with the field of view of this shape.
    shown.frame(width, height)
    shown.set(size=(width, height), **settings)
    return widget(Assets.found(), shown, (width, height), output)


@dataclass(frozen=True)
class Assets:
    """The script of the widget and the compressed module: in a folder, or at an address."""

    base: str | Path

    @staticmethod
    def found() -> Assets:
        """Those that ``SUPEREGG_WEB`` names, or else those of the wheel."""
        given = os.environ.get("SUPEREGG_WEB", "")
        if given.startswith(("https://", "http://")):
            return Assets(given.rstrip("/"))
        folder = Path(given).expanduser() if given else CARRIED
        missing = [name for name in (SCRIPT, MODULE) if not (folder / name).is_file()]
        if not missing:
            return Assets(folder)
        if given:
            raise FileNotFoundError(f"SUPEREGG_WEB names '{given}', which has no {' and no '.join(missing)}")
        raise FileNotFoundError(
            "this wheel was built without the module for browsers; scene.view() without where='browser' needs none. "
            "Set SUPEREGG_WEB to a folder or an address that has widget.js and superegg.wasm.gz, or build them with "
            "crates/superegg-web/build.sh --widget before the wheel"
        )

    @property
    def script(self) -> str:
        """The text of the script, or its address."""
        if isinstance(self.base, Path):
            return (self.base / SCRIPT).read_text()
        return f"{self.base}/{SCRIPT}"

    @property
    def module_address(self) -> str:
        """The address of the module; empty where this process sends it."""
        return "" if isinstance(self.base, Path) else f"{self.base}/{MODULE}"

    def module(self) -> bytes:
        """The compressed module."""
        if not isinstance(self.base, Path):
            raise FileNotFoundError(f"the module is at {self.module_address}")
        return (self.base / MODULE).read_bytes()


@dataclass(frozen=True)
class Hit:
    """The hit of a click.

    Parameters
    ----------
    t : float
        The distance from the camera, in world units.
    point, normal : tuple of 3 floats
        The point and the outward unit normal.
    path : str
        Names from the root down, joined by ``/``.
    primitive : str
        The primitive.
    steps : int, optional
        Newton steps; ``None`` for a shape that is not convex.
    """

    t: float
    point: tuple[float, ...]
    normal: tuple[float, ...]
    path: str
    primitive: str
    steps: int | None


def hit_of(record: Mapping[str, Any] | None) -> Hit | None:
    """The hit of a record from the browser; ``None`` for a miss."""
    if record is None:
        return None
    steps = record["steps"]
    return Hit(
        t=float(record["t"]),
        point=tuple(float(x) for x in record["point"]),
        normal=tuple(float(x) for x in record["normal"]),
        path=str(record["path"]),
        primitive=str(record["primitive"]),
        steps=None if steps is None else int(steps),
    )


def numbers_of(camera: Camera) -> list[float]:
    """Position, target, up, field of view, and the height of an orthographic picture or 0."""
    return [
        *(float(x) for vector in (camera.position, camera.target, camera.up) for x in vector),
        float(camera.fov),
        float(camera.ortho_height or 0.0),
    ]


def camera_of(numbers: list[float], before: Camera) -> Camera:
    """The camera of those numbers, with the lens of another one."""
    px, py, pz, tx, ty, tz, ux, uy, uz, fov, height = (float(x) for x in numbers)
    return replace(
        before,
        position=(px, py, pz),
        target=(tx, ty, tz),
        up=(ux, uy, uz),
        fov=fov,
        ortho_height=height if height > 0.0 else None,
    )


def content_of(scene: Scene) -> dict[str, Any]:
    """The traits that a scene sets: its text, or where that would be long for its tables a binary file, and its pictures."""
    has_tables = "table" in scene.names().values()
    return {
        "text": "" if has_tables else scene.to_text(),
        "binary": scene.to_bytes() if has_tables else b"",
        "files": pictures_of(scene),
        "camera": scene.camera,
    }


def pictures_of(scene: Scene) -> dict[str, bytes]:
    """The picture files that a scene names and that can be read; the widget says which are missing."""
    return {name: path.read_bytes() for name, path in scene._core.picture_files() if path.is_file()}


@cache
def _widget() -> Any:
    """The class of the widget. anywidget is imported once it is needed."""
    import anywidget  # type: ignore[import-not-found,unused-ignore]
    import traitlets  # type: ignore[import-not-found,unused-ignore]

    def camera_from(numbers: list[float] | None, widget: Any) -> Camera:
        before: Camera = widget.camera
        return before if numbers is None else camera_of(numbers, before)

    class BrowserView(anywidget.AnyWidget):  # type: ignore[misc,unused-ignore]
        """A picture of a scene that a drag turns and the wheel zooms, ray traced in the browser."""

        text = traitlets.Unicode().tag(sync=True)
        binary = traitlets.Bytes().tag(sync=True)
        files = traitlets.Dict().tag(sync=True)
        frame = traitlets.Float(None, allow_none=True).tag(sync=True)
        size = traitlets.Tuple((480, 360)).tag(sync=True)
        output = traitlets.Enum(("light", "normal", "depth", "albedo", "id", "steps", "occlusion"), "light").tag(sync=True)
        camera = traitlets.Instance(Camera).tag(
            sync=True, to_json=lambda camera, _widget: numbers_of(camera), from_json=camera_from
        )
        hit = traitlets.Instance(Hit, allow_none=True).tag(
            sync=True,
            to_json=lambda hit, _widget: None if hit is None else dict(vars(hit)),
            from_json=lambda record, _widget: hit_of(record),
        )
        note = traitlets.Unicode().tag(sync=True)
        module = traitlets.Unicode().tag(sync=True)

        def __init__(self, assets: Assets, scene: Scene, size: tuple[int, int], output: str) -> None:
            content = content_of(scene)
            self._given = scene, content["text"], content["binary"]
            super().__init__(_esm=assets.script, module=assets.module_address, size=size, output=output, **content)
            self._assets = assets
            self.on_msg(self._receive)

        @traitlets.observe("text")  # type: ignore[untyped-decorator,unused-ignore]
        def _text_is_set(self, change: Any) -> None:
            if change.new:
                self.binary = b""

        @property
        def scene(self) -> Scene:
            """A copy of the scene that is shown; assign one to show it."""
            from superegg._scene import loads

            given, text, binary = self._given
            if (text, binary) == (self.text, self.binary):
                copy: Scene = given.copy()
                return copy
            return loads(self.binary or self.text, name="scene")

        @scene.setter
        def scene(self, scene: Scene) -> None:
            content = content_of(scene)
            # The scene knows the folder of its file, where its pictures are.
            self._given = scene.copy(), content["text"], content["binary"]
            with self.hold_sync():
                for name, value in content.items():
                    setattr(self, name, value)

        def _receive(self, _widget: Any, content: dict[str, Any], _buffers: Any) -> None:
            if content.get("kind") == "module":
                self.send({"kind": "module"}, buffers=[self._assets.module()])

    return BrowserView
