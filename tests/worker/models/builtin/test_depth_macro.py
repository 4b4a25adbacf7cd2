import cv2
import numpy as np

from wzviewer.worker.models.builtin.depth.macro import (
    focus_disparity,
    focus_ratio,
    local_ratio,
    macro_gate,
    thing_in_focus,
)


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
    d = focus_disparity(
        ratio,
        weight,
        local_ratio(image, (180, 120)),
        cv2.resize(image, (180, 120), interpolation=cv2.INTER_AREA),
    )
    inside = cv2.resize(flower.astype(np.uint8), (180, 120), interpolation=cv2.INTER_NEAREST) > 0
    core = cv2.erode(inside.astype(np.uint8), np.ones((9, 9))) > 0
    far = cv2.dilate(inside.astype(np.uint8), np.ones((15, 15))) == 0
    assert d[core].mean() > 1.8 * d[far].mean()  # measured: 3.2


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
    assert np.isfinite(focus_disparity(ratio, weight, local_ratio(flat, (90, 60)), flat[::4, ::4])).all()


def test_a_petal_out_of_focus_stays_with_its_flower():
    image, _ = close_up()
    y, x = np.mgrid[:480, :720]
    petal = (np.abs(y - 240) < 60) & (x > 440) & (x < 560)  # smooth, where the flower is textured
    flower = (np.hypot(x - 360, y - 240) < 130) | petal
    color = np.where(flower[..., None], np.float32([1.0, 0.5, 0.2]), np.float32([0.3, 0.6, 0.3]))
    picture = (image * color).astype(np.uint8)
    picture[petal & (np.hypot(x - 360, y - 240) >= 130)] = (150, 75, 30)
    sky = np.zeros((120, 180), bool)
    ratio, weight = focus_ratio(picture, (180, 120), sky)
    quarter = cv2.resize(picture, (180, 120), interpolation=cv2.INTER_AREA)
    d = focus_disparity(ratio, weight, local_ratio(picture, (180, 120)), quarter)
    whole = cv2.resize(flower.astype(np.uint8), (180, 120), interpolation=cv2.INTER_NEAREST) > 0
    tip = (slice(50, 70), slice(124, 134))
    assert d[tip].min() > 1.12 * np.median(d[~whole])  # measured: 1.17; its own sharpness says 1.0


def test_nothing_sharp_is_no_thing():
    blank = np.zeros((60, 90), np.float32)
    assert not thing_in_focus(blank, blank > 0, blank, np.full((60, 90, 3), 90, np.uint8)).any()
