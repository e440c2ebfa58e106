#!/usr/bin/env bash
# POV-Ray 3.7.0.10 (Debian 12) has lengths that are the same in every scene, whatever its units: a shadow ray forgets what is
# nearer than a thousandth of a unit, and a ray forgets hits nearer than some hundred-thousandths. So a scene in small units
# loses its shadows, and then its shapes, without a warning. Grains of 0.1 mm in a scene in metres cast no shadow.
# Seen 2026-11, a ball on a floor, all lengths (camera and light too) times the scale: shadow at scales 1, 0.01 and 0.001,
# none at 0.0003 and 0.00003; neither ball nor floor at 0.000001.
# For us: `superegg export scene.pov` writes scenes whose shapes are that small enlarged by a power of ten, and says so.
# usage: findings/povray_small_scenes.sh   (needs Debian 12 with apt-get, python3, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/partial"
apt-get -qq -y -o Debug::NoLocking=1 -o APT::Sandbox::User=root -o Dir::Cache::archives="$work" --download-only --reinstall install \
    povray=1:3.7.0.10-2+b2 >/dev/null
for package in "$work"/*.deb; do dpkg -x "$package" "$work/root"; done
export LD_LIBRARY_PATH="$work/root/usr/lib/x86_64-linux-gnu:$work/root/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
python3 - "$work" <<'PYTHON'
import subprocess
import sys

work, size = sys.argv[1], 64


def picture(scale):
    """The red, green and blue bytes of the row through the middle of the ball, from above."""
    open(f"{work}/ball.pov", "w").write(f"""#version 3.7;
global_settings {{ assumed_gamma 1 }}
camera {{ orthographic location <0, {40 * scale}, {-0.001 * scale}> look_at 0 right x * {6 * scale} up z * {6 * scale} }}
light_source {{ <{-20 * scale}, {40 * scale}, 0> rgb 1 }}
plane {{ y, 0 pigment {{ rgb 1 }} finish {{ ambient 0 diffuse 1 }} }}
sphere {{ <0, {scale}, 0>, {scale} pigment {{ rgb <1, 0.2, 0.2> }} finish {{ ambient 0 diffuse 1 }} }}
""")
    run = subprocess.run(
        [f"{work}/root/usr/bin/povray", f"+I{work}/ball.pov", f"+O{work}/ball.ppm", "+FP",
         f"+W{size}", f"+H{size}", "-A", "-D"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "Parse Warning" not in run.stderr, run.stderr
    rgb = open(f"{work}/ball.ppm", "rb").read()[-3 * size * size:]
    row = rgb[3 * size * (size // 2):3 * size * (size // 2 + 1)]
    return [tuple(row[3 * i:3 * i + 3]) for i in range(size)]


seen = {}
for scale in (1, 1e-2, 1e-3, 3e-4, 3e-5, 1e-6):
    row = picture(scale)
    # The ball is nearer to the light than to this part of the floor, which its shadow covers.
    shadow = sum(pixel == (0, 0, 0) for pixel in row[8:20])
    ball = sum(pixel[0] > 2 * pixel[1] for pixel in row)
    floor = sum(min(pixel) > 100 for pixel in row)
    seen[scale] = (shadow > 4, ball > 10, floor > 10)
    print(f"scale {scale:g}: pixels of shadow {shadow}, of the ball {ball}, of the lit floor {floor}")
assert seen[1] == seen[1e-2] == seen[1e-3] == (True, True, True), "the ordinary scenes have changed"
assert seen[3e-4] == (False, True, True) == seen[3e-5], "small scenes have shadows now"
assert seen[1e-6][1:] == (False, False), "tiny scenes are seen now"
PYTHON
echo "as before"
