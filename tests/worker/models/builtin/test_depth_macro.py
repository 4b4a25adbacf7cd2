import cv2
import numpy as np

from wzviewer.worker.models.builtin.depth.macro import focus_disparity, focus_ratio, macro_gate


def close_up(blurred=True):
    rng = np.random.default_rng(0)
    noise = cv2.resize(rng.random((240, 360)).astype(np.float32), (720, 480), interpolation=cv2.INTER_LINEAR)
    texture = np.clip(0.5 + 0.8 * (noise - 0.5), 0, 1)
    y, x = np.mgrid[:480, :720]
    flower = np.hypot(x - 360, y - 240) < 130
    coarse = cv2.resize(rng.random((24, 36)).astype(np.float32), (720, 480), interpolation=cv2.INTER_CUBIC)
    ground = coarse if blurred else texture
    return np.repeat(
        (np.clip(np.where(flower, texture, ground), 0, 1) * 255).astype(np.uint8)[..., None], 3, 2
    ), flower


def test_a_sharp_thing_before_a_blur_opens_the_gate_and_is_near():
    image, flower = close_up()
    sky = np.zeros((120, 180), bool)
    ratio, weight = focus_ratio(image, (180, 120), sky)
    assert macro_gate(ratio, weight, sky) > 0.9  # measured: 1.0
    d = focus_disparity(ratio, weight, cv2.resize(image, (180, 120), interpolation=cv2.INTER_AREA))
    inside = cv2.resize(flower.astype(np.uint8), (180, 120), interpolation=cv2.INTER_NEAREST) > 0
    core = cv2.erode(inside.astype(np.uint8), np.ones((9, 9))) > 0
    far = cv2.dilate(inside.astype(np.uint8), np.ones((15, 15))) == 0
    assert d[core].mean() > 1.8 * d[far].mean()  # measured: 3.3


def test_an_evenly_sharp_picture_keeps_it_shut():
    image, _ = close_up(blurred=False)
    sky = np.zeros((120, 180), bool)
    assert macro_gate(*focus_ratio(image, (180, 120), sky), sky) == 0


def test_sky_explains_the_blur_and_keeps_it_shut():
    image, _ = close_up()
    sky = np.zeros((120, 180), bool)
    sky[:20] = True
    assert macro_gate(*focus_ratio(image, (180, 120), sky), sky) == 0


def test_a_flat_picture_is_no_macro():
    flat = np.full((240, 360, 3), 90, np.uint8)
    sky = np.zeros((60, 90), bool)
    ratio, weight = focus_ratio(flat, (90, 60), sky)
    assert macro_gate(ratio, weight, sky) == 0
    assert np.isfinite(focus_disparity(ratio, weight, flat[::4, ::4])).all()
