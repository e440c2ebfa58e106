"""Scenes: built, read, rendered, hit by rays; the same as the program's."""

import copy
import os
import pickle
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import superegg as se
from superegg._rotation import matrices, quaternions

PROGRAM = [sys.executable, "-m", "superegg"]


def test_a_table_is_what_its_shapes_are(cloud):
    """The columns of `add_many` give the hits that single shapes give."""
    table = cloud.table()
    one = se.Scene()
    rows = zip(table["positions"], table["radii"], table["exponents"], table["rotations"], strict=True)
    for position, radii, exponents, rotation in list(rows)[:60]:
        one.add(se.Superquadric(radii, exponents), position=position, rotation=rotation)
    few = se.Scene()
    few.add_many(*(table[name][:60] for name in ("positions", "radii", "exponents", "rotations")))
    rng = np.random.default_rng(1)
    targets = table["positions"][rng.integers(0, 60, 4000)]
    origins = rng.uniform(-8, 8, (4000, 3))
    a, b = (scene.intersect(origins, targets - origins) for scene in (one, few))
    assert np.array_equal(a.hit, b.hit) and a.hit.all()
    assert np.allclose(a.t, b.t, rtol=1e-12)
    assert np.allclose(a.normal, b.normal, atol=1e-9)


def test_hits_are_consistent(cloud):
    rng = np.random.default_rng(2)
    origins, directions = rng.uniform(-6, 6, (5000, 3)), rng.normal(size=(5000, 3))
    hits = cloud.intersect(origins, directions)
    assert 500 < hits.hit.sum() < 5000
    assert np.allclose(hits.position, origins + np.where(hits.hit, hits.t, np.nan)[:, None] * directions, equal_nan=True)
    assert np.array_equal(cloud.occluded(origins, directions), hits.hit)
    assert (hits.primitive[~hits.hit] == -1).all() and (hits.instance[~hits.hit] == 0).all()
    assert (hits.instance[hits.hit] > 0).all()
    names = hits.names()
    assert names.shape == hits.t.shape
    assert all((name is None) != bool(hit) for name, hit in zip(names, hits.hit, strict=True))
    assert all(name.startswith("model/table/p") for name in names[hits.hit])
    surface = np.abs(cloud.signed_distance(hits.position[hits.hit][:200]))
    inside = cloud.inside(hits.position[hits.hit][:200])
    assert surface[~inside].max() < 1e-9
    for threads in (1, 3):
        again = cloud.intersect(origins, directions, threads=threads)
        assert np.allclose(again.t, hits.t, rtol=1e-12) and np.array_equal(again.instance, hits.instance)
    cut = cloud.occluded(origins, directions, t_max=np.where(hits.hit, 0.999 * hits.t, 1e300))
    assert not cut.any()


def test_uv_is_computed_where_it_is_wanted():
    scene = se.Scene()
    shape = se.Superquadric((1, 2, 3), (0.5, 1.5))
    scene.add(shape, position=(1, 0, 0))
    rays = np.random.default_rng(1).normal(size=(3000, 3))
    for few in (rays, rays[:10]):
        hits = scene.intersect((1, 0, 0), few, uv=True)
        assert np.allclose(hits.uv, np.stack(shape.uv(hits.position - (1, 0, 0)), axis=-1), atol=1e-6)
        assert np.isnan(scene.intersect((1, 0, 0), few).uv).all()


def test_distance_to_a_scene():
    scene = se.Scene()
    scene.add(se.Superquadric(1))
    scene.add(se.Superquadric(1), position=(4, 0, 0))
    assert np.allclose(scene.signed_distance([[2, 0, 0], [-3, 0, 0], [4, 0, 0.5]]), [1, 2, -0.5])
    assert np.array_equal(scene.inside([[0, 0, 0], [2, 0, 0]]), [True, False])
    assert np.allclose(scene.bounds, [[-1, -1, -1], [5, 1, 1]], atol=1e-5)
    assert se.Scene().signed_distance([0, 0, 0]) == np.inf
    assert se.Scene().bounds is None


def test_rotations_in_all_forms():
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation.random(50, random_state=3)
    quat = rotation.as_quat()
    wxyz = np.roll(quat, 1, axis=1)
    expected = rotation.as_matrix()
    assert np.allclose(matrices(rotation), expected)
    assert np.allclose(matrices(3 * wxyz), expected)
    back = quaternions(expected)
    assert np.allclose(np.abs(np.sum(back * quat, axis=1)), 1)
    assert np.allclose(np.abs(np.sum(quaternions(wxyz) * quat, axis=1)), 1)
    half_turns = np.array([np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1])])
    assert np.allclose(matrices(np.roll(quaternions(half_turns), 1, axis=1)), half_turns)
    scenes = []
    for form in (rotation[7], wxyz[7], expected[7]):
        scene = se.Scene()
        scene.add(se.Superquadric((1, 2, 3), (0.4, 1)), rotation=form, position=(1, 2, 3))
        scenes.append(scene)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = expected[7], (1, 2, 3)
    scene = se.Scene()
    scene.add(se.Superquadric((1, 2, 3), (0.4, 1)), matrix)
    rays = np.random.default_rng(1).normal(size=(100, 3))
    hits = [each.intersect((1, 2, 3), rays).t for each in (*scenes, scene)]
    assert np.allclose(hits, hits[0]) and np.isfinite(hits[0]).all()


def test_conventions_of_arrays_are_those_of_files(dump, superdec):
    loaded = se.load(dump)
    assert "LIGGGHTS" in loaded.readings[0]
    table = loaded.table()
    built = se.Scene()
    built.add_many(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0.3, 0.2, 0.4], [0.3, 0.2, 0.4], [0.5, 0.5, 0.5]],
        [[8, 2], [2, 8], [2, 2]],
        [[1, 0, 0, 0], [0.7071068, 0, 0, 0.7071068], [1, 0, 0, 0]],
        ids=[7, 3, 5],
        convention="liggghts",
    )
    own = built.table()
    order_file, order_own = np.argsort(table["ids"]), np.argsort(own["ids"])
    for name in ("positions", "radii", "exponents", "rotations", "ids"):
        assert np.allclose(table[name][order_file], own[name][order_own]), name
    fits = se.load(superdec)
    part = fits.table()
    assert np.allclose(part["radii"], [[1, 0.5, 0.25]]) and np.allclose(part["exponents"], [[1.5, 0.5]])
    shape = se.Superquadric((1, 0.5, 0.25), (0.5, 1.5), convention="superdec")
    assert np.allclose(part["exponents"][0], shape.exponents)
    assert np.allclose(matrices(part["rotations"][0]), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-6)


def test_euler_angles_of_conventions():
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    angles = np.array([[0.3, -0.7, 1.1]])
    for name, axes in (("ems", "ZYX"), ("superquadric-lib", "ZYZ"), ("sage", "XYZ")):
        expected = rotation.from_euler(axes, angles).as_matrix()
        assert np.allclose(se.CONVENTIONS[name].rotations(angles, "rotations"), expected), name
    turned = rotation.from_euler("ZYX", angles)
    wxyz = np.roll(turned.as_quat(), 1, axis=1)
    inverse = se.CONVENTIONS["superquadric-parsing"].rotations(wxyz, "rotations")
    assert np.allclose(inverse, turned.inv().as_matrix())
    assert np.allclose(se.CONVENTIONS["ovito"].rotations(turned.as_quat(), "rotations"), turned.as_matrix())


def test_the_picture_is_the_program_s(dump, tmp_path):
    for size in ((64, 48), (40, 60)):
        out = tmp_path / f"theirs{size[0]}.png"
        command = [*PROGRAM, "render", str(dump), "--size", f"{size[0]}x{size[1]}", "-o", str(out), "--quiet"]
        subprocess.run(command, check=True)
        film = se.load(dump).render(*size)
        assert film.to_png() == out.read_bytes()
    scene = tmp_path / "egg.scn"
    scene.write_text("primitive egg\nsetCoeff 100 100 130\nset samples 3\n")
    subprocess.run([*PROGRAM, "render", str(scene), "--size", "50x40", "-o", str(tmp_path / "e.exr"), "--quiet"], check=True)
    film = se.load(scene).render(50, 40, threads=1)
    film.save(tmp_path / "own.exr")
    assert (tmp_path / "own.exr").read_bytes() == (tmp_path / "e.exr").read_bytes()


def test_the_passes_of_a_film():
    scene = se.Scene()
    scene.add(se.Superquadric(1), color=(0.5, 0.25, 1))
    scene.camera = se.Camera((0, 0, 10))
    film = scene.render(41, 31, samples=1)
    assert film.color.shape == film.normal.shape == film.albedo.shape == film.shape == (31, 41, 3)
    assert film.color.dtype == np.float32 and film.depth.shape == film.instance_id.shape == (31, 41)
    assert abs(film.depth[15, 20] - 9) < 1e-3 and film.depth[0, 0] == np.inf
    assert np.allclose(film.normal[15, 20], (0, 0, 1), atol=1e-3)
    assert np.allclose(film.albedo[15, 20], (0.5, 0.25, 1))
    hit = scene.intersect((0, 0, 10), (0, 0, -1))
    assert film.instance_id[15, 20] == hit.instance and film.instance_id[0, 0] == 0
    assert (film.samples == 1).all() and (film.alpha == 1).all()
    assert film.rgb8.dtype == np.uint8 and film.rgb8.shape == film.shape
    assert np.array_equal(np.asarray(film), film.color) and np.array_equal(film[3], film.color[3])
    assert np.asarray(film, dtype=np.float64).dtype == np.float64
    assert film._repr_png_().startswith(b"\x89PNG") and len(film) == 31
    assert np.array_equal(film.color, scene.render(41, 31, samples=1, threads=3).color)
    normal = scene.render(41, 31, output="normal", samples=1)
    assert np.allclose(normal.color[15, 20], (0.5, 0.5, 1), atol=1e-3)


def test_everything_of_a_scene_survives(cloud, tmp_path):
    cloud.add(se.Superquadric((1, 2, 3), (0.5, 1.5)), name="big", material=se.Material(
        color="#ff8000", reflected=0.3, refracted=0.4, index=1.33, fresnel=True, absorb=(0.1, 0.2, 0.3),
        checker=((0, 0, 1), 0.25), gloss=0.2, ambient=0.2, specular=0.3, shininess=70,
    ))
    cloud.camera = se.Camera((9, 1, 2), (0, 0, 1), (0, 0, 1), 35.0, lens=(0.1, 8.0))
    cloud.add_light(se.SpotLight((5, 5, 5), (0, 0, 0), radius=0.5))
    cloud.add_light(se.SunLight((1, 1, 1), radius=0.0047), name="noon")
    cloud.add_light(se.PointLight((5, 0, 5), (1, 0.5, 0.2), 0.01))
    cloud.set_sky((0.7, 0.8, 0.9), (0.1, 0.2, 0.6), up=(0, 0, 1))
    cloud.set_floor(-6, up=(0, 0, 1), material=se.Material(color=(0.5, 0.5, 0.5)))
    cloud.set_ambient_occlusion(4, 2)
    cloud.set_background((0.1, 0.2, 0.3))
    cloud.set(size=(64, 48), samples=2, tone="filmic", exposure=0.5, transparent=False, filter="mitchell")
    assert cloud.lights == ["light1", "noon", "light2"] and cloud.root == "model"
    assert cloud.camera.lens == (0.1, 8.0) and cloud.camera.fov == 35.0
    png = cloud.render(layers=False).to_png()
    cloud.save(tmp_path / "all.sqb")
    cloud.save(tmp_path / "all.scn")
    others = [pickle.loads(pickle.dumps(cloud)), copy.copy(cloud), copy.deepcopy(cloud), se.load(tmp_path / "all.sqb")]
    others += [se.load(tmp_path / "all.scn"), se.loads(cloud.to_text()), se.loads(cloud.to_bytes())]
    for other in others:
        assert other.render(layers=False).to_png() == png
    assert others[0] == cloud and others[1] == cloud
    others[1].set(samples=9)
    assert others[1] != cloud and cloud.settings["samples"] == "2"
    cloud.remove_light("noon")
    assert cloud.lights == ["light1", "light2"]


def test_data_is_framed_for_every_size_until_a_camera_is_set(dump):
    scene = se.load(dump)
    wide, high = scene.render(60, 20, samples=1), scene.render(20, 60, samples=1)
    assert (wide.instance_id > 0).any() and (high.instance_id > 0).any()
    kept = pickle.loads(pickle.dumps(scene))
    assert kept.render(20, 60, samples=1).to_png() == high.to_png()
    scene.look_at((0, 0, 1000))
    scene2 = scene.copy()
    assert scene2.camera.position == (0, 0, 1000)
    assert (scene2.render(20, 60, samples=1).instance_id > 0).sum() < (high.instance_id > 0).sum()


def test_files_of_all_kinds(dump, superdec, tmp_path):
    both = se.load([dump, superdec])
    assert both.instance_count == 4 and len(both.readings) == 2
    with open(dump, "rb") as file:
        assert se.load(file).instance_count == 3
    with open(dump) as file:
        assert se.load(file).instance_count == 3
    by_speed = se.load(dump, color_by="speed", colormap="magma", range=(0, 3)).table()["colors"]
    assert len(np.unique(by_speed, axis=0)) == 3
    assert se.load(dump, images=(2, 1, 1), box=True, type_colors=True).instance_count == 6 + 12
    eleven = "1 0.5 1 2 3 0.1 0.2 0.3 4 5 6\n"
    ems = se.loads(eleven, convention="ems").table()
    assert np.allclose(ems["exponents"], [[0.5, 1]]) and np.allclose(ems["positions"], [[4, 5, 6]])
    lib = se.loads(eleven, convention="superquadric-lib").table()
    assert np.allclose(lib["radii"], [[1, 0.5, 1]])
    with pytest.warns(se.FormatWarning, match="quaternion|length"):
        se.loads(dump.read_text().replace("0.7071068", "0.9"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        se.load(superdec)


def test_a_million_shapes_in_one_call():
    n = 1_000_000
    rng = np.random.default_rng(1)
    scene = se.Scene()
    scene.add_many(
        rng.uniform(-100, 100, (n, 3)), rng.uniform(0.2, 0.6, (n, 3)), (0.7, 0.9), rng.normal(size=(n, 4)),
        colors=rng.uniform(size=(n, 3)), name="sand",
    )
    assert scene.instance_count == n
    hits = scene.intersect(rng.uniform(-1, 1, (10000, 3)), rng.normal(size=(10000, 3)))
    assert hits.hit.mean() > 0.9


def test_progress_is_called_and_its_errors_stop_the_render():
    scene = se.Scene()
    scene.add(se.Superquadric(1))
    seen = []
    scene.render(64, 48, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (64 * 48, 64 * 48)

    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        scene.render(4000, 4000, samples=64, progress=stop)
    scene.render(32, 32, progress=True)


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_stops_within_a_second(tmp_path):
    script = tmp_path / "long.py"
    script.write_text(
        "import superegg as se\nscene = se.Scene()\nscene.add(se.Superquadric(1))\n"
        "print('begins', flush=True)\nscene.render(8000, 8000, samples=4000)\n"
    )
    process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begins\n"
    time.sleep(1.0)
    process.send_signal(2)
    _, errors = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors


def test_the_lock_is_free_while_rays_are_traced(cloud):
    """Another thread of Python runs meanwhile."""
    rng = np.random.default_rng(1)
    origins, directions = rng.uniform(-6, 6, (300_000, 3)), rng.normal(size=(300_000, 3))
    cloud.intersect(origins[:10], directions[:10])
    turns, done = 0, threading.Event()
    results = []

    def trace():
        results.append(cloud.intersect(origins, directions))
        done.set()

    thread = threading.Thread(target=trace)
    thread.start()
    while not done.is_set():
        turns += 1
        time.sleep(0.001)
    thread.join()
    assert turns > 3 and len(results[0]) == 300_000


def test_the_program_is_in_the_package(tmp_path):
    run = subprocess.run([*PROGRAM, "--version"], capture_output=True, text=True)
    assert run.returncode == 0 and se.__version__ in run.stdout
    run = subprocess.run([*PROGRAM, "rendr"], capture_output=True, text=True)
    assert run.returncode == 2 and "did you mean 'superegg render'" in run.stderr


@pytest.fixture
def pair(tmp_path):
    """Two shapes of two colours, far from each other, and the file of the scene."""
    scene = se.Scene()
    scene.add(se.Superquadric((1, 2, 0.5), (0.3, 1)), name="tile", position=(3, 0, 0), color="red")
    scene.add(se.Superquadric(1, (2, 2)), name="gem", position=(-3, 0, 0), rotation=[0.5, 0.5, 0.5, 0.5], color="#00ff00")
    scene.save(tmp_path / "pair.scn")
    return scene, tmp_path / "pair.scn"


def test_exports_are_the_program_s(pair, tmp_path):
    scene, file = pair
    for ending in ("stl", "ply", "obj", "glb", "vtp", "pov", "liggghts", "data", "txt", "npy", "csv", "nrrd", "vti"):
        here, there = tmp_path / f"here/file.{ending}", tmp_path / f"there/file.{ending}"
        here.parent.mkdir(exist_ok=True)
        there.parent.mkdir(exist_ok=True)
        losses = scene.export(here, tolerance=0.02, grid=16)
        command = [*PROGRAM, "export", str(file), "-o", str(there), "--tolerance", "0.02", "--grid", "16"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        assert here.read_bytes() == there.read_bytes(), ending
        assert all(loss in done.stderr for loss in losses)
    assert (tmp_path / "here/file.mtl").read_bytes() == (tmp_path / "there/file.mtl").read_bytes()
    scene.save(tmp_path / "saved.STL")
    scene.export(tmp_path / "exported.stl")
    assert (tmp_path / "saved.STL").read_bytes() == (tmp_path / "exported.stl").read_bytes()


def test_a_scene_s_mesh_has_its_instances(pair):
    scene, _ = pair
    mesh = scene.mesh(1e-3)
    assert mesh.names == ["model/tile", "model/gem"] and mesh.colors.shape == (2, 3)
    assert set(mesh.instance) == {0, 1} and mesh.faces.max() == len(mesh.vertices) - 1
    assert np.abs(scene.signed_distance(mesh.vertices)).max() < 1e-9
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    volumes = np.bincount(mesh.instance, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)
    exact = [se.Superquadric((1, 2, 0.5), (0.3, 1)).volume, 4 / 3]
    assert np.allclose(volumes, exact, rtol=5e-3)
    assert (mesh.face_colors()[mesh.instance == 1] == [0, 255, 0]).all()
    assert np.array_equal(scene.mesh(2e-3, absolute=True).instance.max(), 1)


def test_a_scene_is_a_trimesh(pair):
    trimesh = pytest.importorskip("trimesh")
    mesh = pair[0].to_trimesh()
    assert isinstance(mesh, trimesh.Trimesh) and mesh.is_watertight and mesh.body_count == 2
    assert tuple(mesh.visual.face_colors[0]) == (255, 0, 0, 255)


def test_wrong_exports_say_what_is_right(tmp_path, pair):
    scene, _ = pair
    for wrong, text in [
        (lambda: scene.export(tmp_path / "a.jpg"), r"\.glb \(glTF\)"),
        (lambda: se.Scene().export(tmp_path / "a.stl"), "nothing to write"),
        (lambda: se.Scene().mesh(), "nothing to write"),
        (lambda: scene.mesh(0), "above 0"),
        (lambda: scene.mesh(1e-12), "triangles"),
        (lambda: scene.mesh(depth=65), "0 to 64"),
        (lambda: scene.export(tmp_path / "a.vti", grid=2), "4 to 512"),
        (lambda: scene.export(tmp_path / "a.vti", value="color"), "inside-outside"),
    ]:
        with pytest.raises(ValueError, match=text):
            wrong()
    assert not list(tmp_path.glob("a.*"))


def test_light_by_paths_is_that_of_the_sky():
    scene = se.Scene()
    scene.add(se.Superquadric(1, (0.4, 0.7)), material=se.Material(diffuse=0.5, specular=0, color=(1, 1, 1)))
    scene.set_background((1, 1, 1))
    scene.look_at(position=(0, 0, 5), target=(0, 0, 0), fov=10)
    scene.add_light(se.SunLight((0, 0, 1), color=(0.0, 0.0, 0.0)))
    assert np.allclose(scene.render(8, 8, samples=1, light="path").color, 0.5, atol=1e-6)
    scene.add(se.Superquadric(50), material=se.Material(emission=3.0, diffuse=0, specular=0, color=(1, 1, 1)))
    assert np.allclose(scene.render(8, 8, samples=1, light="path").color, 1.5, atol=1e-5)


def test_keys_make_frames():
    scene = se.Scene()
    scene.add(se.Superquadric(1), name="ball")
    scene.add(se.Superquadric(1), position=(0, 5, 0), name="other")
    scene.run("setCursor ball")
    scene.key(0, "translate 0 0 0")
    scene.key(8, "translate 4 0 0")
    scene.key(8, "camera 0 0 9 0 0 0")
    assert scene.key_frames == [0.0, 8.0]
    assert scene.at(8).bounds[1, 0] == pytest.approx(5.0, abs=1e-5) and scene.at(-1).bounds[1, 0] == pytest.approx(1.0, abs=1e-5)
    assert scene.at(8).key_frames == [] and scene.at(8).camera.position == (0.0, 0.0, 9.0)
    with pytest.raises(se.FormatError, match="key"):
        scene.key(4, "translate 1 2")
    with pytest.raises(ValueError, match="frame: expected finite"):
        scene.at(float("nan"))


def test_hidden_shapes_are_not_there():
    scene = se.Scene()
    scene.add(se.Superquadric(1), name="ball")
    scene.add(se.Superquadric(1), position=(5, 0, 0), name="other")
    scene.run("hide other")
    assert scene.instance_count == 1 and not scene.intersect([5, 0, 9], [0, 0, -1]).hit
    assert scene.mesh().names == ["model/ball"]
    assert se.loads(scene.to_bytes(), name="a.sqb") == scene
    scene.run("unhide")
    assert scene.instance_count == 2


def test_a_scene_is_framed_as_its_picture_is():
    scene = se.Scene()
    scene.add(se.Superquadric(2), position=(90, 0, 0))
    picture = scene.render(40, 30, samples=1).to_png()
    scene.frame(40, 30)
    assert scene.lights and scene.camera.target[0] == pytest.approx(90, abs=1)
    assert scene.render(40, 30, samples=1).to_png() == picture
    camera = scene.camera
    scene.add(se.Superquadric(50))
    scene.frame()
    assert scene.camera == camera, "a camera that is set stays"


def test_the_albedo_is_the_colour_without_light():
    scene = se.Scene()
    scene.add(se.Superquadric(1), color=(0.2, 0.4, 0.8))
    film = scene.render(21, 21, output="albedo", samples=1)
    assert np.allclose(film.color[10, 10], (0.2, 0.4, 0.8), atol=1e-6) and (film.color[0, 0] == 0).all()
    assert film.rgb8[10, 10].tolist() == [124, 170, 231]


def test_slices_of_rays_make_no_difference():
    scene = se.Scene()
    rng = np.random.default_rng(3)
    scene.add_many(rng.uniform(0, 5, (200, 3)), 0.3, (0.5, 1))
    origins, ways = rng.uniform(0, 5, (300_000, 3)), rng.normal(size=(300_000, 3))
    all_, parts = scene.intersect(origins, ways), [scene.intersect(origins[i:j], ways[i:j]) for i, j in ((0, 777), (777, 300_000))]
    assert (all_.instance == np.concatenate([part.instance for part in parts])).all()
    assert np.allclose(np.nan_to_num(all_.t, posinf=0), np.nan_to_num(np.concatenate([part.t for part in parts]), posinf=0), rtol=1e-12, atol=1e-12)
    blocked = np.concatenate([scene.occluded(origins[i:j], ways[i:j]) for i, j in ((0, 777), (777, 300_000))])
    assert (scene.occluded(origins, ways) == blocked).all() and (blocked == all_.hit).mean() > 0.999999


def test_rough_metal_and_glass_in_a_white_world_are_white(tmp_path):
    white = (1, 1, 1)
    for material in (
        se.Material(color=white, metallic=1.0, roughness=0.4),
        se.Material(color=white, diffuse=1.0, roughness=0.7),
        se.Material(color=white, refracted=1.0, roughness=0.3),
    ):
        scene = se.Scene()
        scene.add(se.Superquadric(1, (0.4, 0.7)), material=material)
        scene.set_background(white)
        scene.look_at(position=(0, 0, 5), target=(0, 0, 0), fov=10)
        scene.add_light(se.SunLight((0, 0, 1), color=(0.0, 0.0, 0.0)))
        assert abs(scene.render(8, 8, samples=64, light="path").color.mean() - 1) < 2e-2


def test_surroundings_are_seen_and_missing_ones_are_errors(tmp_path):
    scene = se.Scene()
    scene.add(se.Superquadric(0.01))
    scene.look_at(position=(0, 0, 5), target=(0, 0, 0), fov=10)
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    (tmp_path / "grey.hdr").write_bytes(header + bytes([128, 128, 128, 128] * 2))
    scene.set_environment(tmp_path / "grey.hdr", scale=2.0)
    assert np.allclose(scene.render(8, 8, samples=1).color[0, 0], 1.0)
    scene.set_daylight(elevation=40, azimuth=30)
    assert scene.render(8, 8, samples=1).color[0, 0].min() > 0
    scene.set_environment(tmp_path / "none.hdr")
    with pytest.raises(ValueError, match="none.hdr"):
        scene.render(8, 8, samples=1)


def test_files_are_found_beside_the_scene_that_names_them(tmp_path):
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    for folder in ("scene", "lib", "other"):
        (tmp_path / folder).mkdir()
    (tmp_path / "lib" / "grey.hdr").write_bytes(header + bytes([128, 64, 128, 128] * 2))
    (tmp_path / "scene" / "s.scn").write_text("load ../lib/t.scn\n")
    lines = "prm ball\ntexture color grey.hdr\nambient 1\ndiffuse 0\nspecular 0\nenvironment grey.hdr\n"
    (tmp_path / "lib" / "t.scn").write_text(lines)

    def check(scene):
        film = scene.render(8, 8, samples=1)
        assert np.allclose(film.color[0, 0], [0.5, 0.25, 0.5])
        assert np.allclose(film.color[4, 4], [0.5, 0.25, 0.5])

    scene = se.load(tmp_path / "scene" / "s.scn")
    check(scene)
    check(scene.at(0.0))
    for name in ("a.scn", "a.sqb"):
        scene.save(tmp_path / "other" / name)
        check(se.load(tmp_path / "other" / name))
    assert '"../lib/grey.hdr"' in (tmp_path / "other" / "a.scn").read_text()


def test_denoising_needs_its_library_and_makes_a_film_smoother(monkeypatch):
    scene = se.Scene()
    scene.add(se.Superquadric(1))
    scene.look_at(position=(0, 0, 5), target=(0, 0, 0), fov=10)
    scene.run("sky 0 0 0 1 1 1")
    settings = {"samples": 2, "light": "path"}
    noisy = scene.render(48, 48, **settings)
    try:
        clean = scene.render(48, 48, denoise=True, **settings)
    except ValueError as error:
        assert "Open Image Denoise 2" in str(error)
        pytest.skip(str(error))
    steps = [np.abs(np.diff(film.color, axis=0)).mean() for film in (noisy, clean)]
    assert steps[1] < steps[0]
    monkeypatch.setenv("SUPEREGG_OIDN", "/none/such.so")
    with pytest.raises(ValueError, match="Open Image Denoise 2"):
        scene.render(8, 8, denoise=True)


def test_quaternions_of_any_length_are_rotations():
    """The square of a length may be too large or too small for float64."""
    turn = np.array([0.1, -0.7, 0.5, 0.3])
    expected = matrices(turn)
    for length in (1e-200, 1e-5, 1e200):
        assert np.allclose(matrices(length * turn), expected)
        scene = se.Scene()
        scene.add_many(np.zeros((2, 3)), 1, rotations=np.stack([turn, length * turn]))
        one, two = scene.table()["rotations"]
        assert np.allclose(one, two)


def test_the_camera_that_is_set_is_the_camera():
    """Nothing of the camera before it stays."""
    scene = se.Scene()
    for camera in (
        se.Camera((1.0, 2.0, 3.0), ortho_height=4.0, lens=(0.1, 3.0)),
        se.Camera((1.0, 2.0, 3.0), fov=50.0),
        se.Camera((1.0, 2.0, 3.0), lens=(0.2, 3.0)),
        se.Camera((1.0, 2.0, 3.0), ortho_height=2.0),
    ):
        scene.camera = camera
        assert scene.camera == camera


def test_hits_survive_pickling(cloud):
    origins = np.random.default_rng(3).uniform(-6, 6, (200, 2, 3))
    hits = cloud.intersect(origins, [0, 0, 1])
    assert 0 < hits.hit.sum() < hits.t.size
    for other in (pickle.loads(pickle.dumps(hits)), copy.deepcopy(hits), copy.copy(hits)):
        assert np.array_equal(other.names(), hits.names()) and np.array_equal(other.t, hits.t)
        assert np.array_equal(other.instance, hits.instance)


def test_a_film_is_copied():
    scene = se.Scene()
    scene.add(se.Superquadric(1))
    film = scene.render(8, 6)
    for other in (copy.copy(film), copy.deepcopy(film)):
        assert other.to_png() == film.to_png()


@pytest.mark.parametrize("threads", [1, 10**9])
def test_threads_do_not_change_a_picture_or_hits(cloud, threads):
    assert cloud.render(24, 16, threads=threads).to_png() == cloud.render(24, 16).to_png()
    p = np.random.default_rng(4).uniform(-6, 6, (3000, 3))
    assert np.array_equal(cloud.intersect(p, -p, threads=threads).t, cloud.intersect(p, -p).t)
    assert np.array_equal(cloud.inside(p, threads=threads), cloud.inside(p))


def test_lines_end_where_the_program_s_do():
    scene = se.Scene()
    scene.run("# a comment\x0cprimitive no\rprimitive yes\r\nprimitive too")
    assert {name for name, kind in scene.names().items() if kind == "primitive"} == {"yes", "too"}


LONG = {
    "value": "shape.value(np.random.rand(40_000_000, 3))",
    "signed_distance": "star.signed_distance(np.random.rand(45_000, 3) * [1, 0.01, 0.01], tolerance=1e-14)",
    "sample_surface": "shape.sample_surface(200_000_000)",
    "sample_inside": "shape.sample_inside(200_000_000)",
    "fit": "se.fit(np.tile(cloud, (4, 1)) + np.random.normal(scale=0.01, size=(4_000_000, 3)), most_points=10**7)",
    "residuals": "found.residuals(np.random.rand(1_000_000, 3))",
    "export": "many.export('a.obj', tolerance=1.08e-3)",
    "run": "many.run(lines)",
    "intersect": "many.intersect(np.random.rand(8_000_000, 3), [[1, 2, 3]])",
}


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_stops_long_calls(tmp_path, name):
    """Samples, fits and residuals take more than a minute on two cores, the others seconds."""
    script = tmp_path / "long.py"
    script.write_text(f"""
import numpy as np, superegg as se, threading, time
shape, star = se.Superquadric((1, 2, 3), (0.5, 1.5)), se.Superquadric((1, 2, 3), (2.9, 2.8))
cloud = np.repeat(shape.sample_surface(1000)[0], 1000, axis=0)
cloud = cloud + np.random.default_rng(1).normal(scale=0.01, size=cloud.shape)
found = se.fit(cloud[::500])
lines = "\\n".join(f"primitive p{{i}}" for i in range(2_000_000))
many = se.Scene()
many.add_many(np.random.default_rng(1).uniform(-9, 9, (3000, 3)), 0.3, (0.5, 1.5))
stopped = threading.Event()
turns = 0
def count():
    global turns
    while not stopped.is_set():
        time.sleep(0.01)
        turns += 1
threading.Thread(target=count, daemon=True).start()
print("begins", flush=True)
begin = time.time()
try:
    {LONG[name]}
    print("ends", time.time() - begin, turns)
except KeyboardInterrupt:
    print("stops", time.time() - begin, turns)
stopped.set()
""")
    process = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    assert process.stdout is not None and process.stdout.readline() == "begins\n"
    time.sleep(2.5)
    process.send_signal(2)
    # What is left of the work ends with the process.
    output, errors = process.communicate(timeout=60)
    word, seconds, turns = (output.split() or ["ends", "0", "0"])[:3]
    # On a fast machine some may end before.
    assert (word == "stops" and int(turns) > 10) or float(seconds) < 2.5, errors


def test_the_lock_is_free_while_another_thread_compiles():
    """A scene that is being compiled is waited for without the interpreter's lock."""
    rng = np.random.default_rng(1)
    scene = se.Scene()
    scene.add_many(rng.uniform(-99, 99, (400_000, 3)), rng.uniform(0.2, 0.6, (400_000, 3)), (0.7, 0.9))
    thread = threading.Thread(target=lambda: scene.bounds)
    waits = threading.Thread(target=lambda: scene.names())
    turns = 0
    thread.start()
    time.sleep(0.01)
    waits.start()
    while thread.is_alive():
        turns += 1
        time.sleep(0.001)
    thread.join()
    waits.join()
    assert turns > 20
