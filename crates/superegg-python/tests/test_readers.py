"""Other programs read our OpenEXR files: OpenEXR, OpenImageIO and a decoder of Cryptomatte, each where it is installed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import superegg as se

LEVELS = {"CryptoInstance": "instance", "CryptoObject": "object"}


@pytest.fixture(scope="module")
def film() -> se.Film:
    scene = se.Scene()
    scene.run(
        """prm ball
        coeff .6 .6 .6
        obj pair
        ap ball left
        xs -1 0 0
        ap ball rück
        xs 1 0 0
        obj all
        ao pair
        ap ball top
        xs 0 2 0
        sky .2 .3 .4 .5 .6 .9"""
    )
    return scene.render(64, 48, samples=16, light="path", cryptomatte=True, transparent=True)


@pytest.fixture(scope="module")
def path(film: se.Film, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("readers") / "film.exr"
    film.save(path)
    return path


def test_the_parts_of_light_add_up(film: se.Film) -> None:
    total = film.emission + film.direct + film.indirect
    np.testing.assert_allclose(total, film.color, rtol=1e-5, atol=1e-6)
    assert set(np.unique(film.instance_number)) == {0, 2, 3, 4}
    assert set(np.unique(film.object_number)) == {0, 2, 3}
    with pytest.raises(ValueError, match="light"):
        _ = se.Scene().render(4, 4).direct


def check_ids(channels: dict[str, np.ndarray], film: se.Film) -> None:
    np.testing.assert_array_equal(channels["instance"], film.instance_number)
    np.testing.assert_array_equal(channels["object"], film.object_number)
    for part in ("emission", "direct", "indirect"):
        colors = np.stack([channels[f"{part}.{c}"] for c in "RGB"], axis=-1)
        np.testing.assert_array_equal(colors, getattr(film, part))
    for level in LEVELS:
        shares = sum(channels[f"{level}{k:02}.{c}"] for k in range(3) for c in "ga")
        np.testing.assert_allclose(shares, film.alpha, atol=1e-6)


def check_manifests(attributes: dict[str, str]) -> dict[str, dict[str, int]]:
    names = {value: key.rsplit("/", 1)[0] for key, value in attributes.items() if key.endswith("/name")}
    assert set(names) == set(LEVELS)
    manifests = {}
    for level, key in names.items():
        assert attributes[f"{key}/hash"] == "MurmurHash3_32"
        assert attributes[f"{key}/conversion"] == "uint32_to_float32"
        manifest = json.loads(attributes[f"{key}/manifest"])
        manifests[level] = {name: int(id, 16) for name, id in manifest.items()}
    assert set(manifests["CryptoInstance"]) == {"all/pair/left", "all/pair/rück", "all/top"}
    assert set(manifests["CryptoObject"]) == {"all/pair", "all/top"}
    return manifests


def test_openexr_reads_them(path: Path, film: se.Film) -> None:
    openexr = pytest.importorskip("OpenEXR")
    with openexr.File(str(path), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        header = dict(file.header())
    check_ids(channels, film)
    np.testing.assert_array_equal(channels["id"], film.instance_id)
    manifests = check_manifests({k: v for k, v in header.items() if k.startswith("cryptomatte/")})
    ids = channels["CryptoInstance00.r"].view(np.uint32)
    assert set(np.unique(ids)) == {0, *manifests["CryptoInstance"].values()}
    # Cut out by name, edges and all.
    left = sum(
        np.where(channels[f"CryptoInstance{k:02}.{i}"].view(np.uint32) == manifests["CryptoInstance"]["all/pair/left"],
                 channels[f"CryptoInstance{k:02}.{s}"], 0)
        for k in range(3) for i, s in ("rg", "ba")
    )
    assert ((left > 0) & (left < 1)).any() and left.max() == 1


def test_openimageio_reads_them_and_they_survive_it(path: Path, film: se.Film, tmp_path: Path) -> None:
    oiio = pytest.importorskip("OpenImageIO")
    image = oiio.ImageBuf(str(path))
    copy = tmp_path / "copy.exr"
    assert image.write(str(copy))
    for file in (path, copy):
        image = oiio.ImageBuf(str(file))
        spec = image.spec()
        pixels = image.get_pixels(oiio.FLOAT)
        channels = {name: pixels[..., i] for i, name in enumerate(spec.channelnames)}
        check_ids(channels, film)
        attributes = {a.name: a.value for a in spec.extra_attribs if a.name.startswith("cryptomatte/")}
        check_manifests(attributes)


def test_a_decoder_of_cryptomatte_cuts_out_objects(path: Path, film: se.Film) -> None:
    cryptomatte = pytest.importorskip("cryptomatte_api")
    found = {matte.metadata().name(): matte for matte in cryptomatte.Cryptomatte.load(str(path))}
    assert set(found) == set(LEVELS)
    for level, parts in (
        ("CryptoInstance", ["all/pair/left", "all/pair/rück", "all/top"]),
        ("CryptoObject", ["all/pair", "all/top"]),
    ):
        masks = found[level].masks(parts)
        np.testing.assert_allclose(sum(masks.values()), film.alpha, atol=1e-6)
    pair = found["CryptoObject"].mask("all/pair")
    left = found["CryptoInstance"].mask("all/pair/left")
    assert (left <= pair + 1e-6).all() and (left < pair).any()
