"""The slow exact renderer: the executable definition of colour, median depth, coverage and level id.

Every other renderer is tested against this one.  It is written to be read: long doubles on the
plain pinhole formula (no expansion about an anchor, so it is an independent witness of `anchor`),
one surfel after the other, front to back::

    u_i = s_i W t_i          W = d p_px / d p at the centre         Cov = u_1 u_1^T + u_2 u_2^T + lp I
    a   = min(o exp(-d^T Cov^-1 d / 2), .99)                        none where a < 1/255
    a'  = 1 - (1 - a)^w      (transmittance)    or    a w           (linear, Eq. 2)
    I  += T a' c,   T *= 1 - a'                                     T starts at 1
    depth, level: of the surfel at which T crosses 1/2              coverage = 1 - T

The order is by depth of the centre relative to the *focus* of the view, in steps of 2^-14 of the
focus's pixel, and by level and index within a step: coplanar levels do not flicker.  For the order, a
level stands back by four of its own native pixels, so that half-way between two scales the finer
one covers the coarser: else noise in their depths decides anew at each surfel which is seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ALPHA_CUT, ALPHA_MAX, LOW_PASS_PX2, SETBACK_PX, SURFEL_SIGMA_PX
from wzviewer.core.opacity import LOG_SPAN_MIN, feather_px, ramp_start
from wzviewer.core.scene import Scene, siblings_before
from wzviewer.core.surfels import Surfels
from wzviewer.core.types import DoubleArray, FloatArray, IntArray

Blend = Literal["transmittance", "linear"]
LongArray = NDArray[Any]  # np.longdouble, which has no alias: 80 bits here, 64 elsewhere

DEPTH_QUANTUM = 2.0**-14  # of the focus's pixel: nearer than that is "equally deep"


@dataclass(frozen=True)
class Focus:
    """What the order of a view is relative to.

    Attributes:
        depth: world units along the camera's axis.
        unit: world length of a pixel there.
    """

    depth: float
    unit: float


def focus_of(camera: Camera, frames: Sequence[LevelFrame]) -> Focus:
    """Returns the focus: the anchor seen nearest to its native scale; the earlier on a tie."""
    depths = [float(camera.to_camera(frame.origin)[2]) for frame in frames]
    seen = [(z, frame.unit) for z, frame in zip(depths, frames, strict=True) if z > 0.0]
    if not seen:
        return Focus(1.0, camera.pixel_scale(1.0))
    off = [round(abs(np.log2(camera.pixel_scale(z) / unit)), 6) for z, unit in seen]
    depth = seen[int(np.argmin(off))][0]
    return Focus(depth, camera.pixel_scale(depth))


def setback(camera: Camera) -> float:
    """Returns by what share of its depth a level of this camera stands back in the order."""
    return SETBACK_PX / camera.focal_px


def depth_row(view: AnchoredView, frame: LevelFrame, focus: Focus, back: float = 0.0) -> FloatArray:
    """Returns (4,) float32 ``(k, constant)``: ``k . u + constant`` is the depth behind the focus, its px.

    Args:
        view: the rendering camera about a level's anchor.
        frame: the level's.
        focus: of the rendered view.
        back: the level's `setback`; of a level by itself it changes nothing.
    """
    k = (1.0 + back) * frame.unit / focus.unit * view.z_axis
    constant = (view.depth - focus.depth + back * view.depth) / focus.unit
    return np.array([*k, constant], np.float64).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Footprints:
    """Surfels of one or more levels as seen by a camera, all float64.

    Attributes:
        centers_px: (n, 2) image positions.
        conics: (n, 3) Cov^-1 as xx, xy, yy.
        extents_px: (n, 2) half sides of the box outside which a < 1/255.
        opacities: (n,).
        weights: (n,) Eq. 3.
        colors: (n, 3).
        depths: (n,) world units; of the centre.
        keys: (n,) depth behind the focus in steps, float32.
        levels: (n,) int32.
    """

    centers_px: DoubleArray
    conics: DoubleArray
    extents_px: DoubleArray
    opacities: DoubleArray
    weights: DoubleArray
    colors: DoubleArray
    depths: DoubleArray
    keys: DoubleArray
    levels: IntArray

    def __len__(self) -> int:
        return len(self.opacities)

    def take(self, index: NDArray[Any]) -> "Footprints":
        """Returns the rows that a mask or an index array selects."""
        return Footprints(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    @classmethod
    def concatenate(cls, parts: Sequence["Footprints"]) -> "Footprints":
        """Joins footprints in order."""
        return cls(*(np.concatenate([getattr(p, n) for p in parts]) for n in cls.__dataclass_fields__))

    def ordered(self) -> "Footprints":
        """Returns the visible ones front to back; ties by level and index."""
        keep = (self.weights > 0.0) & (self.opacities > ALPHA_CUT) & np.isfinite(self.depths)
        kept = self.take(keep)
        return kept.take(np.argsort(kept.keys, kind="stable"))


@dataclass(frozen=True, eq=False)
class ReferenceFrame:
    """What a renderer owes.

    Attributes:
        color: (h, w, 3) float64, premultiplied by coverage.
        coverage: (h, w), 1 - transmittance.
        depth: (h, w) world units; nan where the transmittance stays above 1/2.
        level: (h, w) int32; -1 where undefined.
    """

    color: DoubleArray
    coverage: DoubleArray
    depth: DoubleArray
    level: IntArray

    def over(self, background: Sequence[float]) -> DoubleArray:
        """Returns the colour over a background (r, g, b), (h, w, 3)."""
        return self.color + (1.0 - self.coverage[..., None]) * np.asarray(background, np.float64)


def surfel_axes(quats: DoubleArray) -> tuple[LongArray, LongArray]:
    """First two columns of R(q), (n, 3) each, from (n, 4) wxyz of any length."""
    q = np.asarray(quats, np.longdouble)
    w, x, y, z = (q / np.linalg.norm(q.astype(np.float64), axis=1, keepdims=True)).T
    t1 = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], 1)
    t2 = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], 1)
    return t1, t2


def in_camera(means: NDArray[Any], frame: LevelFrame, camera: Camera) -> LongArray:
    """Camera-space positions (n, 3) of local means, long double."""
    world_from_local = np.asarray(frame.axes, np.longdouble) * np.longdouble(frame.unit)
    world = np.asarray(frame.origin, np.longdouble) + np.asarray(means, np.longdouble) @ world_from_local
    pose = np.asarray(camera.camera_from_world, np.longdouble)
    return world @ pose[:3, :3].T + pose[:3, 3]


def project(p: LongArray, camera: Camera) -> LongArray:
    """Image positions (n, 2) of camera-space points (n, 3) in front, px."""
    f = np.array([camera.fx, camera.fy], np.longdouble)
    c = np.array([camera.cx, camera.cy], np.longdouble)
    return f * p[:, :2] / p[:, 2:] + c


def screen_axes(p: LongArray, axes: LongArray, camera: Camera) -> DoubleArray:
    """W t for camera-space centres and local-to-camera axes (n, 3), px per world unit, (n, 2)."""
    f = np.array([camera.fx, camera.fy], np.longdouble)
    z = p[:, 2:]
    return (f / z * (axes[:, :2] - p[:, :2] / z * axes[:, 2:])).astype(np.float64)


def footprints(
    surfels: Surfels,
    frame: LevelFrame,
    camera: Camera,
    weights: DoubleArray,
    focus: Focus,
    level: int = 0,
    back: float = 0.0,
) -> Footprints:
    """Projects surfels of one level (n); `back` is its `setback`."""
    p = in_camera(surfels.means, frame, camera)
    front = p[:, 2] > 0
    p[~front] = (0, 0, np.nan)
    turn = np.asarray(camera.rotation, np.longdouble) @ np.asarray(frame.axes, np.longdouble).T
    t1, t2 = surfel_axes(surfels.quats.astype(np.float64))
    s = surfels.scales.astype(np.float64) * frame.unit
    u1 = s[:, :1] * screen_axes(p, t1 @ turn.T, camera)
    u2 = s[:, 1:] * screen_axes(p, t2 @ turn.T, camera)
    xx, yy = (u1**2 + u2**2 + LOW_PASS_PX2).T
    xy = u1[:, 0] * u1[:, 1] + u2[:, 0] * u2[:, 1]
    det = xx * yy - xy * xy
    o = surfels.opacities.astype(np.float64)
    reach = np.sqrt(np.maximum(2.0 * np.log(np.maximum(o, 1e-30) / ALPHA_CUT), 0.0))
    behind = p[:, 2] * (1 + np.longdouble(back)) - focus.depth
    keys = np.rint(behind / focus.unit / DEPTH_QUANTUM).astype(np.float32)
    return Footprints(
        centers_px=project(p, camera).astype(np.float64),
        conics=np.stack([yy / det, -xy / det, xx / det], 1),
        extents_px=reach[:, None] * np.sqrt(np.stack([xx, yy], 1)),
        opacities=o,
        weights=weights,
        colors=surfels.colors.astype(np.float64),
        depths=p[:, 2].astype(np.float64),
        keys=keys.astype(np.float64),
        levels=np.full(len(o), level, np.int32),
    )


def log_pixel_scale(means: NDArray[Any], frame: LevelFrame, camera: Camera) -> DoubleArray:
    """log2 of Eq. 1's d / sqrt(fx fy), (n,); nan behind the camera."""
    z = in_camera(means, frame, camera)[:, 2]
    scale_px = np.where(z > 0, z, np.nan) / np.longdouble(camera.focal_px)
    return np.log2(scale_px).astype(np.float64)


def covered(means: NDArray[Any], frame: LevelFrame, camera: Camera) -> DoubleArray:
    """The m of a camera's image at local points, (n,)."""
    p = in_camera(means, frame, camera)
    p[~(p[:, 2] > 0)] = (0, 0, np.nan)
    x, y = project(p, camera).astype(np.float64).T
    inside = np.minimum(np.minimum(x, camera.width - x), np.minimum(y, camera.height - y))
    s = np.clip(np.nan_to_num(inside / feather_px(camera), nan=0.0), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def level_weights(
    scene: Scene, index: int, surfels: Surfels, camera: Camera, compensated: bool = False
) -> DoubleArray:
    """The w of surfels (n) of a visible level: u of the level times what its children leave.

    Args:
        scene: that it is in.
        index: of the level.
        surfels: of the level, (n).
        camera: the rendering camera.
        compensated: take back by how much more than at its native scale the low-pass widens a surfel
            of a level that fades in, as the transmittance blend does; the root never does.
    """
    level, means = scene[index], surfels.means
    render = log_pixel_scale(means, level.frame, camera)
    w = surfels.coverage.astype(np.float64)
    if level.parent is not None:
        start = ramp_start(scene[level.parent].camera, level.camera, level.frame)
        top = log_pixel_scale(means, level.frame, start)
        native = np.log2(surfels.native_scales.astype(np.float64) * level.frame.unit)
        w = w * _ramp(top, render, native)
        w = (
            w * _widening(native, native) / _widening(native, np.maximum(render, native))
            if compensated
            else w
        )
    for index_of_cover in covers_of(scene, index):
        cover = scene[index_of_cover]
        assert cover.parent is not None  # the root covers nothing
        start = ramp_start(scene[cover.parent].camera, cover.camera, cover.frame)
        top = log_pixel_scale(means, level.frame, start)
        low = log_pixel_scale(means, level.frame, cover.camera)
        w = w * (1.0 - covered(means, level.frame, cover.camera) * _ramp(top, render, low))
    return np.nan_to_num(w, nan=0.0)


def _widening(native: DoubleArray, render: DoubleArray) -> DoubleArray:
    """Area of a footprint with the low-pass over without it, (n,), seen at a pixel scale (log2)."""
    return 1.0 + LOW_PASS_PX2 / (SURFEL_SIGMA_PX**2 * np.exp2(2.0 * (native - render)))


def covers_of(scene: Scene, index: int) -> list[int]:
    """Visible levels that take a share from a level: its children, and siblings before it on its path."""
    before = [
        sibling
        for ancestor in scene.path(index)[1:]
        for sibling in siblings_before(scene, ancestor, scene[ancestor].parent or 0)
    ]
    return scene.children(index) + before


def _ramp(top: DoubleArray, here: DoubleArray, low: DoubleArray) -> DoubleArray:
    t = np.clip((top - here) / np.maximum(top - low, LOG_SPAN_MIN), 0.0, 1.0)
    return np.nan_to_num(t, nan=0.0)


def scene_footprints(
    scene: Scene, camera: Camera, modulation: bool = True, blend: Blend = "transmittance"
) -> Footprints:
    """Projects all visible levels of a scene, in scene order."""
    visible = [scene[i] for i in scene.visible()]
    focus = focus_of(camera, [level.frame for level in visible])
    parts = []
    for level in visible:
        w = np.ones(len(level.surfels))
        if modulation:
            w = level_weights(scene, level.index, level.surfels, camera, blend == "transmittance")
        parts.append(
            footprints(level.surfels, level.frame, camera, w, focus, level.index, setback(level.camera))
        )
    return Footprints.concatenate(parts or [_no_footprints(camera)])


def _no_footprints(camera: Camera) -> Footprints:
    frame = LevelFrame(np.zeros(3), np.eye(3), 1.0)
    return footprints(Surfels.empty(), frame, camera, np.zeros(0), Focus(1.0, 1.0))


def fragment_alpha(parts: Footprints, i: int, x: NDArray[Any], y: NDArray[Any], blend: Blend) -> DoubleArray:
    """Alpha of footprint i at pixel centres (x, y): cut, clamped, then weighted."""
    dx, dy = x - parts.centers_px[i, 0], y - parts.centers_px[i, 1]
    a, b, c = parts.conics[i]
    alpha = parts.opacities[i] * np.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy)
    alpha = np.minimum(alpha, ALPHA_MAX)
    weight = parts.weights[i]
    shown = alpha * weight if blend == "linear" else -np.expm1(weight * np.log1p(-alpha))
    return np.where(alpha < ALPHA_CUT, 0.0, shown)


def composite(
    parts: Footprints, width: int, height: int, blend: Blend = "transmittance", left: int = 0, top: int = 0
) -> ReferenceFrame:
    """Blends footprints, in order, over a window of the image.

    Args:
        parts: front to back; see `Footprints.ordered`.
        width: of the window, px.
        height: of the window, px.
        blend: transmittance (exact partition) or linear (Eq. 2).
        left: first column of the window.
        top: first row of the window.
    """
    color, T = np.zeros((height, width, 3)), np.ones((height, width))
    depth, level = np.full((height, width), np.nan), np.full((height, width), -1, np.int32)
    low = np.ceil(parts.centers_px - parts.extents_px - 0.5 - (left, top))
    high = np.floor(parts.centers_px + parts.extents_px - 0.5 - (left, top)) + 1
    low = np.clip(low, 0, (width, height)).astype(int)
    high = np.clip(high, 0, (width, height)).astype(int)
    for i in np.flatnonzero((high > low).all(1)):
        box = (slice(low[i, 1], high[i, 1]), slice(low[i, 0], high[i, 0]))
        x = np.arange(low[i, 0], high[i, 0]) + left + 0.5
        y = np.arange(low[i, 1], high[i, 1])[:, None] + top + 0.5
        a = fragment_alpha(parts, int(i), x, y, blend)
        behind = T[box] * (1.0 - a)
        crossed = (T[box] > 0.5) & (behind <= 0.5)
        depth[box][crossed], level[box][crossed] = parts.depths[i], parts.levels[i]
        color[box] += (T[box] * a)[..., None] * parts.colors[i]
        T[box] = behind
    return ReferenceFrame(color, 1.0 - T, depth, level)


def render(
    scene: Scene, camera: Camera, blend: Blend = "transmittance", modulation: bool = True
) -> ReferenceFrame:
    """Renders the visible levels of a scene, exactly and slowly (about 20 us a surfel)."""
    parts = scene_footprints(scene, camera, modulation, blend).ordered()
    return composite(parts, camera.width, camera.height, blend)
