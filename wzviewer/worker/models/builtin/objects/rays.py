"""Rays at one body: in tiles, bands on threads; what each meets, shaded."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.bodies import Body
from wzviewer.worker.models.builtin.objects.coats import Coat
from wzviewer.worker.models.builtin.objects.march import CLOSE_PX, LAYERS, approach, occlude, trace
from wzviewer.worker.models.builtin.objects.patterns import SHADED, SHEET, evaluate
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.roots import is_shown
from wzviewer.worker.models.builtin.objects.shading import Setting, shade
from wzviewer.worker.models.builtin.objects.terms import OPAQUE, OUTPUTS
from wzviewer.worker.models.builtin.objects.thin import LIMB, WING, kinds_of, stamps, widened

LongArray = NDArray[np.int64]
A = TypeVar("A")
B = TypeVar("B")

TILE = 8
BAND = 12288  # rays a band: small enough to cancel within a fraction of a second
COLUMNS, COAT_COLUMNS = 11, 21  # of what a ray returns; with what it meets before a coat, and the coat


class Scene:
    """One body in one pose, prepared for rays: thin parts widened, tiles listed."""

    def __init__(
        self, body: Body, pose: Pose, width: int, height: int, *, furred: bool | None = None
    ) -> None:
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
        self.coat = Coat.of(body)
        self.furred = is_shown(self.coat, self.px) if furred is None else furred
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
    """Returns (r, 11): colour, alpha, relief, normal, limbs, wings, nearest primitive of every ray.

    Where the body wears fur (r, 21): then of what is before its coat colour and alpha; of the coat
    primitive (-1 if none was met), relief and normal (object space); limbs before the coat.
    """
    chunks = [rays[k : k + BAND] for k in range(0, len(rays), BAND)]
    parts = parallel(lambda c: _shoot(scene, setting, c), chunks, check)
    return np.concatenate(parts) if parts else np.zeros((0, COAT_COLUMNS), np.float32)


def _shoot(scene: Scene, setting: Setting, rays: DoubleArray) -> FloatArray:
    depth, hit, normal = scene.march(np.ascontiguousarray(rays, np.float64))
    out = np.zeros((len(rays), COAT_COLUMNS if scene.furred else COLUMNS), np.float32)
    out[:, 4], out[:, 10] = np.nan, hit[:, 0]
    first: LongArray = _first_fur(scene, hit)
    if scene.furred:
        out[:, 15] = -1
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
        if scene.furred:
            before = cover * (k < first[r])
            out[r, 11:14] += before[:, None] * color[here]
            out[r, 14] += before
            out[r, 20] += before * (scene.kinds[hit[r, k]] == LIMB)
        clear[r] -= cover
    front = hit[:, 0] >= 0
    out[front, 4] = scene.pose.relief(depth[front, 0])
    out[front, 5:8] = normal[front, 0] @ scene.pose.camera_from_object.T
    if scene.furred:
        met = np.flatnonzero(first < LAYERS)
        at = (met, first[met])
        out[met, 15], out[met, 16], out[met, 17:20] = hit[at], scene.pose.relief(depth[at]), normal[at]
    return out


def _first_fur(scene: Scene, hit: LongArray) -> LongArray:
    """Returns which hit of each ray (r,) is the first on a coat; `LAYERS` if none is."""
    fur = (hit >= 0) & scene.coat.furry[np.maximum(hit, 0)]
    return np.where(fur.any(1), fur.argmax(1), LAYERS).astype(np.int64)


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
