#!/usr/bin/env python3
"""scenes/still_life.scn by paths: processor seconds and error of Superegg, Mitsuba 3 and POV-Ray's radiosity, in one run.

    bench/light.py [--size WxH] [--turns N] [--folder FOLDER] [PROGRAM ...]      # superegg, mitsuba and povray unless given

Needs the packages superegg, numpy and mitsuba, LLVM 16 or later for mitsuba's llvm_ad_rgb (apt-get install libllvm19; scalar_rgb without
it), and povray. The error is the root mean square over pixels and channels of linear light, clipped to [0, 1], against a long reference
of the same program, because the programs' models of light differ. Seconds are user and system time of one thread, the least of the turns.
Those of Superegg and Mitsuba are of the picture alone: files, trees and compiled kernels are ready. Those of POV-Ray are of the whole
program, in one turn. The last columns are Superegg's seconds to the same error, interpolated between its rows on logarithmic scales (beyond them the
error falls with the root of the time), and the ratio. References are kept in FOLDER (default: target/light) and used again.

In Mitsuba the shapes are triangles within a twentieth of a pixel with exact normals, varnish is plastic, absorption is a tint of the
surface, and lights are discs that face the origin, which glass focuses, or points, which have the least noise. Its sampler is multijitter,
which has the least error of those that it has.
"""

import argparse
import glob
import itertools
import math
import os
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import superegg as se

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "scenes" / "still_life.scn"
# Of the scene file: lights (position, radius, colour), camera (field of view: vertical, in degrees) and sky.
LIGHTS = (
    ((-10, -7, 8), 1.5, (0.95, 0.84, 0.66)),
    ((9, -9, 7), 3, (0.14, 0.16, 0.22)),
    ((-3, 7, 8), 1.5, (0.26, 0.23, 0.2)),
)
EYE, TARGET, FIELD_OF_VIEW, SKY = (0.6, -11.5, 4.3), (0.25, 0, 1.25), 27, (0.07, 0.06, 0.05)
# Nothing is nearer to the camera.
LEAST_DISTANCE = 9.5
SUPEREGG, SUPEREGG_REFERENCE = (1, 4, 16, 64), 1024
# Samples of a pixel, and of each of the references, which are as many pictures of the greatest number.
MITSUBA, MITSUBA_REFERENCE = (16, 64, 256), 4
# POV-Ray: rays of a sample of radiosity, its error bound, and options of anti-aliasing.
POVRAY = ((35, 1.8, ["-A"]), (100, 0.8, ["-A"]), (100, 0.8, ["+A0.05", "+AM2", "+R2", "-J"]))
POVRAY_REFERENCE = (400, 0.4, ["+A0.0", "+AM1", "+R3", "-J"])


def error(picture, reference, part=0.0):
    """The error against a reference whose variance is `part` of the picture's; below 0 if the picture's samples are among its own."""
    apart = np.clip(picture, 0, 1) - np.clip(reference, 0, 1)
    return float(np.sqrt(np.mean(apart**2) / (1 + part)))


def timed(work, turns):
    """The least processor seconds of the turns, and the result of the last one."""
    spent = []
    for turn in range(turns):
        start = time.process_time()
        result = work(turn)
        spent.append(time.process_time() - start)
    return min(spent), np.asarray(result, dtype=np.float64)


def kept(path, make):
    """A reference: from its file if there is one."""
    if not path.exists():
        print(f"making {path}", file=sys.stderr)
        np.save(path, make())
    return np.load(path)


def superegg_rows(size, turns, folder):
    scene = se.load(SCENE)

    def picture(samples):
        return scene.render(*size, light="path", samples=samples, layers=False, threads=1).color

    picture(1)
    reference = kept(folder / f"superegg-{size[0]}x{size[1]}-{SUPEREGG_REFERENCE}.npy", lambda: picture(SUPEREGG_REFERENCE))
    for samples in SUPEREGG:
        spent, color = timed(lambda _, samples=samples: picture(samples), turns)
        yield f"Superegg, {samples}", spent, error(color, reference, -samples / SUPEREGG_REFERENCE)


def bsdf(name):
    """The material of a child of the scene."""

    def color(r, g, b):
        return {"type": "rgb", "value": [r, g, b]}

    def matt(*values, diffuse=0.8):
        return {"type": "diffuse", "reflectance": color(*(diffuse * value for value in values))}

    def varnished(*values):
        return {"type": "plastic", "int_ior": 1.5, "diffuse_reflectance": color(*(0.8 * value for value in values))}

    glass = {"type": "dielectric", "int_ior": 1.5}
    # The absorption of half a unit for each surface.
    tint = color(*np.exp(-0.5 * np.array([1.1, 0.25, 0.8])))
    return {
        "wall": matt(0.10, 0.17, 0.22),
        "tabletop": varnished(0.3, 0.14, 0.06),
        "body": {**glass, "specular_transmittance": tint},
        "neck": {**glass, "specular_transmittance": tint},
        "cork": matt(0.55, 0.36, 0.18),
        "belly": matt(0.58, 0.44, 0.05),
        "pear_body": matt(0.58, 0.44, 0.05),
        "stalk": matt(0.12, 0.07, 0.03),
        "apple_skin": varnished(0.5, 0.03, 0.02),
        "silver": {
            "type": "blendbsdf",
            "weight": 0.8,
            "matt": matt(0.8, 0.8, 0.8),
            "mirror": {"type": "conductor", "material": "none"},
        },
        "crystal": glass,
    }.get(name, matt(0, 0, 0))


def mitsuba_scene(mi, scene, size, kind):
    """The scene with lights of a kind: `area` or `point`."""
    up = mi.ScalarTransform4f().look_at(EYE, TARGET, (0, 0, 1))
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    described = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1},
        "sensor": {
            "type": "perspective",
            "fov": FIELD_OF_VIEW,
            "fov_axis": "y",
            "to_world": up,
            "film": film,
            "sampler": {"type": "multijitter"},
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": SKY}},
    }
    for i, (position, radius, color) in enumerate(LIGHTS):
        place, distance = np.array(position, float), np.linalg.norm(position)
        # A white surface that faces the light has the light's colour.
        if kind == "point":
            value = (np.pi * distance**2 * np.array(color)).tolist()
            described[f"light{i}"] = {
                "type": "point",
                "position": place.tolist(),
                "intensity": {"type": "rgb", "value": value},
            }
        else:
            radiance = (np.array(color) * (distance / radius) ** 2).tolist()
            placed = mi.ScalarTransform4f().look_at(position, (0, 0, 0), (0, 0, 1)).scale(radius)
            emitter = {"type": "area", "radiance": {"type": "rgb", "value": radiance}}
            described[f"light{i}"] = {"type": "disk", "to_world": placed, "emitter": emitter}
    pixel = 2 * np.tan(np.radians(FIELD_OF_VIEW / 2)) / size[1] * LEAST_DISTANCE
    mesh = scene.mesh(pixel / 20, absolute=True)
    for i, path in enumerate(mesh.names):
        faces = mesh.faces[mesh.instance == i]
        used, faces = np.unique(faces, return_inverse=True)
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf(path.split("/")[-1]))
        shape = mi.Mesh(path, len(used), len(faces.reshape(-1, 3)), properties, has_vertex_normals=True)
        values = mi.traverse(shape)
        values["vertex_positions"] = mesh.vertices[used].astype(np.float32).ravel()
        values["vertex_normals"] = mesh.normals[used].astype(np.float32).ravel()
        values["faces"] = faces.astype(np.uint32).ravel()
        values.update()
        described[f"shape{i}"] = shape
    return mi.load_dict(described), len(mesh.faces)


def load_mitsuba():
    """The module; with LLVM if there is one that it can use."""

    def version(path):
        return int(re.search(r"(\d+)(\.\d+)*$", path).group(1))

    found = [path for path in glob.glob("/usr/lib/*/libLLVM.so.[0-9]*") if version(path) >= 16]
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", max(found, key=version))
    import mitsuba as mi

    if "DRJIT_LIBLLVM_PATH" in os.environ:
        import drjit

        mi.set_variant("llvm_ad_rgb")
        drjit.set_thread_count(1)
    else:
        mi.set_variant("scalar_rgb")
    return mi


def mitsuba_rows(size, turns, folder):
    mi = load_mitsuba()
    exact = se.load(SCENE)
    for lights in ("area", "point"):
        scene, triangles = mitsuba_scene(mi, exact, size, lights)

        def picture(samples, seed, scene=scene):
            return np.array(mi.render(scene, spp=samples, seed=seed))

        def long_picture(picture=picture):
            return sum(picture(MITSUBA[-1], 1000 + i).astype(np.float64) for i in range(MITSUBA_REFERENCE)) / MITSUBA_REFERENCE

        # Compiles the kernels.
        picture(MITSUBA[0], 0)
        name = f"mitsuba-{lights}-{size[0]}x{size[1]}-{MITSUBA_REFERENCE}x{MITSUBA[-1]}.npy"
        reference = kept(folder / name, long_picture)
        for samples in MITSUBA:
            spent, color = timed(lambda turn, samples=samples: picture(samples, 1 + turn), turns)
            part = samples / (MITSUBA_REFERENCE * MITSUBA[-1])
            text = f"Mitsuba {mi.__version__}, {mi.variant()}, {triangles} triangles, {lights} lights, {samples}"
            yield text, spent, error(color, reference, part)


def povray_picture(size, folder, setting):
    """The processor seconds of the program, and its picture in linear light."""
    import mitsuba as mi

    count, bound, smooth = setting
    file, picture = folder / "povray.pov", folder / "povray.png"
    se.load(SCENE).export(file)
    radiosity = (
        f"pretrace_start 0.08 pretrace_end 0.01 count {count} nearest_count 10 error_bound {bound} recursion_limit 2 "
        "low_error_factor 0.5 gray_threshold 0 minimum_reuse 0.005 brightness 1"
    )
    text, changes = re.subn("ambient_light rgb 1 ", f"ambient_light rgb 0 radiosity {{ {radiosity} }} ", file.read_text())
    assert changes == 1, "the exported scene has other global settings"
    file.write_text(text)
    options = [f"+W{size[0]}", f"+H{size[1]}", "+WT1", "-D", "+FN16", "File_Gamma=1.0", *smooth]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["povray", f"+I{file}", f"+O{picture}", *options], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    # The bytes are those of the file, whatever Mitsuba takes them for.
    return spent, np.array(mi.Bitmap(str(picture)), dtype=np.float64)[..., :3] / 65535


def povray_rows(size, _turns, folder):
    load_mitsuba()
    name = f"povray-{size[0]}x{size[1]}.npy"
    reference = kept(folder / name, lambda: povray_picture(size, folder, POVRAY_REFERENCE)[1])
    for setting in POVRAY:
        count, bound, smooth = setting
        text = f"POV-Ray, radiosity count {count}, error_bound {bound}, {' '.join(smooth)}"
        # One turn: the ratios are large, and so are the seconds.
        spent, picture = povray_picture(size, folder, setting)
        yield text, spent, error(picture, reference)


def seconds_to(target, curve):
    """The seconds to an error by rows of (seconds, error), of which later ones have more seconds and less error."""
    logs = [(math.log(spent), math.log(found)) for spent, found in curve]
    at = math.log(target)
    if at <= logs[-1][1]:
        return math.exp(logs[-1][0] + 2 * (logs[-1][1] - at))
    if at >= logs[0][1]:
        return math.exp(logs[0][0] + 2 * (logs[0][1] - at))
    for (spent, found), (more, less) in itertools.pairwise(logs):
        if less <= at <= found:
            return math.exp(spent + (more - spent) * (found - at) / (found - less))
    raise ValueError("the errors of Superegg do not fall")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--turns", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "light")
    parser.add_argument("programs", nargs="*", default=["superegg", "mitsuba", "povray"])
    arguments = parser.parse_args()
    size = tuple(int(side) for side in arguments.size.split("x"))
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print("| program, samples a pixel | processor s | error | Superegg's s to this error | ratio |")
    print("|---|---|---|---|---|")
    curve = []
    makers = {"superegg": superegg_rows, "mitsuba": mitsuba_rows, "povray": povray_rows}
    for program in arguments.programs:
        for text, spent, found in makers[program](size, arguments.turns, arguments.folder):
            if program == "superegg":
                curve.append((spent, found))
                print(f"| {text} | {spent:.2f} | {found:.5f} | - | - |", flush=True)
            elif curve:
                ours = seconds_to(found, curve)
                print(f"| {text} | {spent:.2f} | {found:.5f} | {ours:.2f} | {spent / ours:.1f} |", flush=True)
            else:
                print(f"| {text} | {spent:.2f} | {found:.5f} | - | - |", flush=True)


if __name__ == "__main__":
    main()
