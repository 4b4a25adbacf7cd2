import cv2
import numpy as np
import pytest

from wzviewer.core.photos import (
    check_writable,
    decode_png,
    encode_png,
    finer_photo,
    fit_photo,
    load_cutout,
    load_photo,
)
from wzviewer.errors import InputError, OutputError


@pytest.fixture
def gradient():
    y, x = np.mgrid[0:60, 0:90]
    return np.stack([x * 2, y * 4, 255 - x], axis=-1).astype(np.uint8)


def write(path, image, *options):
    code = cv2.COLOR_RGBA2BGRA if image.ndim == 3 and image.shape[2] == 4 else cv2.COLOR_RGB2BGR
    cv2.imwrite(str(path), cv2.cvtColor(image, code) if image.ndim == 3 else image, *options)
    return path


def test_png_colours_are_exact(tmp_path, gradient):
    np.testing.assert_array_equal(load_photo(write(tmp_path / "a.png", gradient)), gradient)
    np.testing.assert_array_equal(decode_png(encode_png(gradient), "x"), gradient)


@pytest.mark.parametrize("suffix", [".jpg", ".webp"])
def test_lossy_formats_are_read(tmp_path, gradient, suffix):
    image = load_photo(write(tmp_path / f"a{suffix}", gradient))
    assert image.shape == gradient.shape
    assert np.abs(image.astype(int) - gradient).mean() < 4


def test_grey_and_16_bit_become_rgb(tmp_path, gradient):
    grey = load_photo(write(tmp_path / "g.png", gradient[..., 0]))
    np.testing.assert_array_equal(grey, np.repeat(gradient[..., :1], 3, axis=2))
    deep = load_photo(write(tmp_path / "d.png", gradient.astype(np.uint16) * 257))
    assert np.abs(deep.astype(int) - gradient).max() <= 1


def test_transparency_is_laid_over_mid_grey(tmp_path, gradient):
    alpha = np.zeros((60, 90, 1), np.uint8)
    alpha[:, :45] = 255
    image = load_photo(write(tmp_path / "a.png", np.concatenate([gradient, alpha], axis=2)))
    np.testing.assert_array_equal(image[:, :45], gradient[:, :45])
    assert (image[:, 45:] == 128).all()


@pytest.mark.parametrize("size", [(4000, 3000), (1088, 720), (700, 1400), (64, 64), (5000, 700), (17, 90)])
def test_the_working_size_keeps_the_aspect(size):
    width, height = size
    fitted = fit_photo(np.zeros((height, width, 3), np.uint8))
    h, w = fitted.shape[:2]
    assert max(h, w) <= 1088
    assert h % 8 == 0
    assert w % 8 == 0
    assert min(h, w) >= 32
    assert w / h == pytest.approx(width / height, rel=0.15)


@pytest.mark.parametrize(
    ("size", "kept"),
    [((800, 600), None), ((1200, 900), None), ((2000, 1500), (2000, 1500)), ((8000, 6000), (4352, 3264))],
)
def test_what_a_photo_knows_beyond_its_working_size_is_kept(size, kept):
    photo = np.zeros((size[1], size[0], 3), np.uint8)
    finer = finer_photo(photo, fit_photo(photo))
    assert (finer.shape[1::-1] if finer is not None else None) == kept


def bad_files(tmp_path, gradient):
    jpeg = write(tmp_path / "ok.jpg", gradient).read_bytes()
    png = write(tmp_path / "ok.png", gradient).read_bytes()
    return {
        "text.jpg": b"hello, I am a text",
        "empty.jpg": b"",
        "cut.png": png[: len(png) // 2],
        "stub.jpg": jpeg[:40],
        "bomb.png": png[:16] + (60000).to_bytes(4, "big") * 2 + png[24:],
        "zero.png": png[:16] + bytes(8) + png[24:],
        "gif.png": b"GIF89a" + bytes(100),
    }


NAMES = ["text.jpg", "empty.jpg", "cut.png", "stub.jpg", "bomb.png", "zero.png", "gif.png"]


@pytest.mark.parametrize("name", NAMES)
def test_bad_photos_are_refused_in_one_line(tmp_path, gradient, name):
    path = tmp_path / name
    path.write_bytes(bad_files(tmp_path, gradient)[name])
    with pytest.raises(InputError) as caught:
        load_photo(path)
    assert "\n" not in caught.value.line()


def test_directories_and_missing_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="directory"):
        load_photo(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        load_photo(tmp_path / "none.jpg")


@pytest.mark.parametrize("size", [(8, 8), (2000, 20)])
def test_slivers_are_refused(tmp_path, size):
    path = write(tmp_path / "a.png", np.zeros((size[1], size[0], 3), np.uint8))
    with pytest.raises(InputError):
        load_photo(path)


def test_writability_is_known_beforehand(tmp_path):
    check_writable(tmp_path / "a.wz")
    with pytest.raises(OutputError, match="directory"):
        check_writable(tmp_path)
    with pytest.raises(OutputError, match="no such folder"):
        check_writable(tmp_path / "none" / "a.wz")


def test_a_cutout_keeps_its_transparency_and_its_edges_their_colour(tmp_path):
    pixels = np.zeros((80, 120, 4), np.uint8)
    pixels[..., :3] = (0, 0, 255)  # what is transparent is blue
    pixels[20:60, 31:91] = (200, 40, 20, 255)
    whole = load_cutout(write(tmp_path / "c.png", pixels))
    np.testing.assert_array_equal(whole, pixels)
    small = load_cutout(tmp_path / "c.png", 40)
    assert small.shape == (27, 40, 4)
    edge = (small[..., 3] > 20) & (small[..., 3] < 250)
    assert edge.any()
    assert small[edge][:, 2].max() <= 21  # no blue came in: measured 20


def test_a_photo_as_a_cutout_is_opaque(tmp_path, gradient):
    rgba = load_cutout(write(tmp_path / "p.png", gradient))
    np.testing.assert_array_equal(rgba[..., :3], gradient)
    assert (rgba[..., 3] == 255).all()
    deep = np.dstack([gradient, np.full(gradient.shape[:2], 128)]).astype(np.uint16) * 257
    assert load_cutout(write(tmp_path / "d.png", deep))[0, 0, 3] == 128
    with pytest.raises(InputError):
        load_cutout(tmp_path / "missing.png")
