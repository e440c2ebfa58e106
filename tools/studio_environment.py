#!/usr/bin/env python3
"""Writes scenes/studio.hdr: the surroundings of a photographer's studio, as a small Radiance picture.

    python3 tools/studio_environment.py

A warm softbox to the left, a cool strip to the right, a dim window behind the camera, grey walls and a dark floor.
"""

import math
from pathlib import Path

WIDTH, HEIGHT = 128, 64


def lamp(azimuth, elevation, centre, size, soft):
    """How much of a rectangular lamp is seen in a direction; angles in degrees."""
    across = (azimuth - centre[0] + 180) % 360 - 180
    distance = max(abs(across) / size[0], abs(elevation - centre[1]) / size[1])
    return min(1.0, max(0.0, (1.0 + soft - distance) / soft))


def color(azimuth, elevation):
    """The light from a direction: linear red, green and blue."""
    wall = 0.10 + 0.14 * max(0.0, math.sin(math.radians(elevation)))
    light = [wall, wall * 1.02, wall * 1.08]
    if elevation < 0:
        light = [0.06, 0.055, 0.05]
    for centre, size, soft, bright in (
        ((-62, 38), (22, 26), 0.15, (15.0, 11.5, 8.0)),
        ((78, 30), (6, 36), 0.2, (4.0, 6.0, 9.0)),
        ((170, 20), (38, 14), 0.4, (1.4, 1.5, 1.7)),
    ):
        seen = lamp(azimuth, elevation, centre, size, soft)
        light = [value + seen * more for value, more in zip(light, bright)]
    return light


def rgbe(light):
    """The four bytes of a pixel: three mantissas and the exponent that they share."""
    brightest = max(light)
    if brightest < 1e-32:
        return bytes(4)
    mantissa, exponent = math.frexp(brightest)
    scale = mantissa * 256 / brightest
    return bytes([*(int(value * scale) for value in light), exponent + 128])


def main():
    rows = []
    for y in range(HEIGHT):
        elevation = 90 - 180 * (y + 0.5) / HEIGHT
        rows.extend(rgbe(color(360 * (x + 0.5) / WIDTH - 180, elevation)) for x in range(WIDTH))
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n"
    path = Path(__file__).parent.parent / "scenes" / "studio.hdr"
    path.write_bytes(header.encode() + b"".join(rows))
    print(f"{path}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
