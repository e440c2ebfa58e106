"""Wrong calls are exceptions that say what was wrong, with the shapes."""

import numpy as np
import pytest

import superegg as se

NAN = [[0, 0, float("nan")]]
BALL = se.Superquadric(1)


def scene():
    scene = se.Scene()
    scene.add(BALL, name="ball")
    return scene


WRONG = [
    (lambda: se.Superquadric((1, 1)), ValueError, r"\(2,\)"),
    (lambda: se.Superquadric((1, 1, 0)), ValueError, "semi-ax"),
    (lambda: se.Superquadric((1, 1, 1), (-1, 1)), ValueError, "exponent"),
    (lambda: se.Superquadric((1, 1, 1), (1, 1, 1)), ValueError, r"\(3,\)"),
    (lambda: se.Superquadric((1, 1, np.inf)), ValueError, "finite"),
    (lambda: se.Superquadric("round"), ValueError, "real numbers"),
    (lambda: se.Superquadric(1j), ValueError, "real numbers"),
    (lambda: BALL.value([1, 2]), ValueError, r"\(\.\.\., 3\), found shape \(2,\)"),
    (lambda: BALL.value([[1, 2, 3], [4, 5]]), ValueError, "different lengths"),
    (lambda: BALL.value(NAN), ValueError, r"nan at index \(0, 2\) of an array of shape \(1, 3\)"),
    (lambda: BALL.value(None), ValueError, "points"),
    (lambda: BALL.closest_point([0, 0, 0], tolerance=0), ValueError, "tolerance"),
    (lambda: BALL.closest_point([0, 0, 0], threads=-1), ValueError, "threads"),
    (lambda: BALL.closest_point([0, 0, 0], threads=1.5), TypeError, "whole number"),
    (lambda: BALL.sample_surface(-1), ValueError, "n:"),
    (lambda: BALL.sample_surface(2**62), ValueError, "at most"),
    (lambda: BALL.mesh(0), ValueError, "tolerance"),
    (lambda: BALL.mesh(1e-12), ValueError, "possible"),
    (lambda: BALL.point([1, 2], [1, 2, 3]), ValueError, r"u \(2,\), v \(3,\)"),
    (lambda: BALL.intersect(np.zeros((4, 3)), np.zeros((5, 3))), ValueError, r"origins \(4,\), directions \(5,\)"),
    (lambda: BALL.intersect(np.zeros((4, 3)), [0, 0, 1], t_max=np.zeros(5)), ValueError, r"t_max \(5,\)"),
    (lambda: BALL.intersect([0, 0, 0], [0, 0, np.nan]), ValueError, "directions: .* nan"),
    (lambda: BALL.intersect([0, 0, 0], [0, 0, 1], t_max=np.nan), ValueError, "t_max"),
    (lambda: scene().add(3), TypeError, "Superquadric"),
    (lambda: scene().add(BALL, name="ball"), ValueError, "ball"),
    (lambda: scene().add(BALL, name="two words"), ValueError, "one word"),
    (lambda: scene().add(BALL, np.eye(2)), ValueError, r"\(2, 2\)"),
    (lambda: scene().add(BALL, np.zeros((3, 3))), ValueError, "inver"),
    (lambda: scene().add(BALL, np.eye(4), position=(0, 0, 0)), ValueError, "either"),
    (lambda: scene().add(BALL, rotation=2 * np.eye(3)), ValueError, "orthonormal"),
    (lambda: scene().add(BALL, rotation=(0, 0, 0, 0)), ValueError, "length 0"),
    (lambda: scene().add(BALL, rotation=(1, 0, 0)), ValueError, "quaternion"),
    (lambda: scene().add(BALL, color=(1, 2)), ValueError, r"\(2,\)"),
    (lambda: scene().add(BALL, color="red\nclear"), ValueError, "colour|color"),
    (lambda: scene().add(BALL, color="nocolour"), ValueError, "nocolour"),
    (lambda: scene().add(BALL, material=se.Material(diffuse=3)), ValueError, "diffuse|Diffuse"),
    (lambda: scene().add_many(np.zeros(3), 1), ValueError, r"\(N, 3\)"),
    (lambda: scene().add_many(np.zeros((4, 3)), np.ones((5, 3))), ValueError, r"\(4, 3\).*\(5, 3\)"),
    (lambda: scene().add_many(np.zeros((4, 3)), -1), ValueError, "row 0"),
    (lambda: scene().add_many(np.zeros((4, 3)), 1, colors=np.full((4, 3), 255)), ValueError, "0 to 1"),
    (lambda: scene().add_many(np.zeros((4, 3)), 1, ids=[1, 2]), ValueError, "ids"),
    (lambda: scene().add_many(np.zeros((4, 3)), 1, name="ball"), ValueError, "ball"),
    (lambda: scene().add_many(np.zeros((4, 3)), 1, (0, 2), convention="liggghts"), ValueError, "blockiness"),
    (lambda: scene().add_light(se.PointLight((0, 0, 5), falloff=-1)), ValueError, "k"),
    (lambda: scene().add_light(se.PointLight((0, 0, 5)), name="a b"), ValueError, "one word"),
    (lambda: scene().remove_light("sun"), ValueError, "sun"),
    (lambda: scene().look_at((0, 0, 5), fov=200), ValueError, "180"),
    (lambda: scene().set(samples=0), ValueError, "samples"),
    (lambda: scene().set(sample=4), TypeError, "samples"),
    (lambda: scene().set(tone="film\nclear"), ValueError, "tone"),
    (lambda: scene().run("sphere 1 2 3"), se.FormatError, "line 1"),
    (lambda: scene().run("render a.png"), ValueError, "method"),
    (lambda: scene().render(0, 5), ValueError, "width"),
    (lambda: scene().render(100), ValueError, "height"),
    (lambda: scene().render(10, 10, output="normals"), ValueError, "normal, depth"),
    (lambda: scene().render(10, 10, samples=0), ValueError, "samples"),
    (lambda: scene().render(10, 10, layers=False).depth, ValueError, "layers"),
    (lambda: scene().render(2, 2).save("a.jpg"), ValueError, "png"),
    (lambda: scene().render(2, 2).save("/no/such/folder/a.png"), OSError, "a.png"),
    (lambda: scene().intersect([0, 0], [0, 0, 1]), ValueError, r"found shape \(2,\)"),
    (lambda: se.load("no such file.npz"), FileNotFoundError, "no such file.npz"),
    (lambda: se.load("."), IsADirectoryError, "folder"),
    (lambda: se.load([]), ValueError, "empty"),
    (lambda: se.load(3), TypeError, "found int"),
    (lambda: se.loads("hello world"), se.FormatError, "hello"),
    (lambda: se.loads(b"\x00\x01"), se.FormatError, "not a scene"),
    (lambda: se.loads("1 2 3 4 5 6 7 8 9 10 11"), se.FormatError, "convention"),
    (lambda: se.loads("1", convention="legs"), ValueError, "liggghts"),
    (lambda: se.loads("1", convention="ems", frames=2), TypeError, "frames"),
    (lambda: se.loads("x y z a\n1 2 3 4\n", color_by="a", colormap="jet"), ValueError, "viridis"),
]


@pytest.mark.parametrize("case", range(len(WRONG)))
def test_wrong_calls_say_what_is_wrong(case):
    call, kind, text = WRONG[case]
    with pytest.raises(kind, match=text):
        call()


def test_a_refused_change_leaves_the_scene():
    kept = scene()
    before = kept.to_bytes()
    with pytest.raises(se.FormatError) as caught:
        kept.run("background 1 1 1\nbackground 1\n")
    assert caught.value.line == 2
    with pytest.raises(ValueError):
        kept.add(BALL, material=se.Material(color="red", gloss=-3))
    assert kept.to_bytes() == before


def test_an_error_of_a_file_has_its_place(tmp_path):
    path = tmp_path / "egg.scn"
    path.write_text("primitive egg\nsetCoeff 1 1\n")
    with pytest.raises(se.FormatError) as caught:
        se.load(path)
    assert (caught.value.file, caught.value.line) == (str(path), 2)
    assert "egg.scn:2:" in str(caught.value)
    bad = tmp_path / "grains.dump"
    from conftest import DUMP

    bad.write_text(DUMP.replace("7 1 0 0 0 .3", "7 1 0 0 0 x.3"))
    with pytest.raises(se.FormatError) as caught:
        se.load(bad)
    assert (caught.value.file, caught.value.line) == (str(bad), 10)
