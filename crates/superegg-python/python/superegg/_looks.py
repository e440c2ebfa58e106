"""Surfaces, lights and the camera, as lines of the modelling language."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Union

from superegg._arrays import flag, number, vector

Vector = Union[tuple[float, float, float], list[float]]
Color = Union[str, tuple[float, float, float], list[float]]

_WORD = re.compile(r"#[0-9a-fA-F]{3,6}|[a-zA-Z]+")


def text_of(values: tuple[float, ...]) -> str:
    """Numbers as the modelling language reads them, to the last digit."""
    return " ".join(repr(value) for value in values)


def triple(values: object, name: str) -> str:
    """Three numbers."""
    return text_of(vector(values, name))  # type: ignore[arg-type]


def color_text(color: object, name: str = "color") -> str:
    """A colour: linear values, or a word of sRGB."""
    if isinstance(color, str):
        if not _WORD.fullmatch(color):
            raise ValueError(f"{name}: expected three linear values, '#ff8000' or a CSS name, found {color!r}")
        return color
    return triple(color, name)


@dataclass
class Material:
    """The surface of a shape. What is ``None`` stays as it is for a new primitive.

    Parameters
    ----------
    color : sequence of 3 numbers, or str
        The base colour: linear values in [0, 1], or ``"#ff8000"``, ``"#f80"`` or a CSS name (sRGB).
    ambient, diffuse, specular : float
        The weights of ambient light (0.1), diffuse light (0.8) and the highlight (0.1), in [0, 1].
    gloss : float
        The roughness of the highlight (0.3): smaller is sharper.
    shininess : float
        The exponent of the highlight, instead of the one from gloss.
    reflected, refracted : float
        The weights of reflected and transmitted light, in [0, 1]; by default neither.
    index : float
        The index of refraction (1.5), from 1 to 4.
    fresnel : bool
        Whether the index scales the reflected weight by the angle.
    emission : float
        The light that the surface gives off (0), in multiples of its colour.
    roughness : float
        For ``light="path"``: the roughness of the facets of the surface, from 0 (mirror) to 1 (matt). `index` is then
        that of a coat over the colour, or of rough glass if light is `refracted`.
    metallic : float
        For ``light="path"``: the part of the surface that is metal (0), whose reflections have its colour.
    absorb : sequence of 3 numbers
        Absorption inside, per world unit.
    checker : tuple of a colour and a size
        A second colour in cubes, of linear values.
    gradient : tuple of a colour and a direction
        A second colour along a direction, in the shape's own space.
    """

    color: Color | None = None
    ambient: float | None = None
    diffuse: float | None = None
    specular: float | None = None
    gloss: float | None = None
    shininess: float | None = None
    reflected: float | None = None
    refracted: float | None = None
    index: float | None = None
    emission: float | None = None
    roughness: float | None = None
    metallic: float | None = None
    fresnel: bool | None = None
    absorb: Vector | None = None
    checker: tuple[Vector, float] | None = None
    gradient: tuple[Vector, Vector] | None = None

    def lines(self) -> list[str]:
        """The commands that set the surface of the selected primitive."""
        lines: list[str] = []
        if self.color is not None:
            lines.append(f"setColor {color_text(self.color)}")
        for name in ("ambient", "diffuse", "specular", "gloss", "shininess", "reflected", "refracted", "index", "emission", "roughness", "metallic"):
            value = getattr(self, name)
            if value is not None:
                lines.append(f"set{name.capitalize()} {number(value, name)!r}")
        if self.fresnel is not None:
            lines.append(f"setFresnel {'on' if flag(self.fresnel, 'fresnel') else 'off'}")
        if self.absorb is not None:
            lines.append(f"setAbsorb {triple(self.absorb, 'absorb')}")
        if self.checker is not None:
            second, size = _pair(self.checker, "checker", "a colour and a size")
            lines.append(f"setPattern checker {triple(second, 'checker')} {number(size, 'checker')!r}")
        if self.gradient is not None:
            second, way = _pair(self.gradient, "gradient", "a colour and a direction")
            lines.append(f"setPattern gradient {triple(second, 'gradient')} {triple(way, 'gradient')}")
        return lines


def _pair(values: Any, name: str, expected: str) -> tuple[Any, Any]:
    try:
        first, second = values
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected {expected}, found {values!r}") from None
    return first, second


def material_lines(color: object, material: Material | None) -> list[str]:
    """The lines of a material, and of a colour that replaces its own."""
    if not (material is None or isinstance(material, Material)):
        raise TypeError(f"material: expected a Material, found {type(material).__name__}")
    lines = [] if material is None else material.lines()
    if color is not None:
        lines.append(f"setColor {color_text(color)}")
    return lines


@dataclass
class PointLight:
    """A light that shines in all directions.

    Parameters
    ----------
    position : sequence of 3 numbers
        World units.
    color : sequence of 3 numbers
        Linear; 1 1 1 is white, larger is brighter.
    falloff : float
        k of the attenuation ``1 / (1 + k d^2)`` at distance d.
    radius : float
        Of a spherical area light, in world units; 0 gives hard shadows.
    """

    position: Vector
    color: Vector = (1.0, 1.0, 1.0)
    falloff: float = 0.0
    radius: float = 0.0

    def lines(self, name: str) -> list[str]:
        """The commands that set the light."""
        head = f"light {name} {triple(self.position, 'position')} {triple(self.color, 'color')}"
        return [f"{head} {number(self.falloff, 'falloff')!r}", *_radius(name, self.radius)]


@dataclass
class SpotLight:
    """A light that shines into a cone.

    Parameters
    ----------
    position, target : sequence of 3 numbers
        World units; the light shines from one towards the other.
    angle : float
        The full angle of the cone in degrees, at most 180.
    color, falloff, radius
        As for `PointLight`.
    soft : float
        The share of the angle over which the light fades towards the rim.
    """

    position: Vector
    target: Vector
    angle: float = 40.0
    color: Vector = (1.0, 1.0, 1.0)
    falloff: float = 0.0
    soft: float = 0.2
    radius: float = 0.0

    def lines(self, name: str) -> list[str]:
        """The commands that set the light."""
        where = f"{triple(self.position, 'position')} {triple(self.target, 'target')}"
        head = f"spot {name} {where} {number(self.angle, 'angle')!r} {triple(self.color, 'color')}"
        tail = f"{number(self.falloff, 'falloff')!r} {number(self.soft, 'soft')!r}"
        return [f"{head} {tail}", *_radius(name, self.radius)]


@dataclass
class SunLight:
    """Parallel light.

    Parameters
    ----------
    direction : sequence of 3 numbers
        Towards the light.
    color : sequence of 3 numbers
        As for `PointLight`.
    radius : float
        The tangent of its angular radius: 0.0047 for the sun.
    """

    direction: Vector
    color: Vector = (1.0, 1.0, 1.0)
    radius: float = 0.0

    def lines(self, name: str) -> list[str]:
        """The commands that set the light."""
        head = f"sun {name} {triple(self.direction, 'direction')} {triple(self.color, 'color')}"
        return [head, *_radius(name, self.radius)]


Light = Union[PointLight, SpotLight, SunLight]


def _radius(name: str, radius: float) -> list[str]:
    size = number(radius, "radius")
    return [f"lightRadius {name} {size!r}"] if size != 0 else []


@dataclass
class Camera:
    """A camera.

    Parameters
    ----------
    position, target : sequence of 3 numbers
        Where it is and the point in the middle of the picture, in world units.
    up : sequence of 3 numbers
        The direction that is up in the picture.
    fov : float
        The vertical field of view in degrees.
    ortho_height : float, optional
        The height of the picture in world units of an orthographic camera, which ignores the field of view.
    lens : tuple of lens radius and focus distance, optional
        For depth of field, in world units.
    """

    position: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov: float = 60.0
    ortho_height: float | None = None
    lens: tuple[float, float] | None = None

    def lines(self) -> list[str]:
        """The commands that set the camera."""
        where = f"{triple(self.position, 'position')} {triple(self.target, 'target')}"
        lines = [f"camera {where} {number(self.fov, 'fov')!r}", f"cameraUp {triple(self.up, 'up')}"]
        # Both are set in any case: the camera before may have them.
        height = 0.0 if self.ortho_height is None else number(self.ortho_height, "ortho_height")
        lines.append(f"orthographic {height!r}")
        if self.lens is None:
            lines.append("lens 0")
        else:
            radius, focus = vector(self.lens, "lens", 2)
            lines.append(f"lens {radius!r} {focus!r}")
        return lines
