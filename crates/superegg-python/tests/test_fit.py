"""Fits of superquadrics to points."""

import copy
import pickle

import numpy as np
import pytest

import superegg as se


def cloud(count=2000, noise=0.01, outliers=0.2, seed=1):
    rng = np.random.default_rng(seed)
    shape = se.Superquadric((1, 2, 1.5), (0.4, 1.2))
    inliers = round(count * (1 - outliers))
    surface, _ = shape.sample_surface(inliers, seed)
    surface = surface + noise * rng.normal(size=surface.shape)
    stray = rng.uniform(-3, 3, (count - inliers, 3))
    return np.vstack([surface, stray]) + [5, 0, -3]


def test_noise_and_outliers():
    points = cloud()
    found = se.fit(points)
    assert np.allclose(np.sort(found.shape.radii), [1, 1.5, 2], atol=0.01)
    assert np.allclose(found.center, [5, 0, -3], atol=0.01)
    assert found.noise == pytest.approx(0.01, rel=0.1) and found.outliers == pytest.approx(0.2, abs=0.02)
    assert found.used == 2000 and found.warnings == ()
    assert np.allclose(found.rotation @ found.rotation.T, np.eye(3))
    residuals = found.residuals(points)
    assert residuals.distance.shape == (2000,) and residuals.rms == pytest.approx(0.01, rel=0.1)
    assert residuals.hausdorff < 0.06
    assert (residuals.inlier[1600:] < 0.5).mean() > 0.9
    own = (points - found.center) @ found.rotation
    assert np.allclose(found.shape.signed_distance(own), residuals.distance, atol=1e-5)
    assert found.covariance.shape == (11, 11)
    assert 0 < found.surface_error < 0.002
    assert "Fit: radii" in repr(found)


def test_the_order_of_points_does_not_matter():
    points = cloud(500)
    first, second = se.fit(points), se.fit(points[::-1])
    assert first.shape.radii == second.shape.radii and np.array_equal(first.center, second.center)
    assert np.array_equal(se.fit(points.reshape(50, 10, 3)).center, first.center)


def test_parts():
    points = np.vstack([cloud(800, 0.005, 0), cloud(600, 0.005, 0) + [10, 0, 0]])
    parts = se.fit_parts(points)
    assert len(parts) == 2
    assert np.allclose([part.center for part in parts], [[5, 0, -3], [15, 0, -3]], atol=0.02)
    assert len(se.fit_parts(points, 1)) == 1 and len(se.fit_parts(points, count=2)) == 2


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: se.fit(np.zeros((5, 3))), "at least 12"),
        (lambda: se.fit(np.ones((50, 2))), "shape"),
        (lambda: se.fit(np.c_[np.random.default_rng(1).uniform(size=(50, 2)), np.zeros(50)]), "plane"),
        (lambda: se.fit([[np.nan] * 3] * 20), "finite"),
        (lambda: se.fit(cloud(50), outliers=1.5), "outliers"),
        (lambda: se.fit_parts(cloud(50), 0), "1 to 64"),
        (lambda: se.fit_parts(cloud(50), "many"), "auto"),
        (lambda: se.fit(cloud(50), exponents=(2, 1)), "exponents"),
        (lambda: se.fit(cloud(50), most_points=3), "1000"),
    ],
)
def test_wrong_points(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_a_fit_survives_pickling():
    points, _ = se.Superquadric((1, 2, 3), (0.5, 1.3)).sample_surface(600)
    points = points + np.random.default_rng(1).normal(scale=0.01, size=points.shape)
    found = se.fit(points)
    for other in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert repr(other) == repr(found) and other.warnings == found.warnings and other.used == 600
        assert np.array_equal(other.covariance, found.covariance) and np.array_equal(other.rotation, found.rotation)
        assert (other.surface_error, other.outliers) == (found.surface_error, found.outliers)
        for one, two in zip(other.residuals(points), found.residuals(points), strict=True):
            assert np.array_equal(one, two)


def test_without_inliers_there_is_no_mean():
    found = se.fit(se.Superquadric(1).sample_surface(300)[0])
    assert np.isnan(found.residuals([[1e3, 0, 0]]).rms)
    assert np.isnan(found.residuals(np.zeros((0, 3))).rms)
