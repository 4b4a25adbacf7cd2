"""How much a picture looks like a photograph, in three numbers that need no eyes. Guards, not goals.

* NIQE (Mittal, Soundararajan and Bovik 2013): distance of its local statistics from those of pristine
  photographs; photographs score 2.5-6, blur and noise more.  It flatters isotropic grain: never tune by it.
* Spectrum slope: exponent of the radial amplitude spectrum's square, about -2 to -3.2 for photographs.
* Gradient divergence: KL divergence of log gradient magnitude histograms from those of the true picture.

The pristine parameters are those published with BasicSR (Apache-2.0; see ``data/NOTICE``).
"""

from functools import cache
from importlib import resources
from io import BytesIO

import cv2
import numpy as np
from scipy.special import gamma

from wzviewer.core.scene import Scene
from wzviewer.core.types import FloatArray

BLOCK_PX = 96
LUMA_601 = np.array([65.481, 128.553, 24.966])
"""BT.601 luma of R, G, B in 0..1; 16 is added: 16..235, as the reference implementation has it."""
SHAPES = np.arange(0.2, 10.001, 0.001)
GRADIENT_BINS = np.linspace(-1.0, 6.0, 65)
"""Edges of the histogram of log(gradient + 1/e), gradient in grey levels per pixel."""


def naturalness(image: FloatArray, truth: FloatArray | None = None) -> dict[str, float]:
    """Returns the numbers of this module by key.

    Args:
        image: ``(h, w, 3)`` sRGB in 0..1, at least 192 px each way.
        truth: the same picture as a camera saw it, if known.

    Returns:
        ``niqe``, ``spectrum_slope`` and, if the truth is known, ``gradient_kl``.
    """
    found = {"niqe": niqe(image), "spectrum_slope": spectrum_slope(image)}
    if truth is not None:
        found["gradient_kl"] = gradient_kl(image, truth)
    return found


def naturalness_of_levels(scene: Scene) -> dict[str, float]:
    """Returns ``niqe_level_N``, ``spectrum_slope_level_N`` and ``niqe_share_of_bicubic_level_N`` per zoom.

    The share compares with the bicubic enlargement of the same region of the parent's image.
    """
    found: dict[str, float] = {}
    for level in list(scene)[1:]:
        numbers = naturalness(level.image.astype(np.float32) / np.float32(255))
        found |= {f"{name}_level_{level.index}": value for name, value in numbers.items()}
        plain = niqe(_plainly_enlarged(scene, level.index))
        found[f"niqe_share_of_bicubic_level_{level.index}"] = numbers["niqe"] / plain
    return found


def _plainly_enlarged(scene: Scene, index: int) -> FloatArray:
    level = scene[index]
    assert level.parent is not None  # a zoom
    parent = scene[level.parent]
    step = parent.camera.focal_px / level.camera.focal_px
    shift = [
        parent.camera.cx - step * level.camera.cx + 0.5 * step - 0.5,
        parent.camera.cy - step * level.camera.cy + 0.5 * step - 0.5,
    ]
    parent_from_level = np.array([[step, 0.0, shift[0]], [0.0, step, shift[1]]])
    size = (level.camera.width, level.camera.height)
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    image = parent.image.astype(np.float32) / 255
    large = cv2.warpAffine(image, parent_from_level, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.clip(large, 0, 1)


def niqe(image: FloatArray) -> float:
    """Returns the natural image quality evaluator of an ``(h, w, 3)`` picture in 0..1; lower is better.

    Raises:
        ValueError: the picture has fewer than two blocks of 96 px.
    """
    height, width = (side // BLOCK_PX * BLOCK_PX for side in image.shape[:2])
    if height * width < 2 * BLOCK_PX**2:
        raise ValueError(f"a picture of {image.shape[1]}x{image.shape[0]} px is too small for NIQE")
    plane = np.round(image[:height, :width].astype(np.float64) @ LUMA_601 + 16)
    fine = _block_features(_contrast_normalized(plane), BLOCK_PX)
    coarse = _block_features(_contrast_normalized(halved(plane)), BLOCK_PX // 2)
    features = np.concatenate([fine, coarse], 1)
    features = features[np.isfinite(features).all(1)]
    if len(features) < 2:
        return float("nan")  # flat all over: nothing to judge
    mean, covariance = _pristine()
    difference = features.mean(0) - mean
    pooled = 0.5 * (covariance + np.cov(features, rowvar=False))
    return float(np.sqrt(difference @ np.linalg.pinv(pooled) @ difference))


@cache
def _pristine() -> tuple[np.ndarray, np.ndarray]:
    data = resources.files("wzviewer.commands").joinpath("data", "niqe_pris_params.npz").read_bytes()
    with np.load(BytesIO(data), allow_pickle=False) as stored:
        return stored["mu_pris_param"].ravel(), stored["cov_pris_param"]


def _contrast_normalized(plane: np.ndarray) -> np.ndarray:
    """Mean subtracted, contrast normalised coefficients."""
    mean, square = (
        cv2.GaussianBlur(p, (7, 7), 7 / 6, borderType=cv2.BORDER_REPLICATE) for p in (plane, plane * plane)
    )
    return (plane - mean) / (np.sqrt(np.abs(square - mean * mean)) + 1)


def halved(plane: np.ndarray) -> np.ndarray:
    """Returns the ``(h / 2, w / 2)`` reduction by the anti-aliased bicubic kernel, borders mirrored."""
    distance = np.abs(np.arange(-3.5, 4.0)) / 2
    near = 1.5 * distance**3 - 2.5 * distance**2 + 1
    far = -0.5 * distance**3 + 2.5 * distance**2 - 4 * distance + 2
    kernel = np.where(distance <= 1, near, far) / 2
    kernel /= kernel.sum()
    padded = cv2.copyMakeBorder(plane, 3, 4, 3, 4, cv2.BORDER_REFLECT)
    filtered = cv2.sepFilter2D(padded, cv2.CV_64F, kernel, kernel, anchor=(3, 3))
    return filtered[3:-4:2, 3:-4:2]


def _block_features(plane: np.ndarray, side: int) -> np.ndarray:
    """Returns ``(blocks, 18)``: a fit of the coefficients and of their products with four neighbours."""
    rows, columns = plane.shape[0] // side, plane.shape[1] // side
    blocks = plane.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(-1, side, side)
    return np.array([_features(block) for block in blocks])


def _features(block: np.ndarray) -> list[float]:
    shape, left, right = asymmetric_fit(block)
    found = [shape, 0.5 * (left + right)]
    for shift in ((0, 1), (1, 0), (1, 1), (1, -1)):
        shape, left, right = asymmetric_fit(block * np.roll(block, shift, (0, 1)))
        found += [shape, (right - left) * gamma(2 / shape) / gamma(1 / shape), left, right]
    return found


def asymmetric_fit(values: np.ndarray) -> tuple[float, float, float]:
    """Returns shape, left and right spread of the asymmetric generalised Gaussian nearest in moments."""
    left = np.sqrt(np.mean(np.square(values[values < 0]))) if (values < 0).any() else np.nan
    right = np.sqrt(np.mean(np.square(values[values > 0]))) if (values > 0).any() else np.nan
    ratio = left / right
    sharpness = np.mean(np.abs(values)) ** 2 / np.mean(np.square(values)) if values.any() else np.nan
    wanted = sharpness * (ratio**3 + 1) * (ratio + 1) / (ratio**2 + 1) ** 2
    if not np.isfinite(wanted):
        return np.nan, np.nan, np.nan
    shape = float(SHAPES[np.argmin(np.square(_sharpness_of_shapes() - wanted))])
    spread = np.sqrt(gamma(1 / shape) / gamma(3 / shape))
    return shape, float(left * spread), float(right * spread)


@cache
def _sharpness_of_shapes() -> np.ndarray:
    found: np.ndarray = gamma(2 / SHAPES) ** 2 / (gamma(1 / SHAPES) * gamma(3 / SHAPES))
    return found


def spectrum_slope(image: FloatArray) -> float:
    """Returns the exponent of the power spectrum over spatial frequency, from 1/32 to 0.4 cycles per px."""
    plane = _grey(image)
    height, width = plane.shape
    window = np.hanning(height)[:, None] * np.hanning(width)[None]
    power = np.abs(np.fft.rfft2((plane - plane.mean()) * window)) ** 2
    radius = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None])
    edges = np.geomspace(1 / 32, 0.4, 17)
    band = np.digitize(radius, edges)
    level = [np.log(power[band == index].mean() + 1e-9) for index in range(1, len(edges))]
    middle = 0.5 * (np.log(edges[1:]) + np.log(edges[:-1]))
    return float(np.polyfit(middle, level, 1)[0])


def gradient_kl(image: FloatArray, truth: FloatArray) -> float:
    """Returns KL(truth || image) in nats, of the histograms of log gradient magnitude."""
    wanted, found = _gradient_histogram(truth), _gradient_histogram(image)
    return float(np.sum(wanted * np.log(wanted / found)))


def _gradient_histogram(image: FloatArray) -> np.ndarray:
    plane = _grey(image)
    size = np.hypot(np.diff(plane, axis=1)[:-1], np.diff(plane, axis=0)[:, :-1])
    counts, _ = np.histogram(np.log(size + np.exp(-1)), GRADIENT_BINS)
    return (counts + 1e-4 * size.size / len(counts)) / (size.size * 1.0001)


def _grey(image: FloatArray) -> np.ndarray:
    grey: np.ndarray = image.astype(np.float64) @ np.array([0.299, 0.587, 0.114]) * 255
    return grey
