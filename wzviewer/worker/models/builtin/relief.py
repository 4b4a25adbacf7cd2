"""New relief of a zoomed level, read from its shading.

    height = brightness within each segment ("dark is deep") + bulge of each segment + texture's own height
           -> high-passed at W/8 (below that the parent's geometry rules) -> gated by texture activity
           -> p5..p95 scaled to a few per cent of the width -> slopes limited -> faded to 0 at the border

A hint, not photometry: linear shape from shading makes streaks along the light.
"""

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray, IntArray

BORDER_SHARE = 0.12  # of the width, along which relief fades in
STEEPEST = 1.2  # px of height per px
BULGE_PX = 48.0  # largest radius of a bulge at 1088 px of width
ROUGH_SHARE, SMOOTH_SHARE = 0.05, 0.025  # p5..p95 of the height, as a share of the width


def relief_from_shading(
    image: FloatArray,
    segments: IntArray,
    texture: FloatArray | None = None,
    sky: BoolArray | None = None,
    amplitude_share: float | None = None,
) -> FloatArray:
    """Height above the parent's surface.

    Args:
        image: (h, w, 3) sRGB 0..1.
        segments: (h, w) labels.
        texture: (h, w) signed height of the synthesised texture in any unit, or None.
        sky: (h, w) where there is no surface, or None.
        amplitude_share: p5..p95 of the height over the width on fully active ground; None: 5 % on
            rough material down to 2.5 % on smooth boards.

    Returns:
        (h, w) f32 native px, + = nearer; 0 on sky, blur and flat colour, and at the border.
    """
    h, w = image.shape[:2]
    luma = (image @ np.array([76.2, 149.7, 29.1], np.float32)).astype(np.float32)
    active, roughness = activity(luma)
    if sky is not None:
        active = active * cv2.GaussianBlur((~sky).astype(np.float32), (0, 0), 3) * ~sky
    height = 0.5 * _unit(_shading(luma, segments)) + 0.4 * _unit(_bulge(segments))
    if texture is not None:
        height = height + 0.15 * _unit(cv2.GaussianBlur(texture, (0, 0), 1.5) - low_pass(texture, 24.0))
    height = height - low_pass(height, w / 8)
    if amplitude_share is None:
        amplitude_share = SMOOTH_SHARE + (ROUGH_SHARE - SMOOTH_SHARE) * roughness
    height = _scaled(height, active, amplitude_share * w) * active
    height = limit_slope(height)
    height = height - low_pass(height, w / 8) * active
    return (height * border_ramp(h, w)).astype(np.float32)


def activity(luma: FloatArray) -> tuple[FloatArray, float]:
    """Where there is texture in focus.

    Args:
        luma: (h, w) 0..255.

    Returns:
        (h, w) 0..1, and the roughness 0..1 of the active part.
    """
    fine = luma - cv2.GaussianBlur(luma, (0, 0), 2)
    coarse = luma - low_pass(luma, 6)
    small = (max(luma.shape[1] // 4, 1), max(luma.shape[0] // 4, 1))
    energies = []
    for band in (fine, coarse):
        power = cv2.resize(band * band, small, interpolation=cv2.INTER_AREA)
        energies.append(np.sqrt(np.maximum(cv2.GaussianBlur(power, (0, 0), 4), 0)))
    contrast = np.clip((energies[1] - 1.5) / 5, 0, 1)
    focus = np.clip((energies[0] / (energies[1] + 0.3) - 0.10) / 0.15, 0, 1)
    active = (contrast * focus).astype(np.float32)
    mass = float(active.sum())
    mean = float((energies[1] * active).sum()) / mass if mass > 0 else 0.0
    full = cv2.resize(active, luma.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return full, float(np.clip((mean - 5) / 10, 0, 1))


def low_pass(v: FloatArray, sigma: float) -> FloatArray:
    """Gaussian blur of (h, w); wide ones on a reduced picture."""
    shrink = max(int(sigma / 4), 1)
    if shrink == 1:
        return cv2.GaussianBlur(v, (0, 0), sigma)
    h, w = v.shape
    size = (max(round(w / shrink), 1), max(round(h / shrink), 1))
    small = cv2.resize(v, size, interpolation=cv2.INTER_AREA)
    return cv2.resize(
        cv2.GaussianBlur(small, (0, 0), sigma * size[0] / w), (w, h), interpolation=cv2.INTER_CUBIC
    )


def border_ramp(h: int, w: int) -> FloatArray:
    """(h, w) 0 at the border, 1 beyond `BORDER_SHARE` of the width (a smooth step)."""
    reach = BORDER_SHARE * min(w, 2 * h)
    y = np.minimum(np.arange(h), np.arange(h)[::-1])
    x = np.minimum(np.arange(w), np.arange(w)[::-1])
    t = np.clip(np.minimum(y[:, None], x[None]) / max(reach, 1.0), 0, 1)
    return (t * t * (3 - 2 * t)).astype(np.float32)


def limit_slope(height: FloatArray) -> FloatArray:
    """Blurs where the surface is steeper than `STEEPEST`."""
    for sigma in (1.5, 3.0, 6.0):
        gx, gy = (
            cv2.Sobel(height, cv2.CV_32F, 1, 0, scale=0.125),
            cv2.Sobel(height, cv2.CV_32F, 0, 1, scale=0.125),
        )
        steep = (np.hypot(gx, gy) > STEEPEST).astype(np.float32)
        if not steep.any():
            return height
        share = np.clip(
            cv2.GaussianBlur(cv2.dilate(steep, np.ones((3, 3), np.uint8)), (0, 0), sigma) * 2, 0, 1
        )
        height = height + share * (cv2.GaussianBlur(height, (0, 0), sigma) - height)
    return height


def _shading(luma: FloatArray, segments: IntArray) -> FloatArray:
    """Brightness against the segment's own mean, in octaves, the wide ones counting the most."""
    flat = segments.ravel()
    count = np.maximum(np.bincount(flat), 1)
    mean = (np.bincount(flat, luma.ravel()) / count).astype(np.float32)[segments]
    level = luma - cv2.GaussianBlur(mean, (0, 0), 3)
    total = np.zeros_like(luma)
    current, octave_px = cv2.GaussianBlur(level, (0, 0), 1.5), 1.5
    for k in range(6):
        wide = cv2.GaussianBlur(current, (0, 0), 1.5 * 3**0.5 if k == 0 else 2.6)
        band = current - wide
        band = np.tanh(band / (2 * float(band.std()) + 1e-6)) * octave_px**0.8
        total += cv2.resize(band, luma.shape[1::-1], interpolation=cv2.INTER_LINEAR)
        if min(current.shape) < 8:
            break
        half = (max(current.shape[1] // 2, 1), max(current.shape[0] // 2, 1))
        current, octave_px = cv2.resize(wide, half, interpolation=cv2.INTER_AREA), octave_px * 2
    return total


def _bulge(segments: IntArray) -> FloatArray:
    """Each segment domed like a pebble, no wider than `BULGE_PX`."""
    h, w = segments.shape
    small_size = (max(w // 2, 1), max(h // 2, 1))
    small = cv2.resize(segments, small_size, interpolation=cv2.INTER_NEAREST)
    inner = np.zeros(small.shape, bool)
    inner[1:-1, 1:-1] = (small[1:-1, 1:-1] == small[1:-1, 2:]) & (small[1:-1, 1:-1] == small[2:, 1:-1])
    distance = cv2.distanceTransform(inner.astype(np.uint8), cv2.DIST_L2, 5) * w / small_size[0]
    largest = BULGE_PX * w / 1088
    radius = np.zeros(int(small.max()) + 1, np.float32)
    np.maximum.at(radius, small.ravel(), distance.ravel())
    own = np.minimum(radius, largest)[small] + 1e-3
    t = np.clip(distance / own, 0, 1)
    dome = np.sqrt(np.maximum(1 - (1 - t) ** 2, 0)) * np.sqrt(own / largest)
    dome = cv2.resize(dome.astype(np.float32), (w, h), interpolation=cv2.INTER_LINEAR)
    return cv2.GaussianBlur(dome, (0, 0), 5 * w / 1088)


def _unit(v: FloatArray) -> FloatArray:
    return (v - v.mean()) / (float(v.std()) + 1e-6)


def _scaled(height: FloatArray, active: FloatArray, amplitude_px: float) -> FloatArray:
    """p5..p95 over the active part becomes `amplitude_px`."""
    ground = height[active > 0.5]
    if ground.size < 0.01 * height.size:
        ground = height
    low, high = (float(v) for v in np.percentile(ground[:: max(ground.size // 50000, 1)], (5, 95)))
    return np.clip(height, 2 * low, 2 * high) * (amplitude_px / max(high - low, 1e-3))
