"""What a camera does to a traced scene: air, defocus, exposure, colour, noise, compression."""

from itertools import pairwise

import cv2
import numpy as np
from depth_scenes import FloatArray, Scene, fractal
from numpy.typing import NDArray


def _lens_blur(image: FloatArray, disparity: FloatArray, scene: Scene) -> FloatArray:
    focus = scene.focus if scene.focus > 0 else float(np.percentile(disparity, scene.uniform(75, 97)))
    blur = np.abs(disparity / (disparity.max() + 1e-6) - focus / (disparity.max() + 1e-6)) * scene.defocus * 9
    blur = cv2.GaussianBlur(np.clip(blur - 0.25, 0, None), (0, 0), 1.2)
    result, levels = image.copy(), [0.0, 0.8, 1.8, 3.5, 6.0]
    for low, high in pairwise(levels):
        share = np.clip((blur - low) / (high - low), 0, 1)[..., None]
        result = result * (1 - share) + cv2.GaussianBlur(image, (0, 0), high) * share
    return result


def photograph(image: FloatArray, disparity: FloatArray, scene: Scene) -> FloatArray:
    """Air, lens, exposure, colour, noise."""
    random, (h, w) = scene.random, disparity.shape
    image = image * (1 + 0.1 * (fractal(random, h, w, 6)[..., None] - 0.5))
    if scene.haze > 0:
        air = np.clip(random.normal([0.75, 0.8, 0.85], 0.06), 0, 1)
        share = np.exp(-1 / np.maximum(disparity, 1e-5) / scene.haze)[..., None]
        image = np.where(disparity[..., None] > 0, image * share + air * (1 - share), image).astype(
            np.float32
        )
    if scene.defocus > 0:
        image = _lens_blur(image, disparity, scene)
    # burnt-out walls and ceilings must not be mistaken for sky
    burnt = scene.uniform(45, 90) if not scene.sky and scene.maybe(0.35) else scene.uniform(80, 99.5)
    image = image / max(float(np.percentile(image, burnt)), 0.05) * scene.uniform(0.75, 1.1)
    image = np.clip(image, 0, 1) ** scene.uniform(0.55, 1.1)
    image = image * np.exp(random.normal(0, 0.05, 3)).astype(np.float32)
    if scene.maybe(0.4):
        y, x = np.mgrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j]
        image = image * (1 - scene.uniform(0, 0.4) * (x * x + y * y)[..., None] / 2)
    grey = image.mean(2, keepdims=True)
    image = grey + (image - grey) * scene.uniform(0.6, 1.7)
    image = (image - image.mean()) * scene.uniform(0.8, 1.3) + image.mean()
    if scene.maybe(0.08):
        image = cv2.medianBlur((np.clip(image, 0, 1) * 255).astype(np.uint8), 5).astype(np.float32) / 255
    return np.clip(image, 0, 1).astype(np.float32)


def digitise(image: FloatArray, scene: Scene) -> NDArray[np.uint8]:
    """Sensor noise, 8 bits, often JPEG."""
    if scene.maybe(0.5):
        image = image + scene.random.normal(0, scene.uniform(0.005, 0.04), image.shape).astype(np.float32)
    pixels = (np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8)
    if scene.maybe(0.4):
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(scene.uniform(40, 95))]
        return np.asarray(cv2.imdecode(cv2.imencode(".jpg", pixels, quality)[1], cv2.IMREAD_COLOR), np.uint8)
    return pixels
