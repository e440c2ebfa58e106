"""A picture of a scene in a notebook that can be turned. It needs anywidget."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from superegg._looks import Camera

if TYPE_CHECKING:
    from superegg._scene import Scene

Vector = NDArray[np.float64]

COARSE_SECONDS = 0.08
"""The time of a picture while the scene moves."""
COARSEST = 8
"""The most pixels of the widget, in each direction, that one pixel covers."""


def view(scene: Scene, width: int, height: int, settings: dict[str, Any]) -> Any:
    """The widget of a scene."""
    try:
        widget = _widget()
    except ImportError as error:
        raise ImportError("Scene.view needs anywidget: pip install anywidget") from error
    return widget(ViewState(scene, width, height, settings))


class ViewState:
    """The camera of a view, and its pictures: a widget without its window."""

    def __init__(self, scene: Scene, width: int, height: int, settings: dict[str, Any]) -> None:
        self.scene = scene.copy()
        self.scene.frame(width, height)
        self.size = width, height
        self.settings = settings
        self.camera = self.scene.camera
        self._drag: tuple[int, Camera] | None = None
        self._pixels_a_second = 2e5

    def receive(self, message: dict[str, Any]) -> bytes:
        """Changes the camera as the window asks, and returns the picture."""
        kind = message["kind"]
        is_last = kind == "sharpen"
        if kind == "turn":
            number, is_last = int(message["drag"]), bool(message["last"])
            if self._drag is None or self._drag[0] != number:
                self._drag = number, self.camera
            self.camera = turned(self._drag[1], _on_ball(message["from"]), _on_ball(message["to"]))
        elif kind == "zoom":
            self.camera = zoomed(self.camera, float(message["factor"]))
        return self.picture() if is_last else self.coarse()

    def picture(self) -> bytes:
        """The picture in full, as a PNG file."""
        return self._render(*self.size, self.settings)

    def coarse(self) -> bytes:
        """A smaller picture of one sample, which takes a moment."""
        width, height = self.size
        side = math.sqrt(width * height / (self._pixels_a_second * COARSE_SECONDS))
        side = min(max(math.ceil(side), 1), COARSEST)
        small = max(width // side, 1), max(height // side, 1)
        start = time.perf_counter()
        png = self._render(*small, {**self.settings, "samples": 1})
        seconds = max(time.perf_counter() - start, 1e-6)
        self._pixels_a_second = 0.5 * (self._pixels_a_second + small[0] * small[1] / seconds)
        return png

    def _render(self, width: int, height: int, settings: dict[str, Any]) -> bytes:
        self.scene.camera = self.camera
        return self.scene.render(width, height, layers=False, **settings).to_png()


def turned(camera: Camera, start: Vector, end: Vector) -> Camera:
    """The camera after a drag over Shoemake's ball, from one point of the unit sphere to another.

    The scene turns by the quaternion ``(a . b, a x b)`` in the axes of the screen, and so the camera turns back.
    """
    axis, cosine = np.cross(start, end), float(start @ end)
    if not axis.any():
        return camera
    away = np.asarray(camera.position, float) - np.asarray(camera.target, float)
    back = away / np.linalg.norm(away)
    right = np.cross(np.asarray(camera.up, float), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    world_from_screen = np.stack([right, up, back], axis=1)
    # A point x of the world becomes (w^2 - v.v) x + 2 (v.x) v + 2 w (v cross x); the camera, with -w, the inverse.
    v = world_from_screen @ axis
    w = -cosine

    def rotate(x: Vector) -> Vector:
        rotated: Vector = (w * w - v @ v) * x + 2 * (v @ x) * v + 2 * w * np.cross(v, x)
        return rotated / (w * w + v @ v)

    position = np.asarray(camera.target, float) + rotate(away)
    return _moved(camera, position, rotate(up))


def zoomed(camera: Camera, factor: float) -> Camera:
    """The camera at another distance from its target."""
    factor = min(max(factor, 1e-3), 1e3)
    target = np.asarray(camera.target, float)
    moved = _moved(camera, target + factor * (np.asarray(camera.position, float) - target), np.asarray(camera.up, float))
    if moved.ortho_height is not None:
        moved.ortho_height *= factor
    return moved


def _moved(camera: Camera, position: Vector, up: Vector) -> Camera:
    (x, y, z), (a, b, c) = position.tolist(), up.tolist()
    return replace(camera, position=(x, y, z), up=(a, b, c))


def _on_ball(point: Any) -> Vector:
    """The point of the unit sphere in front of a point in radii of the ball, or the nearest one of its rim."""
    x, y = (float(value) for value in point)
    square = x * x + y * y
    if not math.isfinite(square):
        return np.array([0.0, 0.0, 1.0])
    if square > 1.0:
        return np.array([x, y, 0.0]) / math.sqrt(square)
    return np.array([x, y, math.sqrt(1.0 - square)])


@cache
def _widget() -> Any:
    """The class of the widget. anywidget is imported once it is needed."""
    import anywidget  # type: ignore[import-not-found,unused-ignore]
    import traitlets  # type: ignore[import-not-found,unused-ignore]

    class View(anywidget.AnyWidget):  # type: ignore[misc,unused-ignore]
        """A picture of a scene that a drag turns and the wheel zooms."""

        _esm = Path(__file__).with_name("_view.js").read_text()
        png = traitlets.Bytes().tag(sync=True)
        note = traitlets.Unicode().tag(sync=True)
        # Equal pictures are answers, too.
        count = traitlets.Int().tag(sync=True)
        size = traitlets.Tuple((0, 0)).tag(sync=True)

        def __init__(self, state: ViewState) -> None:
            super().__init__(png=state.picture(), size=state.size)
            self._state = state
            self.on_msg(self._receive)

        @property
        def camera(self) -> Camera:
            """The camera of the view."""
            return self._state.camera

        @camera.setter
        def camera(self, camera: Camera) -> None:
            self._state.camera = camera
            self.redraw()

        @property
        def scene(self) -> Scene:
            """The copy of the scene that is shown; after a change of it call `redraw`."""
            return self._state.scene

        def redraw(self) -> None:
            """Make the picture anew."""
            self._answer(self._state.picture())

        def _receive(self, _widget: Any, content: dict[str, Any], _buffers: Any) -> None:
            try:
                png, note = self._state.receive(content), ""
            except Exception as error:  # The window waits for an answer, whatever happens.
                png, note = self.png, f"{type(error).__name__}: {error}"
            self._answer(png, note)

        def _answer(self, png: bytes, note: str = "") -> None:
            with self.hold_sync():
                self.png, self.note = png, note
                self.count += 1

    return View
