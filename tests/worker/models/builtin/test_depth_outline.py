import cv2
import numpy as np

from wzviewer.worker.models.builtin.depth.outline import regrow, spread, unlike_sky, with_clouds


def spiky(h=360, w=540, ground=(60, 90, 40), spike=(200, 170, 40)):
    rng = np.random.default_rng(0)
    cloud = cv2.resize(rng.random((6, 9)).astype(np.float32), (w, h), interpolation=cv2.INTER_CUBIC)
    sky = np.float32([150, 175, 215]) + 40 * (cloud[..., None] - 0.5)
    image = sky + rng.normal(0, 2, (h, w, 3)).astype(np.float32)
    land = np.zeros((h, w), np.uint8)
    land[int(0.7 * h) :] = 1
    body = land.copy()
    for x in range(40, w - 40, 60):
        tip = np.array([[x - 5, 0.7 * h], [x + 5, 0.7 * h], [x + 12, 0.7 * h - 26]])
        cv2.fillPoly(land, [np.round(tip).astype(np.int32)], 1)
    image[land > 0] = np.float32(spike)
    image[body > 0] = np.float32(ground)
    return np.clip(image, 0, 255).astype(np.uint8), land == 0, body == 0


def test_petals_that_the_mask_lost_return_to_the_ground_and_clouds_stay():
    image, truth, blunt = spiky()
    lost = blunt & ~truth
    fixed = regrow(blunt, image)
    assert lost.sum() > 900
    assert (fixed & lost).sum() < 0.06 * lost.sum()  # measured: 0; all of it before
    assert (fixed | ~truth).mean() > 0.9995  # sky kept, measured: 1.0


def test_a_skirt_of_sky_goes_back_to_it():
    image, truth, _ = spiky()
    fat = cv2.erode(truth.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    skirt = truth & ~fat
    assert (regrow(fat, image) & skirt).sum() > 0.9 * skirt.sum()  # measured: 1; none before


def test_a_broad_dark_cloud_on_the_horizon_stays_sky():
    image, truth, blunt = spiky()
    y, x = np.mgrid[: truth.shape[0], : truth.shape[1]]
    cloud = np.clip(1.5 - np.hypot((x - 270) / 90, (y - 240) / 45), 0, 1)[..., None]
    stormy = np.where(blunt[..., None], image * (1 - 0.4 * cloud), image).astype(np.uint8)
    fixed = regrow(truth, stormy)
    assert (truth & ~fixed).sum() < 0.004 * truth.sum()  # measured: 0


def test_masks_of_one_kind_pass_through():
    image = np.full((60, 90, 3), 120, np.uint8)
    for mask in (np.zeros((60, 90), bool), np.ones((60, 90), bool)):
        assert np.array_equal(regrow(mask, image), mask)


def test_the_sky_is_like_itself_and_a_thing_is_not():
    image, truth, blunt = spiky()
    lab = cv2.cvtColor(image, cv2.COLOR_RGB2LAB).astype(np.float32)
    distance = unlike_sky(lab, truth, 0.5)
    assert np.percentile(distance[truth], 99) < 3.2  # measured: 0.95
    assert np.percentile(distance[blunt & ~truth], 5) > 6  # measured: 17


def test_the_sky_spreads_over_its_own_color_but_not_where_the_network_denies_it():
    image, truth, _ = spiky()
    short = truth.copy()
    short[200:] = False
    missing = truth & ~short
    for belief, share in ((0.4, 0.85), (0.1, 0.0)):
        found = spread(short, image, np.full(truth.shape, belief, np.float32))
        assert (found & missing).sum() >= share * missing.sum()  # measured: 0.91 and 0
        assert (found & ~truth).sum() <= 0.02 * missing.sum()  # measured: 0
        assert belief > 0.2 or np.array_equal(found, short)


def test_the_blurred_edge_of_a_thing_stays_with_it():
    image, truth, _ = spiky()
    blurred = cv2.GaussianBlur(image, (0, 0), 1.0)
    rim = truth & (cv2.dilate((~truth).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    fixed = regrow(truth, blurred)
    assert (fixed & rim).sum() < 0.2 * rim.sum()  # measured: 0.08; 1.0 before
    assert (truth & ~fixed & ~rim).sum() < 0.2 * rim.sum()  # measured: 0


def clouded(wall: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A blue sky with white clouds, one of them low beside the ground; the mask has lost that one."""
    image, truth, _ = spiky()
    y, x = np.mgrid[: truth.shape[0], : truth.shape[1]]
    high = (np.hypot((x - 130) / 80, (y - 60) / 30) < 1) & truth
    low = (np.hypot((x - 400) / 60, (y - 244) / 11) < 1) & truth
    image[high | low] = 246
    if wall:
        image[300:340, 100:400] = 246
    return image, truth & ~low, low


def test_a_white_cloud_beside_a_flower_is_sky_like_other_clouds():
    image, mask, lost = clouded(wall=False)
    found = with_clouds(mask, image)
    assert (found & lost).sum() > 0.97 * lost.sum()  # measured: 1; none before
    assert np.array_equal(found & ~lost, mask)


def test_what_is_white_as_a_cloud_stays_ground_where_the_ground_is_white_too():
    image, mask, _ = clouded(wall=True)
    assert np.array_equal(with_clouds(mask, image), mask)
