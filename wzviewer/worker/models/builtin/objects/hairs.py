"""The shape and the light of each hair: which way it bends, which tuft it belongs to, its colour."""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects import strands
from wzviewer.worker.models.builtin.objects.coats import Coat
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.roots import Roots, reach_px, width_px

_JOINTS = 12  # of a hair
_TUFTS = 0.05  # body lengths, the largest; each further kind is a quarter of that
_WISP = 0.0031  # body lengths: hairs so close lie in one layer
_DRAWN = (0.5, 0.8)  # of the way to its tuft, by a hair's tip: to the largest, to smaller ones
_ASTRAY = (0.28, 0.4)  # of its length at most
LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True, eq=False)
class Lights:
    """Unit directions (3,) in camera axes, and (3,) linear radiance of the key's glint on a black hair."""

    to_light: DoubleArray
    to_eye: DoubleArray
    glint: DoubleArray


def hairs(coat: Coat, pose: Pose, roots: Roots, lights: Lights) -> tuple[DoubleArray, FloatArray, FloatArray]:
    """Returns joints (n, k, 4), colours (n, k, 3) and lengths (n,) of `strands.draw`."""
    px, n = 1.0 / pose.size_px, len(roots.points)
    lie = _ruffled(coat.lie(roots.points, roots.normals), roots)
    length = roots.length * (0.65 + 0.5 * roots.chance[:, 0])
    piece = np.minimum(1.0, reach_px(coat, px) * px / length)
    start = (1 - piece) * _started(roots)
    tip, tufts = _gathered(roots, lie, length[:, None], start[:, None], px)
    lift = coat.lifts[roots.part] * (0.6 + 0.8 * roots.chance[:, 1])
    shape = np.column_stack([length, start, piece, lift, 0.06 * (roots.chance[:, 2] - 0.5)])
    frame = np.concatenate([pose.camera_from_object * pose.size_px, [pose.position]])
    joints, along = np.zeros((n, _JOINTS, 4)), np.zeros((n, _JOINTS, 3))
    strands.grow(roots.points, roots.normals, lie, tip, shape, frame, joints, along)
    joints[..., :2] -= (joints[..., 2:3] - pose.position[2]) * np.asarray(pose.ray)
    joints[..., 3] = _half_widths(roots, start, width_px(coat, px))
    colors = _lit(along, shape, roots, tufts, lights)
    return joints, colors, (piece * length / px).astype(np.float32)


def _half_widths(roots: Roots, start: DoubleArray, wide: float) -> DoubleArray:
    """Returns half the width (n, k) of hairs, px: they taper to a point, and pieces begin in one too."""
    t = np.linspace(0, 1, _JOINTS)
    whole, cut = (np.minimum(1.0, blunt + 4 * t) * (1 - t**2.2) ** 0.8 for blunt in (0.3, 0.05))
    own = wide * (0.75 + 0.5 * roots.chance[:, 3])
    return np.asarray(0.5 * own[:, None] * np.where(start[:, None] > 0, cut, whole))


def _started(roots: Roots) -> DoubleArray:
    """Returns how far along their hairs pieces may begin (n,): alike in a wisp, so that wisps overlap."""
    ident = np.zeros(len(roots.points))
    strands.gather(roots.points, _WISP, 97, np.zeros_like(roots.points), ident)
    return np.asarray(0.3 + 0.55 * ident + 0.15 * roots.chance[:, 4])


def _ruffled(lie: DoubleArray, roots: Roots) -> DoubleArray:
    """Turns hairs a little in the skin: in swirls, and each on its own."""
    angle = 0.15 * (roots.chance[:, 2] - 0.5) + 0.25 * (roots.chance[:, 3] - 0.5) ** 3
    for frequency, amount in ((7.0, 0.20), (31.0, 0.12), (140.0, 0.08)):
        noise = np.zeros(len(lie))
        strands.wave(roots.points, frequency, noise)
        angle = angle + amount * noise
    side = np.cross(roots.normals, lie)
    return np.asarray(np.cos(angle)[:, None] * lie + np.sin(angle)[:, None] * side)


def _gathered(
    roots: Roots, lie: DoubleArray, length: DoubleArray, start: DoubleArray, px: float
) -> tuple[DoubleArray, DoubleArray]:
    """Returns how far tips are drawn together (n, 3), and the tone of each one's tufts (n,).

    Of a hair of which only a piece is seen, the root lies back along it: it belongs to the same tuft
    as at the coarser level that shows the whole of it.
    """
    steps = 3 if (start > 0).any() else 1
    tip, tone = np.zeros_like(lie), np.ones(len(lie))
    for _ in range(steps):
        origin = roots.points - start * length * lie - start**1.4 * tip
        tip, tone = _drawn_together(origin, roots.normals, lie, length, px)
    return tip, tone


def _drawn_together(
    origin: DoubleArray, normals: DoubleArray, lie: DoubleArray, length: DoubleArray, px: float
) -> tuple[DoubleArray, DoubleArray]:
    tip, tone = np.zeros_like(lie), np.ones(len(lie))
    for k in range(9):
        lam = _TUFTS * 0.25**k
        if lam < 5.0 * px:
            break
        toward, ident = np.zeros_like(lie), np.zeros(len(lie))
        strands.gather(origin + tip, lam, 101 + k, toward, ident)
        toward -= (toward * normals).sum(1, keepdims=True) * normals
        toward -= 0.7 * (toward * lie).sum(1, keepdims=True) * lie
        far = np.linalg.norm(toward, axis=1, keepdims=True)
        share, most = _DRAWN[min(k, 1)], _ASTRAY[min(k, 1)]
        tip += share * toward * np.minimum(1.0, most * length / np.maximum(far, 1e-12))
        tone *= 1 + 0.22 * (ident - 0.5)
    return tip, tone


def _lit(
    along: DoubleArray, shape: DoubleArray, roots: Roots, tufts: DoubleArray, lights: Lights
) -> FloatArray:
    """Colours joints (n, k, 3): no two hairs alike, some of them paler guard hairs, some darker."""
    tone = tufts * (0.85 + 0.30 * roots.chance[:, 0])
    odd = roots.chance[:, 3]
    tone *= np.where(odd < 0.05, 1.35, np.where(odd > 0.94, 0.62, 1.0))
    base = np.asarray(roots.color, np.float64)
    pale = 0.95 * base + 0.12 * (base @ LUMA)[:, None] + lights.glint
    base = base * (1 + 0.10 * (roots.chance[:, 1:2] - 0.5) * np.array([1.0, 0.0, -1.0]))
    shift = 0.15 * (roots.chance[:, 0] - 0.5)
    colors = np.zeros(along.shape, np.float32)
    strands.light(along, shape, tone, shift, base, pale, lights.to_light, lights.to_eye, colors)
    return colors
