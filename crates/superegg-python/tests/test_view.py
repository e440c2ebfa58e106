"""The view of a scene in a notebook: its camera, and its widget."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import superegg as se
from superegg._view import ViewState


def scene():
    built = se.Scene()
    built.add(se.Superquadric((1, 1, 2), (0.4, 0.8)), color="orange", name="egg")
    built.look_at((4, -5, 3), up=(0, 0, 1))
    return built


def state(**settings):
    return ViewState(scene(), 48, 36, settings)


def turn(from_, to, drag=1, last=False):
    return {"kind": "turn", "drag": drag, "from": from_, "to": to, "last": last}


def test_a_drag_turns_about_the_target_and_back_to_the_bit():
    view = state()
    before = view.camera
    coarse = view.receive(turn([0, 0], [0.4, 0.1]))
    moved = view.camera
    distance = np.linalg.norm(moved.position)
    assert moved != before and distance == pytest.approx(np.linalg.norm(before.position), rel=1e-12)
    assert view.receive(turn([0, 0], [0.4, 0.1], last=True)) != coarse
    view.receive(turn([0, 0], [0, 0]))
    assert view.camera == before
    # A drag over a sixth of the ball turns by a third: twice the angle.
    view.receive(turn([0, 0], [0.5, 0], drag=2))
    angle = np.degrees(np.arccos(np.dot(view.camera.position, before.position) / distance**2))
    assert angle == pytest.approx(60.0)


def test_the_point_under_the_pointer_goes_with_it():
    view = state()
    view.receive(turn([0, 0], [0.1, 0]))
    # What faced the camera is now to the right of the middle of the picture.
    here, up = np.array(view.camera.position), np.array(view.camera.up)
    right = np.cross(up, here)
    assert np.dot(right, scene().camera.position) > 0 and abs(np.dot(up, scene().camera.position)) < 1e-9


def test_the_wheel_zooms_and_the_scene_stays_as_it_is():
    original = scene()
    view = ViewState(original, 48, 36, {"samples": 2})
    view.receive({"kind": "zoom", "drag": 0, "factor": 0.5})
    assert np.allclose(view.camera.position, np.array(original.camera.position) / 2)
    assert original.camera == scene().camera
    full = view.receive({"kind": "sharpen", "drag": 0})
    original.camera = view.camera
    assert full == original.render(48, 36, samples=2, layers=False).to_png()


def test_a_scene_without_a_camera_is_framed():
    far = se.Scene()
    far.add(se.Superquadric(1), position=(500, 0, 0))
    view = ViewState(far, 48, 36, {})
    assert view.picture() == far.render(48, 36, layers=False).to_png()


def test_the_widget_answers_each_message():
    pytest.importorskip("anywidget")
    widget = scene().view(48, 36, samples=1)
    full, count = widget.png, widget.count
    widget._handle_custom_msg(turn([0, 0], [0.3, 0.2]), [])
    assert (widget.count, widget.note) == (count + 1, "") and widget.png != full
    assert full.startswith(b"\x89PNG") and widget.camera != scene().camera
    widget._handle_custom_msg({"kind": "turn"}, [])
    assert widget.count == count + 2 and "KeyError" in widget.note
    widget.camera = scene().camera
    assert widget.png == full and widget.note == ""


def test_without_anywidget_the_error_says_what_to_install(monkeypatch):
    from superegg import _view

    def missing():
        raise ImportError("no anywidget")

    monkeypatch.setattr(_view, "_widget", missing)
    with pytest.raises(ImportError, match="pip install anywidget"):
        scene().view()


# A document with just what the script of the widget uses.
DOCUMENT = """
import { pathToFileURL } from "node:url";
const element = () => ({ style: {}, listeners: {}, children: [],
  append(...parts) { this.children.push(...parts); },
  addEventListener(name, call) { this.listeners[name] = call; },
  setPointerCapture() {},
  getBoundingClientRect() { return { left: 10, top: 20, width: 400, height: 200 }; } });
globalThis.document = { createElement: element };
URL.createObjectURL = () => "blob:1"; URL.revokeObjectURL = () => {};
const sent = [], calls = {};
const model = { values: { size: [400, 200], png: new Uint8Array(3), note: "" },
  get(name) { return this.values[name]; }, send(message) { sent.push(message); },
  on(name, call) { calls[name] = call; }, off(name) { delete calls[name]; } };
const { default: widget } = await import(pathToFileURL(process.argv[2]));
const el = element();
const end = widget.render({ model, el });
const [picture] = el.children;
const at = (x, y, more = {}) => ({ clientX: x, clientY: y, button: 0, pointerId: 1, preventDefault() {}, ...more });
const { pointerdown, pointermove, pointerup, wheel } = picture.listeners;
pointermove(at(0, 0));
pointerdown(at(210, 120));
for (const x of [220, 230, 310]) pointermove(at(x, 120));
pointerup(at(310, 20));
const before = sent.length;
calls["change:count"]();
for (let i = 0; i < 3; i++) wheel(at(0, 0, { deltaY: 5 }));
calls["change:count"]();
end();
console.log(JSON.stringify({ sent, before, src: picture.src, calls: Object.keys(calls) }));
process.exit(0);
"""


def test_the_script_sends_one_request_at_a_time(tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not on this machine")
    script = tmp_path / "view.mjs"
    script.write_text((Path(se.__file__).parent / "_view.js").read_text())
    driver = tmp_path / "driver.mjs"
    driver.write_text(DOCUMENT)
    run = subprocess.run([node, driver, script], check=True, capture_output=True, text=True, timeout=60)
    found = json.loads(run.stdout)
    assert found["src"] == "blob:1" and found["calls"] == [] and found["before"] == 1
    first, second, third = found["sent"]
    assert (first["from"], first["to"], first["last"]) == ([0, 0], [0.1, 0], False)
    # The moves meanwhile are one, with the end of the drag.
    assert (second["to"], second["last"]) == ([1, 1], True)
    assert third["kind"] == "zoom" and third["factor"] == pytest.approx(np.exp(0.3))
