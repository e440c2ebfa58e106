"""A superquadric on arrays: closed forms, laws, and an independent minimiser."""

import copy
import math
import pickle
import subprocess
import sys

import numpy as np
import pytest

import superegg as se

SHAPES = [
    se.Superquadric((1, 1, 1), (1, 1)),
    se.Superquadric((1, 2, 3), (0.3, 1.7)),
    se.Superquadric((0.5, 0.4, 2), (0.05, 0.1)),
    se.Superquadric((1, 1, 2), (2, 2)),
    se.Superquadric((1, 1.5, 0.5), (3, 2.5)),
]


def equation(shape, p):
    (a, b, c), (e, n) = shape.radii, shape.exponents
    x, y, z = np.abs(np.moveaxis(np.asarray(p, float) / (a, b, c), -1, 0))
    return (x ** (2 / e) + y ** (2 / e)) ** (e / n) + z ** (2 / n) - 1


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_value_is_the_equation(shape):
    p = np.random.default_rng(1).uniform(-1.5, 1.5, (500, 3)) * shape.radii
    expected = equation(shape, p)
    assert np.allclose(shape.value(p), expected, rtol=1e-9, atol=1e-12)
    assert np.array_equal(shape.inside(p), shape.value(p) <= 0)


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_points_of_the_surface(shape):
    rng = np.random.default_rng(2)
    u, v = rng.uniform(-3.1, 3.1, 200), rng.uniform(-1.5, 1.5, 200)
    p = shape.point(u, v)
    sampled, normals = shape.sample_surface(500, seed=4)
    for points in (p, sampled):
        assert np.abs(shape.signed_distance(points)).max() < 1e-9
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    again, _ = shape.sample_surface(500, seed=4)
    assert np.array_equal(sampled, again)
    assert not np.array_equal(sampled, shape.sample_surface(500, seed=5)[0])
    assert shape.inside(shape.sample_inside(500, seed=1)).all()


def test_uv_is_the_inverse_of_point():
    shape = SHAPES[1]
    u, v = np.linspace(-3, 3, 50), np.linspace(-1.5, 1.5, 50)
    back = shape.uv(shape.point(u, v))
    assert np.allclose(back, (u, v), atol=1e-9)


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_no_point_of_the_surface_is_closer(shape):
    queries = np.random.default_rng(5).uniform(-2, 2, (40, 3)) * shape.radii
    position, distance, error = shape.closest_point(queries)
    assert np.allclose(np.linalg.norm(position - queries, axis=1), np.abs(distance), rtol=1e-9)
    assert np.array_equal(distance < 0, shape.value(queries) < 0)
    surface, _ = shape.sample_surface(20000, seed=6)
    nearest = np.min(np.linalg.norm(queries[:, None] - surface[None, :2000], axis=2), axis=1)
    assert (np.abs(distance) <= nearest + error + 1e-12).all()
    if shape.exponents[0] > 0.1:
        close = np.array([np.linalg.norm(q - surface, axis=1).min() for q in queries])
        assert (close - np.abs(distance) < 0.15 * max(shape.radii)).all()


def test_measures_of_known_shapes():
    ball, octahedron = se.Superquadric(2), se.Superquadric(1, (2, 2))
    assert math.isclose(ball.volume, 32 / 3 * math.pi, rel_tol=1e-13)
    assert math.isclose(ball.area, 16 * math.pi, rel_tol=1e-9)
    assert ball.area_with_error().error < 1e-6
    assert np.allclose(ball.inertia(mass=10), 16)
    assert np.allclose(ball.inertia(), 0.4 * 4 * ball.volume)
    assert math.isclose(octahedron.area, 4 * math.sqrt(3), rel_tol=1e-9)
    assert np.array_equal(SHAPES[1].bounds, [[-1, -2, -3], [1, 2, 3]])


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_the_mesh_is_closed_and_within_its_tolerance(shape):
    mesh = shape.mesh(0.02)
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 2).all()
    middles = mesh.vertices[mesh.faces].mean(axis=1)[:300]
    assert np.abs(shape.signed_distance(middles)).max() <= 0.02 * max(shape.radii) * (1 + 1e-6)
    assert mesh.normals.shape == mesh.vertices.shape


@pytest.mark.parametrize("shape", SHAPES, ids=repr)
def test_hits_lie_on_the_surface(shape):
    rng = np.random.default_rng(8)
    origins = rng.normal(size=(3000, 3))
    origins *= 3 * max(shape.radii) / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-1, 1, (3000, 3)) * shape.radii - origins
    hits = shape.intersect(origins, directions)
    assert hits.hit.sum() > 300
    at = hits.position[hits.hit]
    assert np.abs(shape.signed_distance(at[:100])).max() < 1e-9
    expected = origins + hits.t[:, None] * directions
    assert np.allclose(at, expected[hits.hit], atol=1e-9)
    assert np.array_equal(shape.occluded(origins, directions), hits.hit)
    assert not shape.occluded(origins, directions, t_max=0.5 * np.where(hits.hit, hits.t, 1)).any()
    assert np.isnan(hits.position[~hits.hit]).all()
    one = shape.intersect(origins[0], directions[0])
    assert one.t.shape == () and one.position.shape == (3,) and one.t == hits.t[0]


def test_ranges_of_t():
    ball = se.Superquadric(1)
    assert ball.intersect([0, 0, 5], [0, 0, -1], t_min=4.5).t == 6
    assert ball.intersect([0, 0, 5], [0, 0, -1], t_max=4).t == np.inf
    assert ball.occluded([0, 0, 5], [0, 0, -1], t_min=4.5, t_max=7)
    assert not ball.occluded([0, 0, 5], [0, 0, -1], t_min=6.5)


def test_any_real_array_is_taken():
    shape = SHAPES[1]
    p = np.random.default_rng(9).uniform(-1, 1, (6, 4, 3))
    expected = shape.value(p)
    assert expected.shape == (6, 4)
    assert np.array_equal(shape.value(p.tolist()), expected)
    assert np.array_equal(shape.value(np.asfortranarray(p)), expected)
    assert np.array_equal(shape.value(p[::-1, ::2])[::-1], expected[:, ::2])
    wide = np.zeros((6, 4, 7))
    wide[..., 2:5] = p
    assert np.array_equal(shape.value(wide[..., 2:5]), expected)
    single = p.astype(np.float32)
    assert np.array_equal(shape.value(single), shape.value(single.astype(float)))
    assert shape.value([1, 2, 3]).shape == ()
    assert shape.value(np.zeros((0, 3))).shape == (0,)
    assert shape.intersect(np.zeros((0, 3)), [0, 0, 1]).t.shape == (0,)
    swapped = p.astype(">f8")
    assert np.array_equal(shape.value(swapped), expected)
    rays = shape.intersect([[0, 0, 9]], np.zeros((5, 2, 3)) - [0, 0, 1])
    assert rays.t.shape == (5, 2)


def test_threads_change_nothing():
    shape = SHAPES[4]
    p = np.random.default_rng(9).uniform(-1, 1, (3000, 3))
    for one, two in zip(shape.closest_point(p, threads=1), shape.closest_point(p, threads=3), strict=True):
        assert np.array_equal(one, two)


def test_copies_are_equal():
    shape = SHAPES[1]
    for other in (pickle.loads(pickle.dumps(shape)), copy.copy(shape), copy.deepcopy(shape)):
        assert other == shape and hash(other) == hash(shape)
    assert shape != SHAPES[0] and shape != 3


def test_threads_beyond_reason_are_as_many_as_there_are():
    shape = SHAPES[1]
    p = np.random.default_rng(9).uniform(-1, 1, (3000, 3))
    assert np.array_equal(shape.closest_point(p, threads=10**9).distance, shape.closest_point(p).distance)


@pytest.mark.skipif(sys.platform != "linux", reason="a limit of memory")
@pytest.mark.parametrize("name", ["sample_surface", "sample_inside"])
def test_more_samples_than_memory_holds_are_a_memory_error(name):
    """The process goes on."""
    script = (
        "import resource, superegg\n"
        "resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))\n"
        f"try: superegg.Superquadric(1).{name}(10**9)\n"
        "except MemoryError as error: print(error)\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert "ask for fewer" in run.stdout, run.stderr


def test_moments_of_a_mass_do_not_leave_the_range_of_float64():
    expected = se.Superquadric((1, 2, 3), (0.5, 1.5)).inertia(mass=5)
    for unit in (1e-100, 1e100):
        moments = se.Superquadric((unit, 2 * unit, 3 * unit), (0.5, 1.5)).inertia(mass=5)
        assert np.allclose(moments / unit / unit, expected, rtol=1e-12)


def test_conventions():
    assert se.Superquadric((2, 4, 6), (8, 2), convention="lammps") == se.Superquadric((1, 2, 3), (1, 0.25))
    assert se.Superquadric((1, 2, 3), (0.5, 1.5), convention="ems").exponents == (1.5, 0.5)
    assert se.Superquadric((1, 2, 3), (0, 0.5), convention="ovito").exponents == (1, 0.5)
    with pytest.raises(ValueError, match="liggghts"):
        se.Superquadric(1, convention="ligghts")
