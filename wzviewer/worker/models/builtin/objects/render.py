"""From a body and a pose to colour, coverage, relief and shadow: rays in tiles, bands on threads."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.bodies import Body
from wzviewer.worker.models.builtin.objects.march import CLOSE_PX, LAYERS, approach, occlude, trace
from wzviewer.worker.models.builtin.objects.patterns import SHADED, SHEET, evaluate
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.shading import Setting, shade
from wzviewer.worker.models.builtin.objects.terms import OPAQUE, OUTPUTS
from wzviewer.worker.models.builtin.objects.thin import LIMB, WING, kinds_of, stamps, widened

LongArray = NDArray[np.int64]
A = TypeVar("A")
B = TypeVar("B")

TILE = 8
BAND = 12288  # rays a band: small enough to cancel within a fraction of a second
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


class Scene:
    """One body in one pose, prepared for rays: thin parts widened, tiles listed."""

    def __init__(self, body: Body, pose: Pose, width: int, height: int) -> None:
        self.body, self.pose, self.width, self.height = body, pose, width, height
        self.px = 1.0 / pose.size_px
        self.frame = pose.frame()
        self.primitives, self.opacity = widened(body.primitives, self.px)
        self.hairs = self.opacity < 0.97
        sheets = body.materials[body.primitives[:, 3].astype(int), SHEET] > 0
        self.opacity = np.where(sheets, np.minimum(self.opacity, 0.96), self.opacity)
        self.kinds = kinds_of(body.primitives, sheets)
        self.casters = np.ascontiguousarray(self.primitives[self.primitives[:, 35] > 0.5])
        self.columns = -(-width // TILE)
        self.ids, self.spans = self._lists()
        self.start, self.via = self._starts()

    def _lists(self) -> tuple[LongArray, LongArray]:
        """Bins bounding spheres into tiles; returns (ids, spans) of `march.trace`."""
        P, rows = self.primitives, -(-self.height // TILE)
        points, radius, owner = stamps(P)
        centre = self.pose.project(points)
        reach = radius * self.pose.size_px * self.pose.stretch + 1.0
        meets = np.zeros((rows, self.columns, len(P)), bool)
        low = np.maximum(np.floor((centre - reach[:, None]) / TILE).astype(int), 0)
        high = np.maximum(np.floor((centre + reach[:, None]) / TILE).astype(int) + 1, 0)
        for (x0, y0), (x1, y1), i in zip(low, high, owner, strict=True):
            meets[y0:y1, x0:x1, i] = True
        tile, ids = np.nonzero(meets.reshape(-1, len(P)))
        ends = np.cumsum(np.bincount(tile, minlength=rows * self.columns))
        spans = np.stack([np.concatenate([[0], ends[:-1]]), ends], 1)
        return np.ascontiguousarray(ids, np.int64), np.ascontiguousarray(spans, np.int64)

    def _starts(self) -> tuple[DoubleArray, LongArray]:
        """Returns (start, via) of `march.approach`: how far all rays of a tile go, layer by layer."""
        start: DoubleArray = np.zeros((len(self.spans), LAYERS))
        via: LongArray = np.zeros((len(self.spans), LAYERS), np.int64)
        rows, columns = np.divmod(np.arange(len(self.spans)), self.columns)
        centres = (np.stack([columns, rows], 1) + 0.5) * TILE
        radius = 0.5 * TILE * np.sqrt(2.0) * self.px
        lists = self.primitives, self.body.outlines, self.opacity, self.ids, self.spans
        approach(*lists, centres, self.frame, radius, start, via)
        return start, via

    def without(self, kind: int) -> "Scene":
        """Returns what is behind the body's wings or its limbs, and not in their contact shadow."""
        rest = replace(self.body, primitives=self.body.primitives[self.kinds < kind])
        return Scene(rest, self.pose, self.width, self.height)

    def pixels(self) -> LongArray:
        """Returns (n, 2) x, y of the pixels in tiles that hold a primitive, tile by tile."""
        tiles = np.flatnonzero(self.spans[:, 1] > self.spans[:, 0])
        offset = np.arange(TILE * TILE)
        x = (tiles % self.columns * TILE)[:, None] + offset % TILE
        y = (tiles // self.columns * TILE)[:, None] + offset // TILE
        inside = (x < self.width) & (y < self.height)
        return np.stack([x[inside], y[inside]], 1).astype(np.int64)

    def march(self, rays: DoubleArray) -> tuple[DoubleArray, LongArray, DoubleArray]:
        """Returns (depth, hit, normal) of rays (r, 2), see `march.trace`."""
        at = np.minimum(
            (rays // TILE).astype(np.int32), [self.columns - 1, len(self.spans) // self.columns - 1]
        )
        tile = (at[:, 1] * self.columns + at[:, 0]).astype(np.int64)
        depth: DoubleArray = np.full((len(rays), LAYERS), np.nan)
        hit: LongArray = np.full((len(rays), LAYERS), -1, np.int64)
        normal: DoubleArray = np.zeros((len(rays), LAYERS, 3))
        trace(
            self.primitives,
            self.body.outlines,
            self.opacity,
            self.ids,
            self.spans,
            rays,
            tile,
            self.start,
            self.via,
            self.frame,
            self.px,
            depth,
            hit,
            normal,
        )
        return depth, hit, normal

    def occlusion(
        self, points: DoubleArray, normals: DoubleArray, to_light: DoubleArray, wide: float = 1.0
    ) -> DoubleArray:
        """Returns (n, 2) shares of sky, out to `wide` times as far, and key that reach object points."""
        out = np.ones((len(points), 2))
        # Short enough for a contact shadow, longer by the pixel's ^.6 so that deep zooms keep theirs.
        reach = wide * 0.012 * min((self.px / 0.0022) ** 0.6, 2.0)
        light = self.pose.camera_from_object.T @ to_light
        occlude(self.casters, self.body.outlines, points, normals, light, self.px, reach, out)
        return out


def render(scene: Scene, setting: Setting, check: Callable[[], object] | None = None) -> Layer:
    """Renders a body: one ray a pixel, four where its surface, a hair or its outline changes.

    Raises:
        whatever `check` raises, between bands.
    """
    pixels = scene.pixels()
    first = shoot(scene, setting, pixels + np.float64(0.5), check)
    layer = _scatter(scene, pixels, first)
    ids = np.full((scene.height, scene.width), -1, np.int64)
    ids[pixels[:, 1], pixels[:, 0]] = first[:, 10].astype(np.int64)
    edges = _edges(ids, layer, scene)
    y, x = (axis.astype(np.int64) for axis in np.nonzero(edges))
    if not len(x):
        return layer
    corners = np.stack([x, y], 1).astype(np.float64)
    rays = (corners[:, None, :] + _ROTATED).reshape(-1, 2)
    samples = shoot(scene, setting, rays, check).reshape(len(x), 4, -1)
    layer.color[y, x] = samples[:, :, :3].mean(1)
    layer.alpha[y, x] = samples[:, :, 3].mean(1)
    layer.limbs[y, x], layer.wings[y, x] = samples[:, :, 8].mean(1), samples[:, :, 9].mean(1)
    return _fill_edges(layer, x, y, samples)


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


def parallel(work: Callable[[A], B], items: list[A], check: Callable[[], object] | None) -> list[B]:
    """Maps on threads (the kernels hold no lock) in the order of the items; asks `check` in between."""
    results: list[B] = []
    with ThreadPoolExecutor(min(os.cpu_count() or 1, 8)) as pool:
        pending = [pool.submit(work, item) for item in items]
        try:
            for job in pending:
                if check is not None:
                    check()
                results.append(job.result())
        except BaseException:
            for job in pending:
                job.cancel()
            raise
    return results


def march_all(
    scene: Scene, rays: DoubleArray, check: Callable[[], object] | None
) -> tuple[DoubleArray, LongArray, DoubleArray]:
    """Does `Scene.march` in bands, on threads."""
    chunks = [rays[k : k + BAND] for k in range(0, max(len(rays), 1), BAND)]
    parts = parallel(scene.march, chunks, check)
    depth, hit, normal = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return depth, hit, normal


def shoot(
    scene: Scene, setting: Setting, rays: DoubleArray, check: Callable[[], object] | None
) -> FloatArray:
    """Returns (r, 11): colour, alpha, relief, normal, limbs, wings, nearest primitive of every ray."""
    chunks = [rays[k : k + BAND] for k in range(0, len(rays), BAND)]
    parts = parallel(lambda c: _shoot(scene, setting, c), chunks, check)
    return np.concatenate(parts) if parts else np.zeros((0, 11), np.float32)


def _shoot(scene: Scene, setting: Setting, rays: DoubleArray) -> FloatArray:
    depth, hit, normal = scene.march(np.ascontiguousarray(rays, np.float64))
    out = np.zeros((len(rays), 11), np.float32)
    out[:, 4], out[:, 10] = np.nan, hit[:, 0]
    ray, layer = np.nonzero(hit >= 0)
    if not len(ray):
        return out
    corner, dx, dy, direction = scene.frame
    points = corner + rays[ray, :1] * dx + rays[ray, 1:] * dy + depth[ray, layer][:, None] * direction
    color, opaque = shade_points(scene, setting, hit[ray, layer], points, normal[ray, layer], rays[ray])
    clear = np.ones(len(rays), np.float32)
    for k in range(LAYERS):
        here = layer == k
        r = ray[here]
        cover = clear[r] * scene.opacity[hit[r, k]].astype(np.float32) * opaque[here]
        out[r, :3] += cover[:, None] * color[here]
        out[r, 3] += cover
        out[r, 8] += cover * (scene.kinds[hit[r, k]] == LIMB)
        out[r, 9] += cover * (scene.kinds[hit[r, k]] == WING)
        clear[r] -= cover
    front = hit[:, 0] >= 0
    out[front, 4] = scene.pose.relief(depth[front, 0])
    out[front, 5:8] = normal[front, 0] @ scene.pose.camera_from_object.T
    return out


def shade_points(
    scene: Scene,
    setting: Setting,
    hit: LongArray,
    points: DoubleArray,
    normals: DoubleArray,
    rays: DoubleArray,
) -> tuple[FloatArray, FloatArray]:
    """Returns (n, 3) linear radiance of object points and (n,) how opaque they are."""
    body = scene.body
    looks, bumped = np.zeros((len(hit), OUTPUTS)), np.zeros((len(hit), 3))
    points, normals = np.ascontiguousarray(points), np.ascontiguousarray(normals)
    evaluate(
        scene.primitives,
        body.materials,
        body.outlines,
        body.cards,
        hit,
        points,
        normals,
        scene.px,
        looks,
        bumped,
    )
    occlusion = _occlusion(scene, setting, hit, points, normals, rays)
    rotate = scene.pose.camera_from_object.T
    rows = body.materials[:, :SHADED].astype(np.float32)[scene.primitives[hit, 3].astype(int)]
    color = shade(
        looks.astype(np.float32),
        rows,
        (bumped @ rotate).astype(np.float32),
        (normals @ rotate).astype(np.float32),
        occlusion.astype(np.float32),
        setting,
    )
    return color, np.clip(looks[:, OPAQUE], 0, 1).astype(np.float32)


def _occlusion(
    scene: Scene,
    setting: Setting,
    hit: LongArray,
    points: DoubleArray,
    normals: DoubleArray,
    rays: DoubleArray,
) -> DoubleArray:
    """Returns (n, 2) occlusion; in a close-up one point of 2x2 pixels speaks for those like it."""
    starts = points + 1.5 * scene.px * normals
    if scene.px > CLOSE_PX:  # in a close-up shadows change slowly
        return scene.occlusion(starts, normals, setting.to_light)
    block = (rays[:, 1] // 2).astype(np.int64) * scene.width + (rays[:, 0] // 2).astype(np.int64)
    group = scene.primitives[hit, 29].astype(np.int64)
    _, first, inverse = np.unique(block * (group.max() + 1) + group, return_index=True, return_inverse=True)
    spoken = first[inverse]
    alike = (normals * normals[spoken]).sum(1) > 0.95
    alike[first] = False
    own = np.flatnonzero(~alike)
    out: DoubleArray = np.ones((len(hit), 2))
    out[own] = scene.occlusion(starts[own], normals[own], setting.to_light)
    out[alike] = out[spoken[alike]]
    return out


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
