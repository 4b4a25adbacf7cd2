"""From a body and a pose to colour, coverage, relief and shadow: one ray a pixel, more at edges."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.objects.dressing import Fitting, dressed
from wzviewer.worker.models.builtin.objects.rays import LongArray, Scene, shoot
from wzviewer.worker.models.builtin.objects.shading import Setting

_ROTATED = np.array([[0.125, 0.625], [0.375, 0.125], [0.625, 0.875], [0.875, 0.375]])  # 4-rooks


@dataclass(frozen=True, eq=False)
class Layer:
    """A rendered body, before it meets the background.

    Attributes:
        color: (h, w, 3) linear, premultiplied by alpha.
        alpha: (h, w) coverage.
        relief: (h, w) native px, nan outside; of the nearest surface.
        normal: (h, w, 3) geometric normals, camera axes.
        limbs: (h, w) share of a pixel that limbs and hairs cover.
        wings: (h, w) the same of what lets light through.
    """

    color: FloatArray
    alpha: FloatArray
    relief: FloatArray
    normal: FloatArray
    limbs: FloatArray
    wings: FloatArray


def render(scene: Scene, setting: Setting, check: Callable[[], object] | None = None) -> Layer:
    """Renders a body: one ray a pixel, four where its surface, a hair or its outline changes; then its fur.

    Raises:
        whatever `check` raises, between bands.
    """
    pixels = scene.pixels()
    first = shoot(scene, setting, pixels + np.float64(0.5), check)
    layer = _scatter(scene, pixels, first)
    fitting = Fitting.of(layer.alpha.shape, pixels, first) if scene.furred else None
    ids = np.full((scene.height, scene.width), -1, np.int64)
    ids[pixels[:, 1], pixels[:, 0]] = first[:, 10].astype(np.int64)
    edges = _edges(ids, layer, scene)
    y, x = (axis.astype(np.int64) for axis in np.nonzero(edges))
    if len(x):
        corners = np.stack([x, y], 1).astype(np.float64)
        rays = (corners[:, None, :] + _ROTATED).reshape(-1, 2)
        samples = shoot(scene, setting, rays, check).reshape(len(x), 4, -1)
        layer = _refined(layer, x, y, samples)
        if fitting is not None:
            fitting.refine(x, y, samples)
    if fitting is None:
        return layer
    return _with_fur(scene, setting, layer, fitting, pixels, first, check)


def _refined(layer: Layer, x: LongArray, y: LongArray, samples: FloatArray) -> Layer:
    """Returns a layer with pixels (n,) that several rays (n, r, columns) went through."""
    layer.color[y, x] = samples[:, :, :3].mean(1)
    layer.alpha[y, x] = samples[:, :, 3].mean(1)
    layer.limbs[y, x], layer.wings[y, x] = samples[:, :, 8].mean(1), samples[:, :, 9].mean(1)
    return _fill_edges(layer, x, y, samples)


def _with_fur(
    scene: Scene,
    setting: Setting,
    layer: Layer,
    fitting: Fitting,
    pixels: LongArray,
    samples: FloatArray,
    check: Callable[[], object] | None,
) -> Layer:
    """Returns a rendered body with its hairs; its relief stays the skin's, beyond its outline theirs."""
    fur = dressed(scene, setting, fitting, (layer.color, layer.alpha, layer.limbs), pixels, samples, check)
    if fur is None:
        return layer
    layer.color[fur.box], layer.alpha[fur.box], layer.limbs[fur.box] = fur.color, fur.alpha, fur.limbs
    marched = layer.relief[fur.box]
    bare = np.isnan(marched) & np.isfinite(fur.relief)
    layer.relief[fur.box] = np.where(bare, fur.relief, marched)
    layer.normal[fur.box][bare] = (0.0, 0.0, -1.0)
    return layer


def render_mask(scene: Scene) -> tuple[BoolArray, FloatArray]:
    """Returns (mask, relief) at one ray a pixel, unshaded: for placing and previewing."""
    pixels = scene.pixels()
    depth, hit, _ = scene.march(pixels + np.float64(0.5))
    mask = np.zeros((scene.height, scene.width), bool)
    relief = np.full((scene.height, scene.width), np.nan, np.float32)
    x, y = pixels[:, 0], pixels[:, 1]
    mask[y, x] = hit[:, 0] >= 0
    relief[y, x] = np.where(hit[:, 0] >= 0, scene.pose.relief(depth[:, 0]), np.nan)
    return mask, relief


def _scatter(scene: Scene, pixels: LongArray, samples: FloatArray) -> Layer:
    shape = (scene.height, scene.width)
    layer = Layer(
        np.zeros((*shape, 3), np.float32),
        np.zeros(shape, np.float32),
        np.full(shape, np.nan, np.float32),
        np.zeros((*shape, 3), np.float32),
        np.zeros(shape, np.float32),
        np.zeros(shape, np.float32),
    )
    x, y = pixels[:, 0], pixels[:, 1]
    layer.color[y, x], layer.alpha[y, x] = samples[:, :3], samples[:, 3]
    layer.relief[y, x], layer.normal[y, x] = samples[:, 4], samples[:, 5:8]
    layer.limbs[y, x], layer.wings[y, x] = samples[:, 8], samples[:, 9]
    return layer


def _edges(ids: LongArray, layer: Layer, scene: Scene) -> BoolArray:
    """Marks pixels whose 3x3 neighbourhood changes group, brightness or holds a hair."""
    group = np.where(ids >= 0, scene.primitives[np.maximum(ids, 0), 29] + 1, 0).astype(np.float32)
    thin = (ids >= 0) & scene.hairs[np.maximum(ids, 0)]
    kernel = np.ones((3, 3), np.uint8)
    changes = cv2.dilate(group, kernel) != cv2.erode(group, kernel)
    inside = ids >= 0
    luma = np.sqrt(np.maximum(layer.color.mean(-1), 0))
    contrast = (cv2.dilate(luma, kernel) - cv2.erode(luma, kernel) > 0.35) & inside
    if inside.mean() > 0.5:  # a close-up: its bumps are everywhere, and many pixels wide
        contrast[:] = False
    hairs = cv2.dilate(thin.astype(np.uint8), kernel) > 0
    return np.asarray(changes | hairs | contrast, bool)


def _fill_edges(layer: Layer, x: LongArray, y: LongArray, samples: FloatArray) -> Layer:
    """Gives pixels that only a sub-ray hit a relief and a normal: those of the nearest hit."""
    empty = np.isnan(layer.relief[y, x]) & np.isfinite(samples[:, :, 4]).any(1)
    nearest = np.argmin(np.nan_to_num(samples[empty, :, 4], nan=np.inf), 1)
    chosen = samples[empty, nearest]
    layer.relief[y[empty], x[empty]] = chosen[:, 4]
    layer.normal[y[empty], x[empty]] = chosen[:, 5:8]
    return layer
