"""Image files as objects."""

import cv2
import numpy as np
import pytest

from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects import cutout
from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Support

W, H = 160, 106


def disc(shape=(80, 60), radii=(22, 34)):
    mask = np.zeros(shape, np.uint8)
    cv2.ellipse(mask, (shape[1] // 2, shape[0] // 2), radii, 0, 0, 360, 255, -1)
    return mask


def written(tmp_path, image):
    path = tmp_path / "thing.png"
    assert cv2.imwrite(str(path), image)
    return str(path)


def test_alpha_is_respected_and_relief_touches_and_rises(tmp_path):
    mask = disc()
    bgra = np.dstack([np.full_like(mask, 30), np.full_like(mask, 200), np.full_like(mask, 40), mask])
    editor = ObjectEditor()
    image = np.full((H, W, 3), 0.5, np.float32)
    v, u = np.mgrid[:H, :W].astype(np.float32)
    support = Support((0.1 * u - 0.5 * v).astype(np.float32), 1200.0)
    result = editor.apply(editor.parse(written(tmp_path, bgra)), image, support, 0)
    # The ellipse is pi/4 of its box, .4 W high.
    height = 0.4 * W
    assert result.object_mask.sum() == pytest.approx(np.pi / 4 * height * height * 44 / 68, rel=0.08)
    assert (result.image[result.object_mask][:, 1] > result.image[result.object_mask][:, 0]).mean() > 0.95
    gap = (support.relief - result.object_relief)[result.object_mask]
    assert 0 < gap.min() < 2.0
    y, x = (int(v.mean()) for v in np.nonzero(result.object_mask))
    assert result.object_relief[y, x] < np.nanmax(result.object_relief) - 1
    untouched = (result.alpha == 0) & (result.shadow == 1)
    assert untouched.mean() > 0.3
    assert np.array_equal(result.image[untouched], image[untouched])


def test_plain_border_is_cut_away(tmp_path):
    rgb = np.full((80, 60, 3), 245, np.uint8)
    rgb[disc() > 0] = (40, 60, 180)
    rgba = cutout.load_cutout(written(tmp_path, rgb))
    assert rgba.shape[0] == pytest.approx(69, abs=4)
    assert rgba[0, 0, 3] < 0.2
    assert rgba[..., 3].mean() == pytest.approx(np.pi / 4, abs=0.06)


def test_a_picture_with_a_busy_border_is_used_whole(tmp_path):
    noise = np.random.default_rng(0).integers(0, 255, (50, 70, 3)).astype(np.uint8)
    rgba = cutout.load_cutout(written(tmp_path, noise))
    assert rgba.shape == (50, 70, 4)
    assert rgba[..., 3].min() == 1


@pytest.mark.parametrize("content", [b"", b"not an image"])
def test_unreadable_files_are_refused(tmp_path, content):
    path = tmp_path / "bad.png"
    path.write_bytes(content)
    with pytest.raises(PromptError):
        cutout.load_cutout(str(path))


def test_transparent_files_are_refused(tmp_path):
    with pytest.raises(PromptError):
        cutout.load_cutout(written(tmp_path, np.zeros((20, 20, 4), np.uint8)))


def test_a_picture_in_memory_is_put_in_as_a_file_is(tmp_path):
    mask = disc()
    bgra = np.dstack([np.full_like(mask, 30), np.full_like(mask, 200), np.full_like(mask, 40), mask])
    editor, image = ObjectEditor(), np.full((H, W, 3), 0.5, np.float32)
    support = Support(np.zeros((H, W), np.float32), 1200.0)
    named = editor.apply(editor.parse(written(tmp_path, bgra)), image, support, 3)
    given = editor.apply(editor.insertion(bgra[..., [2, 1, 0, 3]], "disc"), image, support, 3)
    np.testing.assert_array_equal(given.image, named.image)
    np.testing.assert_array_equal(given.object_relief, named.object_relief)


@pytest.mark.parametrize(
    "pixels",
    [
        np.zeros((20, 20, 4), np.uint8),
        np.zeros((20, 20, 3), np.uint8),
        np.zeros((20, 20), np.uint8),
        np.ones((0, 20, 4), np.uint8),
        np.full((20, 20, 4), 1.0, np.float32),
        np.full((1, 4000, 4), 255, np.uint8),
    ],
)
def test_malformed_pictures_in_memory_are_refused(pixels):
    with pytest.raises(PromptError):
        ObjectEditor.insertion(pixels, "thing")
