"""The mix of training scenes; `sample` is the public face."""

from collections.abc import Callable

import cv2
import numpy as np
from depth_camera import digitise, photograph
from depth_kinds import (
    beach_scene,
    city_scene,
    field_scene,
    forest_scene,
    macro_scene,
    mountain_scene,
    objects_scene,
    room_scene,
    street_scene,
    table_scene,
)
from depth_places import bouquet_scene, garden_scene, hall_scene, village_scene
from depth_scenes import BoolArray, FloatArray, Scene, trace
from numpy.typing import NDArray

KINDS: list[tuple[Callable[[Scene], None], float]] = [
    (field_scene, 1.3), (street_scene, 1.1), (room_scene, 1.6), (macro_scene, 0.8), (forest_scene, 0.8),
    (mountain_scene, 1.1), (table_scene, 0.8), (beach_scene, 0.6), (objects_scene, 1.1), (city_scene, 0.6),
    (village_scene, 2.0), (hall_scene, 1.5), (bouquet_scene, 1.5), (garden_scene, 1.3),
]  # fmt: skip


Sample = tuple[NDArray[np.uint8], FloatArray, BoolArray, BoolArray]


def sample(seed: int, width: int, height: int) -> Sample | None:
    """One training picture.

    Args:
        seed: everything follows from it.
        width: of the picture, px; it is traced at one and a quarter times that.
        height: likewise.

    Returns:
        Colour (h, w, 3) u8, disparity (h/2, w/2) f32 relative to its 95th percentile, the sky
        mask and the mask of what stands (h/2, w/2); None where chance made something without depth.
    """
    random = np.random.default_rng(seed)
    w, h = width * 5 // 4, height * 5 // 4
    half_view = np.radians(random.uniform(17, 42))
    scene = Scene(random, w, h, focal=max(w, h) / 2 / np.tan(half_view))
    weights = np.array([weight for _, weight in KINDS])
    KINDS[random.choice(len(KINDS), p=weights / weights.sum())][0](scene)
    color, disparity, sky, upright = trace(scene)
    color = cv2.resize(photograph(color, disparity, scene), (width, height), interpolation=cv2.INTER_AREA)
    size = (width // 2, height // 2)
    disparity = cv2.resize(disparity, size, interpolation=cv2.INTER_NEAREST)
    sky, upright = (
        cv2.resize(m.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0 for m in (sky, upright)
    )
    if sky.mean() > 0.85:
        return None
    disparity = np.clip(disparity / max(float(np.percentile(disparity[~sky], 95)), 1e-6), 0, 2.5)
    if disparity[~sky].std() < 0.03:
        return None
    return digitise(color, scene), disparity.astype(np.float32), sky, upright
