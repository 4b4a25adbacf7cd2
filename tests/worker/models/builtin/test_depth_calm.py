import cv2
import numpy as np
import pytest

from wzviewer.worker.models.builtin.depth.calm import cut_off, fine_detail


def scene(soft_px=0.0):
    """A bright disc that stands on the ground before the sky; its edge crisp or as soft as a cloud's."""
    y, x = np.mgrid[:720, :1088]
    disc = (np.hypot(x - 500, y - 330) < 110).astype(np.float32)
    light = 170 + 60 * (cv2.GaussianBlur(disc, (0, 0), soft_px) if soft_px else disc)
    light += np.random.default_rng(0).normal(0, 0.7, light.shape)
    image = np.repeat(light[..., None], 3, 2).clip(0, 255).astype(np.uint8)
    small = cv2.resize(disc, (544, 360)) > 0.5
    sky = np.zeros((360, 544), bool)
    sky[:210] = True
    return image, sky, small & sky


@pytest.mark.parametrize(
    ("soft_px", "belief", "withdrawn"), [(0, 0.5, True), (0, 0.95, False), (14, 0.5, False)]
)
def test_only_what_is_doubted_and_crisply_closed_is_cut_off(soft_px, belief, withdrawn):
    image, sky, disc = scene(soft_px)
    doubt = np.where(disc, belief, 0.97).astype(np.float32)
    away = cut_off(sky, fine_detail(image, (544, 360)), doubt)
    # measured: 1.0 of the disc where it goes, else 0; nothing of the rest
    assert away[disc].mean() > 0.95 if withdrawn else not away.any()
    assert (away & ~disc).sum() < 0.03 * sky.sum()


def test_birds_and_no_sky_are_left_alone():
    image, sky, _ = scene(14)
    image[80:110, 300:340:4] = 20
    detail = fine_detail(image, (544, 360))
    assert not cut_off(sky, detail, np.full(sky.shape, 0.5, np.float32)).any()
    assert not cut_off(np.zeros_like(sky), detail, detail).any()


def test_detail_finer_than_a_cloud_is_told_from_a_cloud():
    crisp, soft = (fine_detail(scene(s)[0], (544, 360)) for s in (0, 14))
    assert crisp.max() > 8 * soft.max()  # measured: 22 times


def test_a_window_is_not_the_sky():
    image, sky, _ = scene(14)
    window = np.zeros_like(sky)
    window[100:150, 300:380] = True
    detail = fine_detail(image, (544, 360))
    assert np.array_equal(cut_off(window, detail, window * np.float32(0.9)), window)
