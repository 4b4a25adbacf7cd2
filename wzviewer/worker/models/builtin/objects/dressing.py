"""A marched body put into its fur: what rays met is sorted into the coat and what stands before it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.furring import Furred, Marched, furred
from wzviewer.worker.models.builtin.objects.hairs import Lights
from wzviewer.worker.models.builtin.objects.rays import LongArray, Scene, parallel, shoot
from wzviewer.worker.models.builtin.objects.roots import Skin, margin_px
from wzviewer.worker.models.builtin.objects.shading import Setting
from wzviewer.worker.models.builtin.objects.thin import LIMB

_BEYOND_STRIDE = 8  # px between rays outside the frame, where hairs are rooted that reach into it
_GLINT = 0.016  # of the key's light: a hair's own, whatever its colour
_LEAST = 0.02  # of a pixel that a coat has to itself, to tell its colour


@dataclass(frozen=True, eq=False)
class Fitting:
    """What rays tell of a coat, pixel by pixel.

    Attributes:
        before: (h, w, 5) colour, alpha and limbs of what stands before it, premultiplied.
        before_relief: (h, w) native px; infinite where there is nothing.
        furry: (h, w) share of rays that meet it.
        relief: (h, w) native px of the coat, nan where there is none.
    """

    before: FloatArray
    before_relief: FloatArray
    furry: FloatArray
    relief: FloatArray

    @classmethod
    def of(cls, shape: tuple[int, int], pixels: LongArray, samples: FloatArray) -> "Fitting":
        """Sorts samples (n, columns) of `rays.shoot` at pixels (n, 2)."""
        none = np.zeros(shape, np.float32)
        far, nowhere = none + np.float32(np.inf), none + np.float32(np.nan)
        fitting = cls(np.zeros((*shape, 5), np.float32), far, none, nowhere)
        fitting.refine(pixels[:, 0], pixels[:, 1], samples[:, None])
        return fitting

    def refine(self, x: LongArray, y: LongArray, samples: FloatArray) -> None:
        """Puts in pixels (n,) that several rays (n, r, columns) went through."""
        met, before = samples[:, :, 15] >= 0, samples[:, :, 14] > 0
        self.before[y, x] = samples[:, :, [11, 12, 13, 14, 20]].mean(1)
        self.before_relief[y, x] = np.where(before, samples[:, :, 4], np.float32(np.inf)).min(1)
        self.furry[y, x] = met.mean(1)
        nearest = np.where(met, samples[:, :, 16], np.float32(np.inf)).min(1)
        self.relief[y, x] = np.where(met.any(1), nearest, np.float32(np.nan))

    def marched(self, color: FloatArray, alpha: FloatArray, limbs: FloatArray) -> Marched:
        """Takes what stands before the coat out of a picture's planes (h, w)."""
        over_alpha = self.before[..., 3]
        seen = np.maximum(1 - over_alpha, _LEAST)
        return Marched(
            np.asarray((color - self.before[..., :3]) / seen[..., None], np.float32),
            np.clip((alpha - over_alpha) / seen, 0, 1),
            self.relief,
            self.furry,
            np.clip((limbs - self.before[..., 4]) / seen, 0, 1),
            self.before[..., :3],
            over_alpha,
            self.before_relief,
            self.before[..., 4],
        )


def dressed(
    scene: Scene,
    setting: Setting,
    fitting: Fitting,
    planes: tuple[FloatArray, FloatArray, FloatArray],
    pixels: LongArray,
    samples: FloatArray,
    check: Callable[[], object] | None,
) -> Furred | None:
    """Returns a body in its fur; None if none is in view.

    Args:
        scene: the body in its pose.
        setting: lights.
        fitting: of the rays.
        planes: colour (h, w, 3), alpha and limbs (h, w) of the body without hairs.
        pixels: (n, 2) that one ray each went through.
        samples: (n, columns) of those, of `rays.shoot`.
        check: called several times a second; what it raises stops the work.
    """
    met = samples[:, 15] >= 0
    skins = [_skin(scene, pixels[met] + np.float64(0.5), samples[met], 1.0), *_around(scene, setting, check)]
    if not any(len(skin.points) for skin in skins):
        return None
    glint = _GLINT * setting.key_radiance.astype(np.float64)
    lights = Lights(setting.to_light, setting.to_eye, glint)
    marched = fitting.marched(*planes)

    def run(work: Callable[[int], object], items: list[int]) -> object:
        return parallel(work, items, check)

    return furred(scene.coat, scene.pose, skins, marched, lights, scene.kinds == LIMB, run)


def _skin(scene: Scene, image: DoubleArray, samples: FloatArray, foot_px: float) -> Skin:
    """Returns what of a coat samples (n, columns) at image positions (n, 2) met."""
    corner, dx, dy, direction = scene.frame
    pose = scene.pose
    depth = (samples[:, 16].astype(np.float64) - pose.position[2]) * pose.stretch / pose.size_px
    points = corner + image[:, :1] * dx + image[:, 1:] * dy + depth[:, None] * direction
    cover = np.maximum(samples[:, 3:4] - samples[:, 14:15], _LEAST)
    color = np.maximum(samples[:, :3] - samples[:, 11:14], 0) / cover
    part = samples[:, 15].astype(np.int64)
    return Skin(points, samples[:, 17:20].astype(np.float64), part, color.astype(np.float32), foot_px)


def _around(scene: Scene, setting: Setting, check: Callable[[], object] | None) -> list[Skin]:
    """Marches what lies around the frame, coarsely: hairs reach into the picture from there."""
    margin = int(np.ceil(margin_px(scene.coat, scene.px) / _BEYOND_STRIDE))
    wide, high = (-(-n // _BEYOND_STRIDE) for n in (scene.width, scene.height))
    x, y, z = (v / _BEYOND_STRIDE for v in scene.pose.position)
    pose = replace(
        scene.pose, size_px=scene.pose.size_px / _BEYOND_STRIDE, position=(x + margin, y + margin, z)
    )
    around = Scene(scene.body, pose, wide + 2 * margin, high + 2 * margin, furred=True)
    pixels = around.pixels()
    beyond = (pixels < margin) | (pixels >= np.array([wide, high]) + margin)
    pixels = pixels[np.flatnonzero(beyond.any(1))]
    if not len(pixels):
        return []
    samples = shoot(around, setting, pixels + np.float64(0.5), check)
    found = samples[:, 15] >= 0
    return [_skin(around, pixels[found] + np.float64(0.5), samples[found], float(_BEYOND_STRIDE))]
