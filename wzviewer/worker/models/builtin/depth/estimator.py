"""The built-in depth estimator: a picture of any size in, inverse depth and sky out.

Working sizes (a 3:2 picture): network 144x96 and 216x144, quarter 272x180, half 544x360,
full 1088x720.  Other aspects keep the areas.
"""

from dataclasses import dataclass
from importlib import resources

import cv2
import numpy as np
import torch
from safetensors.torch import load

from wzviewer.core.constants import SKY_DEPTH
from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.worker.models.builtin.depth.figures import find_figures, stand_figures
from wzviewer.worker.models.builtin.depth.grid import BilateralGrid
from wzviewer.worker.models.builtin.depth.macro import (
    focus_disparity,
    focus_ratio,
    local_ratio,
    macro_gate,
)
from wzviewer.worker.models.builtin.depth.network import STRIDE, DepthNetwork
from wzviewer.worker.models.builtin.depth.refine import (
    extend_under,
    resize_steps,
    segment,
    segment_planes,
    smooth_disparity,
    snap_steps,
)
from wzviewer.worker.models.builtin.depth.sky import Sky, contour, fuse_sky, sigmoid
from wzviewer.worker.models.builtin.depth.upright import stand_up

NETWORK_AREA, FINE_AREA = 144 * 96, 216 * 144
QUARTER_AREA = 272 * 180
DEPTH_FLOOR = 0.06  # inverse depth of the farthest thing that is not sky, the nearest being 1


@dataclass(frozen=True)
class DepthReading:
    """What the estimator says about one picture.

    Attributes:
        disparity: (h, w) f32 inverse depth up to a factor, >= 0; the 98th percentile is 1. It is
            continued under the sky.
        sky: (h, w) bool.
        kind: "landscape", "macro" or "indoor".
        confidence: 0..1, agreement of the network with itself on the mirrored picture.
    """

    disparity: FloatArray
    sky: BoolArray
    kind: str
    confidence: float


def depth_from_reading(reading: DepthReading) -> FloatArray:
    """Depth of stage 0.

    Args:
        reading: from `DepthEstimator.read`.

    Returns:
        (h, w) f32 z > 0, world units: the median of what is not sky is 1, sky at `SKY_DEPTH`.
    """
    top = max(float(np.percentile(reading.disparity, 98)), 1e-6)
    d = np.clip(reading.disparity / top, 0, 2)
    z = 1 / (DEPTH_FLOOR + (1 - DEPTH_FLOOR) * d)
    ground = z[~reading.sky]
    z = z / (float(np.median(ground)) if ground.size else 1.0)
    return np.where(reading.sky, SKY_DEPTH, np.minimum(z, 0.8 * SKY_DEPTH)).astype(np.float32)


class DepthEstimator:
    """Reads depth from single pictures with the network that comes with the package.

    Args:
        seed: kept for the interface; the reading has no random part.
    """

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._network = load_network()

    def read(self, image: FloatArray) -> DepthReading:
        """Estimates inverse depth and sky.

        Args:
            image: (h, w, 3) f32 sRGB 0..1, any size from 16x16.

        Returns:
            A reading at the image's size.
        """
        picture = Pyramid.of(image)
        disparity, logit, stands, confidence = self._look(picture)
        sky = contour(fuse_sky(logit, picture.quarter), picture.half, picture.full, sigmoid(logit))
        disparity, gate = _with_focus(disparity, sky, picture)
        disparity = _refine(disparity, sky, sigmoid(stands), picture)
        kind = "macro" if gate > 0.5 else ("landscape" if sky.mask.mean() > 0.03 else "indoor")
        size = (image.shape[1], image.shape[0])
        outside = cv2.resize(sky.mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        return DepthReading(np.maximum(resize_steps(disparity, size), 0), outside, kind, confidence)

    def trainable(self, reading: DepthReading, image: FloatArray) -> BilateralGrid:
        """The module whose parameters a registration fine-tunes (D_theta of Eq. 5).

        Args:
            reading: of the same picture.
            image: (h, w, 3) f32 sRGB 0..1.
        """
        size = _sized(image, QUARTER_AREA)
        luma = cv2.resize(image, size, interpolation=cv2.INTER_AREA) @ np.array(
            [0.299, 0.587, 0.114], np.float32
        )
        estimate = cv2.resize(reading.disparity, size, interpolation=cv2.INTER_AREA)
        return BilateralGrid(estimate, np.clip(luma, 0, 1).astype(np.float32))

    def _look(self, picture: "Pyramid") -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """Network at two sizes: disparity (p98 = 1), logits of sky and of standing, confidence."""
        size = picture.quarter.shape[1::-1]
        coarse, confidence = self._mirrored(picture.image, NETWORK_AREA, size)
        fine, _ = self._mirrored(picture.image, FINE_AREA, size)
        disparity = coarse[0] + 0.6 * (_high_pass(fine[0]) - _high_pass(coarse[0]))
        disparity = np.maximum(disparity, 0) / max(float(np.percentile(disparity, 98)), 1e-6)
        sky = 0.65 * coarse[1] + 0.35 * fine[1]
        return disparity.astype(np.float32), sky, 0.5 * (coarse[2] + fine[2]), confidence

    def _mirrored(
        self, image: FloatArray, area: int, size: tuple[int, int]
    ) -> tuple[list[FloatArray], float]:
        """The network's maps of the picture and its mirror image, averaged, resized to `size`; confidence."""
        w, h = _sized(image, area, STRIDE)
        small = np.clip(cv2.resize(image, (w, h), interpolation=cv2.INTER_AREA), 0, 1)
        both = torch.from_numpy(np.stack([small, small[:, ::-1]]).transpose(0, 3, 1, 2).copy()).float()
        with torch.no_grad():
            maps = [t.numpy() for t in self._network(both)]
        plain, mirrored = maps[0][0], maps[0][1, :, ::-1]
        spread = float(np.abs(plain - plain.mean()).mean()) + 0.02
        confidence = float(np.clip(1 - np.abs(plain - mirrored).mean() / spread, 0, 1))
        means = [(m[0] + m[1, :, ::-1]) / 2 for m in maps]
        return [cv2.resize(m, size, interpolation=cv2.INTER_CUBIC) for m in means], confidence


@dataclass(frozen=True)
class Pyramid:
    """One picture at its working sizes: floats where maths is done, bytes where OpenCV filters want them."""

    image: FloatArray
    quarter: FloatArray
    half: ByteArray
    full: ByteArray

    @staticmethod
    def of(image: FloatArray) -> "Pyramid":
        """Builds it from (h, w, 3) sRGB 0..1."""
        image = np.ascontiguousarray(np.clip(np.nan_to_num(image), 0, 1), np.float32)
        area = image.shape[0] * image.shape[1]
        full_area = min(max(area, 4 * QUARTER_AREA), 16 * QUARTER_AREA)
        quarter, half, full = (
            cv2.resize(
                image, _sized(image, a), interpolation=cv2.INTER_AREA if a < area else cv2.INTER_LINEAR
            )
            for a in (QUARTER_AREA, 4 * QUARTER_AREA, full_area)
        )
        return Pyramid(image, quarter, _bytes(half), _bytes(full))


def load_network() -> DepthNetwork:
    """The packaged network, ready to run."""
    data = (
        resources.files("wzviewer.worker.models.builtin.weights").joinpath("depth.safetensors").read_bytes()
    )
    network = DepthNetwork()
    network.load_state_dict({name: value.float() for name, value in load(data).items()})
    network.requires_grad_(False)
    return network.eval()


def _sized(image: FloatArray, area: int, multiple: int = 1) -> tuple[int, int]:
    """Width and height of about `area`, the image's aspect kept within 1:3."""
    h, w = image.shape[:2]
    aspect = min(max(w / h, 1 / 3), 3.0) if multiple > 1 else w / h
    height = (area / aspect) ** 0.5
    sides = (height * aspect, height)
    width, height = (max(round(s / multiple), 4 if multiple > 1 else 8) * multiple for s in sides)
    return int(width), int(height)


def _bytes(image: FloatArray) -> ByteArray:
    return np.ascontiguousarray((np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8))


def _high_pass(d: FloatArray) -> FloatArray:
    return d - cv2.GaussianBlur(d, (0, 0), 6)


def _with_focus(disparity: FloatArray, sky: Sky, picture: Pyramid) -> tuple[FloatArray, float]:
    """Mixes the focus reading in where the picture is a close-up; returns the gate as well."""
    quarter = _bytes(picture.quarter)
    size = quarter.shape[1::-1]
    outside = cv2.resize(sky.soft, size, interpolation=cv2.INTER_LINEAR) > 0.5
    ratio, weight = focus_ratio(picture.full, size, outside)
    gate = macro_gate(ratio, weight, outside)
    if gate <= 0:
        return disparity, 0.0
    share = 0.85 * gate
    focus = focus_disparity(ratio, weight, local_ratio(picture.full, size), quarter)
    return (1 - share) * disparity + share * focus, gate


def _refine(disparity: FloatArray, sky: Sky, stands: FloatArray, picture: Pyramid) -> FloatArray:
    """Quarter-size disparity to the full size: smooth, planes, steps snapped at two sizes."""
    soft = sky.soft > 0.5
    d = smooth_disparity(disparity, sky.soft, picture.half)
    ground = d[~soft]
    d = d / max(float(np.percentile(ground, 98)) if ground.size else 1.0, 1e-6)
    labels = segment((picture.half / np.float32(255)).astype(np.float32), max(d.shape), 0.8, 250, 120)
    figures = find_figures(picture.half, soft)
    labels = np.where(figures > 0, labels.max() + figures, labels).astype(np.int32)
    stood = stand_up(d, soft, labels, stands, picture.half, figures > 0)
    d = stand_figures(stood, figures, d)
    d = segment_planes(d, soft, labels)
    d = extend_under(d, soft)
    d = cv2.bilateralFilter(d, 9, 0.06, 4)
    d = snap_steps(d, _lab(picture.half), 5, 0.10 * (0.4 + cv2.dilate(d, np.ones((11, 11), np.uint8))), 0.03)
    size = picture.full.shape[1::-1]
    d = cv2.resize(d, size, interpolation=cv2.INTER_LINEAR)
    return snap_steps(d, _lab(picture.full), 3, 0.10 * (0.4 + cv2.dilate(d, np.ones((7, 7), np.uint8))), 0.03)


def _lab(image: ByteArray) -> FloatArray:
    return cv2.cvtColor(image, cv2.COLOR_RGB2LAB).astype(np.float32)
