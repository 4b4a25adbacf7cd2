import cv2
import numpy as np

from wzviewer.worker.models.builtin.depth.sky import colored_like_sky, contour, fuse_sky, tidy


def landscape(h=180, w=272, ridge=80):
    rng = np.random.default_rng(0)
    image = np.empty((h, w, 3), np.float32)
    image[:] = np.linspace(0.95, 1.05, h)[:, None, None] * np.float32([0.45, 0.62, 0.9])
    x = np.arange(w)
    sky = np.arange(h)[:, None] < (ridge + 12 * np.sin(x / 20))[None]
    ground = np.float32([0.25, 0.35, 0.15]) + rng.normal(0, 0.06, (h, w, 1)).astype(np.float32)
    image = np.where(sky[..., None], image, ground)
    return np.clip(image, 0, 1).astype(np.float32), sky


def test_a_vague_opinion_becomes_the_exact_outline():
    image, sky = landscape()
    rough = cv2.GaussianBlur(np.where(sky, 5.0, -5.0).astype(np.float32), (0, 0), 9)
    soft = fuse_sky(rough, image)
    full = cv2.resize((image * 255).astype(np.uint8), (1088, 720), interpolation=cv2.INTER_CUBIC)
    half = cv2.resize(full, (544, 360), interpolation=cv2.INTER_AREA)
    found = contour(soft, half, full).mask
    truth = cv2.resize(sky.astype(np.uint8), (1088, 720), interpolation=cv2.INTER_NEAREST) > 0
    assert (found != truth).mean() < 0.01  # measured: 0.003; the blurred opinion alone is 0.02 off


def test_color_alone_never_makes_sky():
    image, _ = landscape()
    assert colored_like_sky(cv2.cvtColor(image, cv2.COLOR_RGB2LAB)).mean() > 0.3
    assert fuse_sky(np.full(image.shape[:2], -5.0, np.float32), image).max() < 0.5


def test_a_petal_of_the_color_of_a_cloud_is_not_sky():
    image, sky = landscape(360, 544, 160)
    y, x = np.mgrid[:360, :544]
    petal = np.hypot((x - 260) / 1.3, y - 150) < 46
    cloud = np.clip(1.6 - np.hypot((x - 110) / 60, (y - 60) / 25), 0, 1)[..., None]
    image = np.where(petal[..., None], np.float32(0.93), image * (1 - cloud) + 0.93 * cloud).astype(
        np.float32
    )
    belief = np.where(petal, 0.6, np.where(sky, 0.95, 0.02)).astype(np.float32)
    belief = cv2.GaussianBlur(belief, (0, 0), 4)
    half = (image * 255).astype(np.uint8)
    full = cv2.resize(half, (1088, 720), interpolation=cv2.INTER_CUBIC)
    found = cv2.resize(contour(belief, half, full).mask.astype(np.uint8), (544, 360)) > 0
    assert found[petal].mean() < 0.1  # measured: 0; 1.0 without the edges
    assert found[sky & ~petal].mean() > 0.97  # the cloud too; measured: 0.999


def test_green_and_textured_things_are_not_colored_like_sky():
    rng = np.random.default_rng(1)
    grass = (np.float32([0.3, 0.6, 0.2]) + rng.normal(0, 0.1, (90, 120, 1))).astype(np.float32)
    assert colored_like_sky(cv2.cvtColor(np.clip(grass, 0, 1), cv2.COLOR_RGB2LAB)).mean() == 0


def test_specks_go_and_small_islands_belong_to_the_sky():
    p = np.zeros((100, 150), np.float32)
    p[:50] = 1
    p[20:22, 30:32] = 0  # a bird
    p[80:82, 60:62] = 1  # a window
    clean = tidy(p)
    assert clean[:50].min() == 1
    assert clean[50:].max() == 0


def test_no_sky_at_all_is_an_empty_mask():
    grey = np.full((72, 108, 3), 128, np.uint8)
    found = contour(np.zeros((18, 27), np.float32), grey, grey)
    assert not found.mask.any()
    assert found.mask.shape == (72, 108)
