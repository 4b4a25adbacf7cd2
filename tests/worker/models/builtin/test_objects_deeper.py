"""A deeper level shrunk is its parent; what stands in front hides an object at every level."""

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Support

W, H, FACTOR = 160, 106, 4.0
EDITOR = ObjectEditor()


def picture():
    noise = cv2.GaussianBlur(np.random.default_rng(0).random((H, W, 3), np.float32), (0, 0), 3)
    return np.clip(0.45 + 2.0 * (noise - 0.5), 0, 1).astype(np.float32)


def floor():
    v = np.mgrid[:H, :W][0].astype(np.float32)
    return (-0.9 * (v - H / 2)).astype(np.float32)


def similarity(a, b):
    """SSIM (Wang 2004) of two pictures' brightness, Gaussian windows of 1.5 px."""
    x, y = (cv2.cvtColor(v.astype(np.float32), cv2.COLOR_RGB2GRAY) for v in (a, b))

    def mean(v):
        return cv2.GaussianBlur(v, (11, 11), 1.5)

    mx, my = mean(x), mean(y)
    vx, vy, vxy = mean(x * x) - mx * mx, mean(y * y) - my * my, mean(x * y) - mx * my
    return ((2 * mx * my + 1e-4) * (2 * vxy + 9e-4) / ((mx**2 + my**2 + 1e-4) * (vx + vy + 9e-4))).mean()


def corner(result):
    """The upper left corner of the part that is looked at: the middle of the object."""
    y, x = np.nonzero(result.object_mask)
    return (
        int(np.clip(np.median(x) - W / FACTOR / 2, 0, W - W / FACTOR)),
        int(np.clip(np.median(y) - H / FACTOR / 2, 0, H - H / FACTOR)),
    )


def deeper(result, relief, at=None):
    """Zooms into the middle of the object: (the parent's part, the finer level)."""
    w, h = int(W / FACTOR), int(H / FACTOR)
    x0, y0 = at or corner(result)
    crop = result.image[y0 : y0 + h, x0 : x0 + w]
    base = np.clip(cv2.resize(crop, (W, H), interpolation=cv2.INTER_CUBIC), 0, 1)
    seen = np.where(result.object_mask, result.object_relief, relief)[y0 : y0 + h, x0 : x0 + w]
    seen = cv2.resize(seen, (W, H), interpolation=cv2.INTER_NEAREST) * np.float32(FACTOR)
    support = Support((seen - np.median(seen)).astype(np.float32), 1200.0 * FACTOR)
    return crop, EDITOR.continue_into(
        result.placements, (x0, y0, FACTOR), base, support, 3, parent_factor=FACTOR
    )


@pytest.mark.parametrize("name", ["bird", "fish", "lizard", "coin", "crystal", "feather", "cat at night"])
def test_shrunk_it_equals_its_parent(name):
    support = Support(floor(), 1200.0)
    result = EDITOR.apply(EDITOR.parse(f"a big {name}"), picture(), support, 1)
    crop, finer = deeper(result, floor())
    assert finer is not None
    shrunk = cv2.resize(finer.image, crop.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert similarity(shrunk, crop) >= 0.9  # measured .945 (lizard) to .9997 (crystal)


def post():
    """A floor with a post near the camera in front of its right half."""
    relief = floor()
    relief[:, 92:104] -= 200
    return relief


def test_what_stands_in_front_hides_the_object():
    free = EDITOR.apply(EDITOR.parse("a lizard"), picture(), Support(floor(), 1200.0), 1)
    result = EDITOR.apply(EDITOR.parse("a lizard"), picture(), Support(post(), 1200.0), 1)
    assert free.object_mask[:, 94:102].any()
    assert not result.object_mask[:, 94:102].any()
    # Within two pixels of its sides the picture is mixed, as at every outline.
    assert np.abs(result.image[:, 96:100] - picture()[:, 96:100]).max() < 0.05  # measured .035
    beside = np.r_[0:88, 108:W]
    assert result.object_mask[:, beside].sum() > 0.8 * free.object_mask[:, beside].sum()
    near = (post() - result.object_relief)[result.object_mask]
    assert near.min() > 0
    assert near.max() < 100  # it stays on the floor and does not jump in front of the post


def test_and_hides_it_at_the_deeper_level_too():
    result = EDITOR.apply(EDITOR.parse("a huge lizard"), picture(), Support(post(), 1200.0), 1)
    x0, y0 = 80, corner(result)[1]
    _, finer = deeper(result, post(), (x0, y0))
    columns = slice(max(int((94 - x0) * FACTOR), 0), max(int((102 - x0) * FACTOR), 0))
    assert finer is not None
    assert finer.object_mask.any()
    assert not finer.object_mask[:, columns].any()
