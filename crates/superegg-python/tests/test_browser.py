"""The view whose rays the browser traces: what Python sends, and what it takes back."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import superegg as se
from superegg import _browser
from superegg._browser import Assets, Hit, camera_of, content_of, numbers_of, pictures_of

TILE = Path(__file__).parents[3] / "scenes" / "tile.png"


def scene():
    built = se.Scene()
    built.add(se.Superquadric((1, 1, 2), (0.4, 0.8)), color="orange", name="egg")
    built.look_at((4, -5, 3), up=(0, 0, 1))
    return built


@pytest.fixture
def assets(tmp_path, monkeypatch):
    """A folder in place of the built module."""
    (tmp_path / "widget.js").write_text("export default { render() {} };")
    (tmp_path / "superegg.wasm.gz").write_bytes(b"module")
    monkeypatch.setenv("SUPEREGG_WEB", str(tmp_path))
    return tmp_path


@pytest.fixture
def widget(assets):
    pytest.importorskip("anywidget")
    return scene().view(320, 240, where="browser", samples=4)


def test_the_widget_has_the_scene_and_the_settings_of_its_picture(widget):
    shown = widget.scene
    assert (widget.size, widget.output, widget.hit) == ((320, 240), "light", None)
    assert shown.settings["samples"] == "4" and shown.camera == widget.camera == scene().camera
    # The picture of the kernel's view.
    assert shown.render(layers=False).to_png() == scene().render(320, 240, samples=4, layers=False).to_png()
    assert widget._esm.startswith("export default") and widget.module == ""


def test_what_the_browser_sets_comes_back(widget):
    seen = []
    widget.observe(lambda change: seen.append((change.name, change.new)), ["camera", "hit"])
    widget.set_state({"camera": [1, 2, 3, 0, 0, 0, 0, 0, 1, 35, 0]})
    widget.set_state({"hit": {"t": 2, "point": [1, 2, 3], "normal": [0, 0, 1], "path": "a/egg", "primitive": "egg", "steps": None}})
    assert seen[0] == ("camera", se.Camera((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 35.0))
    assert widget.hit == Hit(2.0, (1.0, 2.0, 3.0), (0.0, 0.0, 1.0), "a/egg", "egg", None)
    widget.set_state({"hit": None})
    assert seen[-1] == ("hit", None)
    taken = scene()
    taken.camera = widget.camera
    assert taken.camera == widget.camera


def test_what_python_sets_goes_to_the_browser(widget):
    other = scene()
    other.add(se.Superquadric(0.5), position=(3, 0, 0), name="ball")
    widget.scene = other
    assert "ball" in widget.text and widget.get_state()["text"] == widget.text
    camera = se.Camera((0, 0, 9), ortho_height=4.0)
    widget.camera = camera
    assert widget.get_state()["camera"] == [0, 0, 9, 0, 0, 0, 0, 1, 0, 60, 4]
    widget.frame, widget.output = 12, "normal"
    with pytest.raises(Exception, match="output"):
        widget.output = "beauty"


def test_the_module_is_sent_when_it_is_asked_for(widget, monkeypatch):
    sent = []
    monkeypatch.setattr(widget, "send", lambda content, buffers: sent.append((content, buffers)))
    widget._handle_custom_msg({"kind": "module"}, [])
    widget._handle_custom_msg({"kind": "other"}, [])
    assert sent == [({"kind": "module"}, [b"module"])]


def test_cameras_cross_and_keep_their_lens():
    camera = se.Camera((4.0, -5.0, 3.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), 33.0, 2.5, (0.1, 4.0))
    assert camera_of(numbers_of(camera), camera) == camera
    flat = camera_of([*numbers_of(camera)[:10], 0.0], camera)
    assert flat.ortho_height is None and flat.lens == (0.1, 4.0)


def test_a_table_goes_as_a_binary_file(assets):
    grains = scene()
    rng = np.random.default_rng(3)
    grains.add_many(rng.uniform(-2, 2, (4000, 3)), rng.uniform(0.05, 0.1, (4000, 3)), (0.5, 0.8), name="grains")
    content = content_of(grains)
    assert content["text"] == "" and len(content["binary"]) < 600_000
    assert se.loads(content["binary"], name="scene").instance_count == grains.instance_count
    pytest.importorskip("anywidget")
    view = grains.view(where="browser")
    assert view.scene.instance_count == 4001
    view.text = "primitive a"
    assert view.binary == b"" and view.scene.instance_count == 1


def test_pictures_that_the_scene_names_are_sent(assets, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(TILE, "tile.png")
    named = scene()
    named.run("primitive tile\nsetTexture color tile.png\nsetTexture roughness missing.png")
    named.set_environment("sky.hdr")
    assert pictures_of(named) == {"tile.png": TILE.read_bytes()}
    assert [name for name, _ in named._core.picture_files()] == ["missing.png", "sky.hdr", "tile.png"]
    named.run("primitive tile\nkey 0 setTexture bump keyed.png 1")
    assert [name for name, _ in named._core.picture_files()] == ["keyed.png", "missing.png", "sky.hdr", "tile.png"]
    # Beside a scene's file, too.
    (tmp_path / "scenes").mkdir()
    shutil.move("tile.png", "scenes/beside.png")
    Path("scenes/a.scn").write_text("primitive a\nsetTexture color beside.png\n")
    beside = se.load("scenes/a.scn")
    assert pictures_of(beside) == {"beside.png": TILE.read_bytes()}
    pytest.importorskip("anywidget")
    view = beside.view(32, 24, where="browser", samples=1)
    assert view.scene.render(layers=False).to_png() == beside.render(32, 24, samples=1, layers=False).to_png()


def test_where_the_module_comes_from(tmp_path, monkeypatch):
    monkeypatch.delenv("SUPEREGG_WEB", raising=False)
    monkeypatch.setattr(_browser, "CARRIED", tmp_path)
    with pytest.raises(FileNotFoundError, match="built without the module.*build.sh --widget"):
        Assets.found()
    monkeypatch.setenv("SUPEREGG_WEB", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="no widget.js and no superegg.wasm.gz"):
        Assets.found()
    monkeypatch.setenv("SUPEREGG_WEB", "https://example.org/superegg/")
    found = Assets.found()
    assert found.script == "https://example.org/superegg/widget.js"
    assert found.module_address == "https://example.org/superegg/superegg.wasm.gz"


def test_wrong_calls_say_what_to_do(assets, monkeypatch):
    with pytest.raises(ValueError, match="expected 'kernel' or 'browser', found 'moon'"):
        scene().view(where="moon")

    def missing():
        raise ImportError("no anywidget")

    monkeypatch.setattr(_browser, "_widget", missing)
    with pytest.raises(ImportError, match="pip install anywidget"):
        scene().view(where="browser")


def test_anywidget_is_imported_once_it_is_used():
    code = "import sys, superegg; superegg.Scene; sys.exit('anywidget' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
