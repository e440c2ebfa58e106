#!/usr/bin/env bash
# Gmsh 4.15.2 (PyPI, with OpenCASCADE): a sphere that occ.dilate scales, the usual way to an ellipsoid, is a rational B-spline
# surface afterwards, even with factors of 1. Its mass, area, centre and inertia are integrated with too few points. The sphere
# is exact before. Afterwards its volume is 0.044 % too small, its area some 0.4 % too large, its moments of inertia are up to
# 0.6 % off, and its centre is not 0. The bounding box is that of the control points: an ellipsoid with the semi-axes a, b, c
# reaches from -2a to a in x and from -1.732b to 1.732b in y. The points of the surface are right. The documentation of getMass
# and getBoundingBox gives no tolerance; that of the option Geometry.OCCBoundsUseStl mentions more accurate bounds.
# Seen 2026-12, factors 1 2 3: volume 0.99956 of the exact one, area 1.00353, moments 0.99646, 0.99791 and 0.99754, x of the
# centre -0.00022, bounding box x -2..1, y -3.464..3.464, z -3..3. Factors 10 1 1: area 1.00474, a moment 1.00630. With
# Geometry.OCCBoundsUseStl=1 the box is right.
# For us: a row in docs/formats.md; `superegg measure` for reference values, or the mesh of Gmsh.
# usage: findings/gmsh_dilated_sphere.sh   (needs Debian 12 with apt-get for libraries of X11 and OpenGL, python3 with venv, and
# the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/partial"
apt-get -qq -y -o Debug::NoLocking=1 -o APT::Sandbox::User=root -o Dir::Cache::archives="$work" --download-only --reinstall install \
    libglu1-mesa libgl1 libglx0 libopengl0 libglvnd0 libx11-6 libxext6 libxrender1 libxcursor1 libxfixes3 libxft2 libxinerama1 \
    libfontconfig1 libfreetype6 libxcb1 libxau6 libxdmcp6 libbsd0 libmd0 >/dev/null
for package in "$work"/*.deb; do dpkg -x "$package" "$work/root"; done
export LD_LIBRARY_PATH="$work/root/usr/lib/x86_64-linux-gnu:$work/root/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet gmsh==4.15.2 numpy
"$work/venv/bin/python" - <<'PYTHON'
import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
print("Gmsh", gmsh.option.getString("General.Version"))
kernel = gmsh.model.occ


def sphere(factors=None):
    gmsh.clear()
    gmsh.model.add("sphere")
    tag = kernel.addSphere(0, 0, 0, 1)
    if factors:
        kernel.dilate([(3, tag)], 0, 0, 0, *factors)
    kernel.synchronize()
    return tag


def exact(factors):
    """Volume, area and the principal moments of an ellipsoid of density 1."""
    a, b, c = factors
    volume = 4 / 3 * np.pi * a * b * c
    # The midpoint rule converges quickly along the longitude; along the height z it is exact for a sphere.
    longitude, z = np.meshgrid((np.arange(400) + 0.5) / 400 * 2 * np.pi, (np.arange(4000) + 0.5) / 2000 - 1)
    x, y = np.sqrt(1 - z * z) * np.cos(longitude), np.sqrt(1 - z * z) * np.sin(longitude)
    area = 4 * np.pi * np.mean(np.sqrt((b * c * x) ** 2 + (a * c * y) ** 2 + (a * b * z) ** 2))
    return volume, area, volume / 5 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])


def ratios(tag, factors):
    volume, area, moments = exact(factors)
    faces = gmsh.model.getBoundary([(3, tag)], oriented=False)
    return np.array([kernel.getMass(3, tag) / volume, sum(kernel.getMass(2, face) for _, face in faces) / area,
                     *(np.reshape(kernel.getMatrixOfInertia(3, tag), (3, 3)).diagonal() / moments)])


before = ratios(sphere(), (1, 1, 1))
print("sphere: volume, area and moments over the exact ones:", before.round(5).tolist())
assert np.allclose(before, 1, atol=1e-9), "the sphere is no longer exact"

expected = {
    (1, 1, 1): (0.99956, 1.00370, 0.99615, 1.00168, 1.00086),
    (2, 2, 2): (0.99956, 1.00370, 0.99615, 1.00168, 1.00086),
    (1, 2, 3): (0.99956, 1.00353, 0.99646, 0.99791, 0.99754),
    (10, 1, 1): (0.99956, 1.00474, 0.99615, 1.00630, 1.00629),
}
for factors, values in expected.items():
    tag = sphere(factors)
    found, centre = ratios(tag, factors), np.array(kernel.getCenterOfMass(3, tag))
    low, high = np.reshape(gmsh.model.getBoundingBox(3, tag), (2, 3))
    print(f"dilated by {factors}: {found.round(5).tolist()}, x of the centre / a {centre[0] / factors[0]:.5f},",
          "bounding box", low.round(3).tolist(), high.round(3).tolist())
    assert np.allclose(found, values, atol=2e-5), "the integrals are others now"
    assert np.isclose(centre[0] / factors[0], -0.00022, atol=1e-5), "the centre is another now"
    assert np.allclose(low / factors, (-2, -np.sqrt(3), -1), atol=1e-5), "the bounding box is another now"
    assert np.allclose(high / factors, (1, np.sqrt(3), 1), atol=1e-5), "the bounding box is another now"
    # The surface itself is exact: its points, over the whole range of its parameters.
    (_, face), = gmsh.model.getBoundary([(3, tag)], oriented=False)
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face)
    u, v = np.meshgrid(np.linspace(u0, u1, 40), np.linspace(v0, v1, 40))
    points = np.reshape(gmsh.model.getValue(2, face, np.column_stack([u.ravel(), v.ravel()]).ravel()), (-1, 3))
    assert np.allclose(np.sum((points / factors) ** 2, axis=1), 1, atol=1e-9), "the surface is another now"

gmsh.option.setNumber("Geometry.OCCBoundsUseStl", 1)
box = np.reshape(gmsh.model.getBoundingBox(3, sphere((1, 2, 3))), (2, 3))
print("dilated by (1, 2, 3), Geometry.OCCBoundsUseStl=1: bounding box", box[0].round(3).tolist(), box[1].round(3).tolist())
assert np.allclose(box, [(-1, -2, -3), (1, 2, 3)], rtol=0.01), "the option has another effect now"
gmsh.finalize()
PYTHON
echo "as before"
