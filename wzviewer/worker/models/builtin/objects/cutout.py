"""An image file as an object: cut out, resampled, stood on the support as a softly rounded card."""

from pathlib import Path

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.errors import PromptError
from wzviewer.worker.models.builtin.objects.lighting import linear_from_srgb
from wzviewer.worker.models.builtin.objects.placement import MARGIN, Plane
from wzviewer.worker.models.builtin.objects.render import Layer

_LARGEST = 2048


def load_cutout(path: str) -> FloatArray:
    """Reads an image file: (h, w, 4) sRGB and alpha, 0..1, cropped to what is opaque.

    Without an alpha channel, a border of nearly one colour is cut away (GrabCut, Rother 2004); any
    other picture is used whole.

    Raises:
        PromptError: the file is not a readable image, or nothing of it is opaque.
    """
    data = np.frombuffer(Path(path).read_bytes(), np.uint8)
    image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED) if len(data) else None
    if image is None:
        raise PromptError(repr(path), "not a readable image", "Give a PNG, JPEG or WebP file")
    return _subject(_rgba(image), repr(path))


def prepared(pixels: ByteArray, name: str) -> FloatArray:
    """Does the same for a picture in memory, (h, w, 4) uint8 sRGB and alpha.

    Raises:
        PromptError: it is malformed, or nothing of it is opaque.
    """
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 4 or not pixels.size:
        raise PromptError(repr(name), "not a picture with an alpha channel", "Give an image file")
    if max(pixels.shape[:2]) > _LARGEST:
        raise PromptError(repr(name), f"is larger than {_LARGEST} px", "Give a smaller one")
    return _subject(pixels.astype(np.float32) / np.float32(255), repr(name))


def _subject(rgba: FloatArray, name: str) -> FloatArray:
    """Returns what is opaque of a picture, cut out of a plain ground if need be."""
    shrink = _LARGEST / max(rgba.shape[:2])
    if shrink < 1:
        rgba = cv2.resize(rgba, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    if rgba[..., 3].min() > 0.99:
        rgba[..., 3] = _keyed(rgba[..., :3])
    rows, columns = np.nonzero(rgba[..., 3] > 0.03)
    if len(rows) < 16:
        raise PromptError(name, "nothing of it is opaque", "Give an image with an opaque subject")
    return np.ascontiguousarray(rgba[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1])


def _rgba(image: np.ndarray) -> FloatArray:
    values = image.astype(np.float32) / (65535.0 if image.dtype == np.uint16 else 255.0)
    if values.ndim == 2:
        values = np.repeat(values[..., None], 3, 2)
    alpha = values[..., 3:] if values.shape[2] == 4 else np.ones((*values.shape[:2], 1), np.float32)
    return np.ascontiguousarray(np.dstack([values[..., 2::-1], alpha]))


def _keyed(rgb: FloatArray) -> FloatArray:
    """Returns an alpha that drops a nearly uniform border; all ones if there is none."""
    edge = np.concatenate([rgb[0], rgb[-1], rgb[:, 0], rgb[:, -1]])
    ground = np.median(edge, 0)
    ones = np.ones(rgb.shape[:2], np.float32)
    if np.mean(np.abs(edge - ground).max(-1) < 0.08) < 0.9:
        return ones
    small = min(1.0, 512 / max(rgb.shape[:2]))
    thumb = cv2.resize(rgb, None, fx=small, fy=small, interpolation=cv2.INTER_AREA)
    off = np.abs(thumb - ground).max(-1)
    mask = np.where(off > 0.10, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    mask[off < 0.03] = cv2.GC_BGD
    if not (mask == cv2.GC_PR_FGD).any() or not (mask == cv2.GC_BGD).any():
        return ones
    cv2.setRNGSeed(0)
    cv2.grabCut(
        np.round(thumb * 255).astype(np.uint8)[..., ::-1].copy(),
        mask,
        None,
        np.zeros((1, 65)),
        np.zeros((1, 65)),
        3,
        cv2.GC_INIT_WITH_MASK,
    )
    inside = ((mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)).astype(np.float32)
    if inside.mean() < 0.005:
        return ones
    soft = cv2.resize(cv2.GaussianBlur(inside, (0, 0), 0.8), rgb.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(soft, np.float32)


def card_layer(
    rgba: FloatArray, shape: tuple[int, int], centre_px: tuple[float, float], width_px: float, exposure: float
) -> tuple[Layer, float]:
    """Places a cut-out upright in a view of `shape`.

    Returns:
        the layer, whose relief is 0 at its outline and rises to the viewer; and the y of its foot.
    """
    h, w = shape
    ch, cw = rgba.shape[:2]
    ratio = min(width_px / max(ch, cw), (1 - 2 * MARGIN) * h / ch, (1 - 2 * MARGIN) * w / cw)
    size = (max(round(cw * ratio), 2), max(round(ch * ratio), 2))
    premultiplied = np.dstack([linear_from_srgb(rgba[..., :3]) * rgba[..., 3:], rgba[..., 3]])
    how = cv2.INTER_AREA if ratio < 1 else cv2.INTER_CUBIC
    card = np.clip(cv2.resize(premultiplied, size, interpolation=how), 0, 1)
    x = int(np.clip(centre_px[0] - size[0] / 2, MARGIN * w, (1 - MARGIN) * w - size[0]))
    y = int(np.clip(centre_px[1] - size[1] / 2, MARGIN * h, (1 - MARGIN) * h - size[1]))
    full = np.zeros((h, w, 4), np.float32)
    full[y : y + size[1], x : x + size[0]] = card
    gain = np.float32(np.clip(exposure, 0.6, 1.25))
    inside = (full[..., 3] > 0.5).astype(np.uint8)
    depth = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    thick = max(0.18 * min(size), 1.0)
    round_off = np.sqrt(np.clip(1 - (1 - np.minimum(depth / thick, 1)) ** 2, 0, 1)) * 0.5 * thick
    relief = np.where(inside > 0, -round_off, np.nan).astype(np.float32)
    normal = np.zeros((h, w, 3), np.float32)
    normal[..., 2] = -1
    none = np.zeros_like(relief)
    return Layer(full[..., :3] * gain, full[..., 3], relief, normal, none, none), float(y + size[1])


def card_shadow(
    alpha: FloatArray, foot: float, to_light: tuple[float, float], height_px: float
) -> FloatArray:
    """Returns (h, w, 2) shares of sky and key on the support: the outline laid down, and contact.

    The key comes from the viewer's side, so the shadow lies behind the card, away from the light.
    """
    h, w = alpha.shape
    flat = 0.45  # a shadow on the ground is foreshortened
    slant = float(np.clip(-to_light[0] * 1.2, -1.2, 1.2))
    forward = np.array([[1.0, -slant, slant * foot], [0.0, flat, (1 - flat) * foot]])
    laid = cv2.warpAffine(alpha, forward.astype(np.float32), (w, h), flags=cv2.INTER_LINEAR)
    rows = np.arange(h, dtype=np.float32)[:, None]
    far = np.clip(np.abs(rows - foot) / max(height_px * flat, 1.0), 0, 1)
    near, wide = (
        cv2.GaussianBlur(laid, (0, 0), 1.5),
        cv2.GaussianBlur(laid, (0, 0), max(0.06 * height_px, 1.0)),
    )
    key = 1 - 0.75 * (near * (1 - far) + wide * far) * (1 - 0.5 * far)
    band = alpha * (np.abs(rows - foot) < 0.06 * height_px)
    sky = 1 - 0.7 * np.clip(
        cv2.GaussianBlur(band.astype(np.float32), (0, 0), max(0.035 * height_px, 1.0)) * 1.6, 0, 1
    )
    return np.asarray(np.dstack([sky, key]), np.float32)


def card_lift(plane: Plane, foot: float, x: float) -> float:
    """Returns the relief of the support under the foot."""
    return float(plane(np.float64(x), np.float64(foot)))  # type: ignore[arg-type]
