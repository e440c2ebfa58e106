"""Answers against values of 40 digits, which stand beside the Rust tests."""

from pathlib import Path

import numpy as np
import pytest

import superegg as se

DATA = Path(__file__).resolve().parents[2] / "superegg-geom" / "tests" / "data"


def table(name):
    path = DATA / name
    if not path.is_file():
        pytest.skip("the values are in the repository of the project alone")
    return np.genfromtxt(path, delimiter=",", names=True)


def test_distances_and_closest_points():
    rows = table("closest.csv")
    assert len(rows) > 20
    for row in rows:
        shape = se.Superquadric([row[c] for c in "abc"], [row["e"], row["n"]])
        query = np.array([row[c] for c in "xyz"])
        position, distance, error = shape.closest_point(query, tolerance=1e-12)
        assert abs(abs(distance) - row["distance"]) <= 1e-9 * (1 + abs(row["distance"])), row
        assert error <= 1e-6
        # Another point may be as close; this one is on the surface at that distance.
        assert abs(np.linalg.norm(position - query) - row["distance"]) < 1e-9, row


def test_volumes_moments_and_areas():
    for row in table("measures.csv"):
        shape = se.Superquadric([row[c] for c in "abc"], [row["e"], row["n"]])
        assert np.isclose(shape.volume, row["volume"], rtol=1e-11)
        moments = [row["yy"] + row["zz"], row["xx"] + row["zz"], row["xx"] + row["yy"]]
        assert np.allclose(shape.inertia(), moments, rtol=1e-11)
        area = shape.area_with_error()
        assert abs(area.value - row["area"]) <= max(area.error, 1e-9 * row["area"])


def test_hits_of_rays():
    rows = table("rays.csv")
    checked = 0
    for row in rows[rows["margin"] > 1e-6][:1500]:
        shape = se.Superquadric(1, [row["e"], row["n"]])
        hit = shape.intersect([row["ox"], row["oy"], row["oz"]], [row["dx"], row["dy"], row["dz"]])
        assert bool(hit.hit) == (row["hit"] == 1), row
        if hit.hit:
            checked += 1
            assert abs(hit.t - row["t"]) <= 1e-9 * (1 + row["t"]), row
    assert checked > 200
