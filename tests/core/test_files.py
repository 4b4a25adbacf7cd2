import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from tests.core.builders import small_level, small_scene
from wzviewer.core.files import load_scene, save_scene
from wzviewer.core.scene import PHOTO, Scene
from wzviewer.errors import InputError, OutputError


def assert_equal_levels(a, b):
    for name, array in a.surfels.arrays().items():
        np.testing.assert_array_equal(array, b.surfels.arrays()[name], err_msg=name)
    np.testing.assert_array_equal(a.image, b.image)
    np.testing.assert_array_equal(a.relief, b.relief)
    assert a.maps.keys() == b.maps.keys()
    np.testing.assert_array_equal(a.camera.camera_from_world, b.camera.camera_from_world)
    for name in ("fx", "fy", "cx", "cy", "width", "height"):
        assert getattr(a.camera, name) == getattr(b.camera, name)
    np.testing.assert_array_equal(a.frame.origin, b.frame.origin)
    keys = ("index", "parent", "prompt", "seed", "stages", "notes")
    assert [getattr(a, k) for k in keys] == [getattr(b, k) for k in keys]


def test_a_round_trip_is_exact(tmp_path):
    scene = small_scene(3)
    scene.hide(2)
    save_scene(scene, tmp_path / "a.wz")
    loaded = load_scene(tmp_path / "a.wz")
    assert len(loaded) == 3
    assert loaded.hidden == {2}
    for a, b in zip(scene, loaded, strict=True):
        assert_equal_levels(a, b)
    save_scene(loaded, tmp_path / "b.wz")
    assert (tmp_path / "a.wz").read_bytes() == (tmp_path / "b.wz").read_bytes()


def with_finer_photo(scene, shape):
    """The same levels, the first with a photograph of another size."""
    finer = Scene()
    for level in scene:
        own = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
        finer.append(replace(level, maps={**level.maps, PHOTO: own}) if level.index == 0 else level)
        finer.commit(level.index)
    return finer


def test_the_photograph_is_kept_to_the_bit(tmp_path):
    scene = small_scene(2)
    height, width = scene[0].image.shape[:2]
    scene = with_finer_photo(scene, (3 * height, 3 * width, 3))
    save_scene(scene, tmp_path / "a.wz")
    np.testing.assert_array_equal(load_scene(tmp_path / "a.wz")[0].maps[PHOTO], scene[0].maps[PHOTO])


def test_a_photograph_coarser_than_its_level_is_refused(tmp_path):
    save_scene(with_finer_photo(small_scene(2), (2, 2, 3)), tmp_path / "a.wz")
    with pytest.raises(InputError, match="photograph"):
        load_scene(tmp_path / "a.wz")


def test_only_finished_levels_are_saved(tmp_path):
    scene = small_scene(2)
    scene.append(small_level(scene, 1, scene[1].camera.zoomed_to_region(0.5, 0.5, 8.0)))
    save_scene(scene, tmp_path / "a.wz")
    assert len(load_scene(tmp_path / "a.wz")) == 2


def rewrite(path, change):
    with zipfile.ZipFile(path) as archive:
        entries = {i.filename: archive.read(i) for i in archive.infolist()}
    change(entries)
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in entries.items():
            archive.writestr(name, data)


def edit_manifest(**changes):
    def change(entries):
        manifest = json.loads(entries["manifest.json"])
        entries["manifest.json"] = json.dumps({**manifest, **changes}).encode()

    return change


def edit_header(**changes):
    def change(entries):
        manifest = json.loads(entries["manifest.json"])
        manifest["levels"][1].update(changes)
        entries["manifest.json"] = json.dumps(manifest).encode()

    return change


def replace_entry(name, data):
    def change(entries):
        entries[name] = data

    return change


SURFELS, IMAGE = "levels/001/surfels.safetensors", "levels/001/image.png"
DAMAGE = {
    "no manifest": lambda e: e.pop("manifest.json"),
    "manifest no json": replace_entry("manifest.json", b"{"),
    "deep json": replace_entry("manifest.json", b"[" * 100_000),
    "other format": edit_manifest(format="zip"),
    "from the future": edit_manifest(version=99),
    "no levels": edit_manifest(levels=[]),
    "levels no list": edit_manifest(levels=7),
    "parent ahead": edit_header(parent=5),
    "negative index": edit_header(index=-1),
    "camera nan": edit_header(camera={"fx": "nan"}),
    "no camera": edit_header(camera=None),
    "bad frame": edit_header(frame={"origin": [1, 2], "axes": 3, "unit": 1}),
    "missing surfels": lambda e: e.pop(SURFELS),
    "surfels garbage": replace_entry(SURFELS, b"\xff" * 64),
    "surfels header bomb": replace_entry(SURFELS, (1 << 60).to_bytes(8, "little") + b"{}"),
    "image garbage": replace_entry(IMAGE, b"no picture"),
    "image bomb": replace_entry(IMAGE, b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + b"\x7f" * 40),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_a_damaged_scene_is_refused_in_one_line(tmp_path, damage):
    path = tmp_path / "a.wz"
    save_scene(small_scene(2), path)
    rewrite(path, damage)
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert "\n" not in caught.value.line()


def test_a_compressed_entry_is_refused(tmp_path):
    path = tmp_path / "a.wz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("manifest.json", b" " * 1_000_000)
    with pytest.raises(InputError, match="compressed"):
        load_scene(path)


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_scene_is_refused(tmp_path, keep):
    path = tmp_path / "a.wz"
    save_scene(small_scene(2), path)
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep)])
    with pytest.raises(InputError):
        load_scene(path)


def test_flipped_bits_never_crash(tmp_path):
    path = tmp_path / "a.wz"
    save_scene(small_scene(2), path)
    original = path.read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for _ in range(60):
        data = bytearray(original)
        data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        try:
            load_scene(path)
        except InputError:
            refused += 1
    assert refused > 50  # measured 60 of 60: nearly every byte is under a CRC or checked


def test_unknown_fields_are_kept(tmp_path):
    path = tmp_path / "a.wz"
    save_scene(small_scene(1), path)
    rewrite(path, edit_manifest(favourite="leaf"))
    save_scene(load_scene(path), path)
    with zipfile.ZipFile(path) as archive:
        assert json.loads(archive.read("manifest.json"))["favourite"] == "leaf"


def test_saving_into_a_missing_folder_says_so(tmp_path):
    with pytest.raises(OutputError, match="no such file"):
        save_scene(small_scene(1), tmp_path / "nowhere" / "a.wz")


def test_a_failing_save_leaves_the_older_file(tmp_path, monkeypatch):
    path = tmp_path / "a.wz"
    save_scene(small_scene(1), path)
    before = path.read_bytes()
    monkeypatch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(OutputError, match="no space left"):
        save_scene(small_scene(2), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.wz"]


@pytest.mark.parametrize("make", ["missing", "folder", "text", "empty"])
def test_what_is_no_scene_is_refused(tmp_path, make):
    path = tmp_path / "a.wz"
    if make == "folder":
        path.mkdir()
    elif make != "missing":
        path.write_text("hello" if make == "text" else "")
    with pytest.raises(InputError):
        load_scene(path)
