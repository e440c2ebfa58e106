"""Wrong calls are exceptions that say what was wrong, with the shapes."""

import pickle

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
    (lambda: BALL.value(np.ma.array([1.0, 2.0, 3.0], mask=[0, 1, 0])), ValueError, r"points: values of an array of shape \(3,\) are masked"),
    (lambda: BALL.sample_surface(np.zeros((3, 1))), TypeError, "n: expected a whole number"),
    (lambda: BALL.sample_surface(3, seed=2**63), ValueError, r"below 2\^63"),
    (lambda: BALL.inertia(mass=-1), ValueError, "mass: .* at least 0"),
    (lambda: scene().add(BALL, material="red"), TypeError, "material: expected a Material, found str"),
    (lambda: scene().add(BALL, name=3), TypeError, "name: expected a text, found int"),
    (lambda: scene().add(BALL, material=se.Material(fresnel="no")), TypeError, "fresnel: expected True or False"),
    (lambda: scene().add(BALL, material=se.Material(checker=3)), ValueError, "checker: expected a colour and a size"),
    (lambda: scene().add(BALL, rotation=np.full((3, 3), 1e200)), ValueError, "orthonormal"),
    (lambda: scene().set_floor(0, material="red"), TypeError, "material: expected a Material"),
    (lambda: scene().add_light("sun"), TypeError, "light: expected a PointLight.* found str"),
    (lambda: scene().add_light(se.PointLight((0, 0, 5)), name=3), TypeError, "name: expected a text, found int"),
    (lambda: scene().remove_light(3), TypeError, "name: expected a text, found int"),
    (lambda: setattr(scene(), "camera", (1, 2, 3)), TypeError, "camera: expected a Camera, found tuple"),
    (lambda: setattr(scene(), "camera", se.Camera((1, 2, 3), lens=(1, 2, 3))), ValueError, "lens: expected 2 numbers"),
    (lambda: setattr(scene(), "root", None), TypeError, "root: expected a text, found NoneType"),
    (lambda: scene().add_many(np.zeros((1, 3)), 1, ids=np.array([2**64 - 1], np.uint64)), ValueError, r"ids: .*2\^63"),
    (lambda: scene().add_many(np.zeros((2, 3)), 1, ids=[[1], [1, 2]]), ValueError, "ids: rows of different"),
    (lambda: scene().set(size="80x60"), ValueError, "size: expected width and height"),
    (lambda: scene().set(samples=[1, 2]), ValueError, r"samples: .*\[1, 2\]"),
    (lambda: scene().add(BALL, name="a\0b"), ValueError, "cannot be a name"),
    (lambda: scene().run("primitive a\nprimitive b\0c"), se.FormatError, "line 2: a zero byte"),
    (lambda: scene().table(3), TypeError, "name: expected a text, found int"),
    (lambda: scene().run(b"clear"), TypeError, "text: expected lines .* found bytes"),
    (lambda: scene().key(0, None), TypeError, "line: expected a text"),
    (lambda: scene().key(0, "translate 0 0 0\nclear"), ValueError, "expected one line"),
    (lambda: scene().set_environment('a"b.hdr'), ValueError, "quotation mark"),
    (lambda: scene().render(4, 4, progress="yes"), TypeError, "progress: expected True, False or a function"),
    (lambda: scene().render(4, 4, layers="no"), TypeError, "layers: expected True or False"),
    (lambda: scene().render(4, 4, output=3), TypeError, "output: expected a text"),
    (lambda: scene().export("a.stl", absolute="no"), TypeError, "absolute: expected True or False"),
    (lambda: np.asarray(scene().render(4, 4), dtype=np.float64, copy=False), ValueError, "needs a copy"),
    (lambda: pickle.dumps(scene().render(4, 4)), TypeError, "film.color"),
    (lambda: se.loads(5), TypeError, "data: expected a text or bytes, found int"),
    (lambda: se.loads([]), TypeError, "data: expected a text or bytes, found list"),
    (lambda: se.loads("", columns=3), TypeError, "columns: expected a text"),
    (lambda: se.loads("", images=3), TypeError, "images: expected three counts"),
    (lambda: se.loads("", box="no"), TypeError, "box: expected True or False"),
]


@pytest.mark.parametrize("case", range(len(WRONG)))
def test_wrong_calls_say_what_is_wrong(case):
    call, kind, text = WRONG[case]
    with pytest.raises(kind, match=text):
        call()


@pytest.mark.parametrize("wrong", [None, "abc", 3.5, np.zeros((3, 1)), {"a": 1}, b"abc", len, np, 1j, [[1], [1, 2]]], ids=repr)
def test_no_other_exception_leaves_a_call(wrong):
    """Whatever is given, a call is right, or its exception is one that is documented."""
    calls = [
        BALL.value, BALL.normal, BALL.uv, BALL.closest_point, BALL.sample_surface, BALL.inertia, BALL.mesh,
        lambda x: BALL.intersect(x, [0, 0, 1]), lambda x: BALL.occluded([0, 0, 5], x), lambda x: BALL.point(x, 0.0),
        lambda x: se.Superquadric(x), lambda x: se.Superquadric(1, x), lambda x: se.Superquadric(1, convention=x),
        se.fit, se.fit_parts, se.load, se.loads, lambda x: se.loads("", convention=x), lambda x: se.loads("", frame=x),
        lambda x: se.loads("", range=x), lambda x: se.loads("", color_by=x), lambda x: se.loads("", min_axis=x),
        lambda x: scene().add(x), lambda x: scene().add(BALL, x), lambda x: scene().add(BALL, rotation=x),
        lambda x: scene().add(BALL, color=x), lambda x: scene().add(BALL, material=x), lambda x: scene().add(BALL, name=x),
        lambda x: scene().add_many(x, 1), lambda x: scene().add_many(np.zeros((2, 3)), x),
        lambda x: scene().add_many(np.zeros((2, 3)), 1, ids=x), lambda x: scene().add_many(np.zeros((2, 3)), 1, name=x),
        lambda x: scene().add_light(x), lambda x: scene().remove_light(x), lambda x: setattr(scene(), "camera", x),
        lambda x: setattr(scene(), "root", x), lambda x: scene().look_at(x), lambda x: scene().frame(x),
        lambda x: scene().set(samples=x), lambda x: scene().set(size=x), lambda x: scene().set_background(x),
        lambda x: scene().set_sky(x), lambda x: scene().set_floor(x), lambda x: scene().set_floor(0, material=x),
        lambda x: scene().run(x), lambda x: scene().key(x, "rotate z 0"), lambda x: scene().key(0, x), lambda x: scene().at(x),
        lambda x: scene().primitive_name(x), lambda x: scene().render(x, 4), lambda x: scene().render(4, 4, threads=x),
        lambda x: scene().render(4, 4, progress=x), lambda x: scene().render(4, 4, output=x), lambda x: scene().mesh(x),
        lambda x: scene().render(2, 2).save(x), lambda x: scene().view(where=x),
        lambda x: se.Material(checker=x).lines(), lambda x: se.Camera((1, 2, 3), lens=x).lines(),
    ]
    for call in calls:
        try:
            call(wrong)
        except (ValueError, TypeError, OSError, KeyError) as error:
            assert str(error)


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
