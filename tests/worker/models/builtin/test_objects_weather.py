"""Changes of the whole picture: bounded, repeatable, and where they belong."""

import json

import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.objects.editor import ObjectEditor, Placement, Support
from wzviewer.worker.models.builtin.objects.grammar import Change
from wzviewer.worker.models.builtin.objects.weather import changed
from wzviewer.worker.models.builtin.objects.words import CHANGES

W, H = 160, 106
EVERY = sorted(set(CHANGES.values()))


def picture():
    rng = np.random.default_rng(0)
    noise = cv2.GaussianBlur(rng.random((H, W, 3), np.float32), (0, 0), 2)
    return np.clip(0.42 + 2.0 * (noise - 0.5), 0, 1).astype(np.float32)


def steps():
    """A wall above a floor: the lower half recedes upwards, the upper half stands."""
    v = np.mgrid[:H, :W][0].astype(np.float32)
    return np.maximum(H / 2 - v, -2.0 * (v - H / 2)).astype(np.float32) * np.where(v < H / 2, 0.02, 1.0)


def after(name, amount=0.75, seed=3, relief=None):
    return changed(picture(), steps() if relief is None else relief, (Change(name, amount),), seed)


@pytest.mark.parametrize("name", EVERY)
def test_changes_something_within_range_and_repeats(name):
    first = after(name)
    assert first.dtype == np.float32
    assert np.isfinite(first).all()
    assert first.min() >= 0
    assert first.max() <= 1
    assert np.abs(first - picture()).mean() > 0.01  # measured .012 (dew) to .4 (night)
    assert first.tobytes() == after(name).tobytes()


@pytest.mark.parametrize("name", EVERY)
def test_unknown_relief_is_no_obstacle(name):
    assert np.isfinite(after(name, relief=np.full((H, W), np.nan, np.float32))).all()


@pytest.mark.parametrize("name", sorted(set(EVERY) - {"dew"}))
def test_more_of_it_changes_more(name):
    little, much = (np.abs(after(name, a) - picture()).mean() for a in (0.3, 1.0))
    assert much > 1.2 * little


@pytest.mark.parametrize("name", ["moss", "rust", "dust", "snow", "frost"])
def test_at_the_border_it_is_the_parents_picture(name):
    moved = np.abs(after(name) - picture()).max(-1)
    rim = np.ones((H, W), bool)
    rim[8:-8, 8:-8] = False  # where the level itself fades out: 0.08 of the shorter side
    assert moved[rim].max() < 1e-6
    assert moved[~rim].max() > 0.1


def test_snow_lies_on_what_faces_the_sky():
    white = after("snow").min(-1)
    assert white[H // 2 + 6 :].mean() > white[: H // 2 - 6].mean() + 0.1  # measured .27


def test_fog_thickens_with_depth():
    v = np.mgrid[:H, :W][0].astype(np.float32)
    foggy = after("fog", relief=((H - v) * 5).astype(np.float32))
    inside = [(slice(top, top + 20), slice(24, W - 24)) for top in (20, H - 40)]
    far, near = (foggy[at].std() / picture()[at].std() for at in inside)
    assert far < 0.7 * near  # measured 0.42 and 0.71


def test_night_is_dark_and_blue_and_moss_is_green():
    inside = (slice(26, H - 26), slice(26, W - 26))
    night, moss = after("night")[inside], after("moss", 1.0)[inside]
    assert night.mean() < 0.6 * picture()[inside].mean()  # measured 0.57
    assert night[..., 2].mean() > 1.1 * night[..., 0].mean()
    assert moss[..., 1].mean() > 1.2 * moss[..., 2].mean()


def test_an_object_and_a_change_in_one_prompt():
    editor = ObjectEditor()
    support = Support(np.zeros((H, W), np.float32), 1200.0)
    day = editor.apply(editor.parse("a ladybug"), picture(), support, 1)
    night = editor.apply(editor.parse("a ladybug at night"), picture(), support, 1)
    assert np.array_equal(day.object_mask, night.object_mask)
    assert night.image[night.object_mask].mean() < 0.7 * day.image[day.object_mask].mean()


def test_dew_is_drawn_again_sharper_and_shrunk_it_is_the_same():
    editor = ObjectEditor()
    wet = editor.apply(editor.parse("wet with dew"), picture(), Support(steps(), 1200.0), 3)
    (dew,) = (Placement.from_dict(json.loads(json.dumps(p.to_dict()))) for p in wet.placements)
    x, y, radius = max(dew.drops, key=lambda drop: drop[2] * (40 < drop[0] < 120 and 30 < drop[1] < 76))[:3]
    x0, y0, w, h = int(x - 20), int(y - 13), W // 4, H // 4
    crop = wet.image[y0 : y0 + h, x0 : x0 + w]
    base = np.clip(cv2.resize(crop, (4 * w, 4 * h), interpolation=cv2.INTER_CUBIC), 0, 1)
    support = Support(np.zeros(base.shape[:2], np.float32), 4800.0)
    again = editor.continue_into((dew,), (x0, y0, 4.0), base, support, 3, parent_factor=4.0)
    assert again is not None
    assert not again.object_mask.any()

    def steepest(image):
        rows, columns = np.mgrid[: 4 * h, : 4 * w]
        rim = np.abs(np.hypot(columns / 4 - x + x0, rows / 4 - y + y0) - radius) < 2
        return np.percentile(np.abs(np.diff(image.mean(-1), axis=1))[rim[:, 1:]], 95)

    assert steepest(again.image) > 2 * steepest(base)  # measured 3.5 times
    shrunk = cv2.resize(again.image, (w, h), interpolation=cv2.INTER_AREA)
    assert -10 * np.log10(np.mean((shrunk - crop) ** 2)) > 34  # measured 35.7; of a photograph 40 to 44
    far = editor.continue_into((dew,), (-400.0, -400.0, 4.0), base, support, 3, parent_factor=4.0)
    assert far is None
