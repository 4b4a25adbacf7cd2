"""Shading of hit points in linear light: a key with a soft terminator, sky and bounce, two lobes.

The clear coat with its soft window lobe is the most important term: without it insects look like
painted clay.
"""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.types import DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.lighting import Environment, Light
from wzviewer.worker.models.builtin.objects.patterns import WATER
from wzviewer.worker.models.builtin.objects.terms import COAT, LOST, ROUGH, THIN


@dataclass(frozen=True, eq=False)
class Setting:
    """Where an object stands: what its shading needs beside its own surface.

    Attributes:
        light: the photograph's light.
        to_light: (3,) key direction, raised above the support, camera axes.
        to_eye: (3,) unit, camera axes.
        up: (3,) normal of the support, camera axes.
        bounce: (3,) linear radiance of the support.
        environment: radiance by direction.
    """

    light: Light
    to_light: DoubleArray
    to_eye: DoubleArray
    up: DoubleArray
    bounce: DoubleArray
    environment: Environment

    @property
    def key_radiance(self) -> FloatArray:
        """(3,) what a white surface facing the key sends back."""
        share = self.light.ratio / (1 + self.light.ratio)
        return np.asarray(1.30 * self.light.exposure * share * self.light.key, np.float32)

    @property
    def sky_radiance(self) -> FloatArray:
        """(3,) what a white surface open to the sky sends back."""
        share = 1 / (1 + self.light.ratio)
        return np.asarray(1.10 * self.light.exposure * share * self.light.ambient, np.float32)


def shade(
    looks: FloatArray,
    rows: FloatArray,
    normal: FloatArray,
    flat: FloatArray,
    occlusion: FloatArray,
    setting: Setting,
) -> FloatArray:
    """Returns (n, 3) linear radiance.

    Args:
        looks: (n, 9) columns of `patterns.evaluate`.
        rows: (n, 24) material rows.
        normal: (n, 3) bumped normals, camera axes.
        flat: (n, 3) geometric normals, camera axes.
        occlusion: (n, 2) shares of sky and key that arrive.
        setting: lights and directions.
    """
    albedo, metal = looks[:, :3], rows[:, 8:9]
    eye, to_light = setting.to_eye.astype(np.float32), setting.to_light.astype(np.float32)
    sky = np.maximum(occlusion[:, :1], 0.12)
    lost = np.minimum(looks[:, LOST : LOST + 1], 0.12)
    coat = rows[:, 13:14] * looks[:, COAT : COAT + 1]
    normal = _facing(normal, eye)
    diffuse = _diffuse(albedo, rows, normal, sky, occlusion[:, 1:2], setting, looks[:, THIN : THIN + 1])
    key = setting.key_radiance * occlusion[:, 1:2]
    f0 = rows[:, 11:12] * (1 - metal) + albedo * metal
    rough = looks[:, ROUGH : ROUGH + 1]
    sharp = _lobe(normal, eye, to_light, rough**2 + lost, f0)
    _, seen = _reflected(normal, eye, rough, setting)
    fresnel = f0 + (np.maximum(1 - rough, f0) - f0) * (1 - np.clip(normal @ eye, 0, 1))[:, None] ** 5
    base = sharp * key + fresnel * seen * sky * np.where(coat > 0, 0.3, 1.0)
    sheen = (
        rows[:, 14:15]
        * (1 - np.clip(normal @ eye, 0, 1))[:, None] ** 3
        * (sky * setting.sky_radiance + 0.4 * key)
    )
    color = diffuse * (1 - metal) + base + sheen * albedo
    return np.asarray(color + _coat(coat, rows, lost, normal, flat, key, sky, setting), np.float32)


def _facing(normal: FloatArray, eye: FloatArray) -> FloatArray:
    """Bends normals that a bump has turned away back to the viewer's side."""
    away = np.minimum(normal @ eye - 0.02, 0)[:, None]
    bent = normal - away * eye
    return bent / np.maximum(np.linalg.norm(bent, axis=1, keepdims=True), 1e-6)


def _diffuse(
    albedo: FloatArray,
    rows: FloatArray,
    normal: FloatArray,
    sky: FloatArray,
    key: FloatArray,
    setting: Setting,
    thin: FloatArray,
) -> FloatArray:
    to_light = setting.to_light.astype(np.float32)
    cosine = (normal @ to_light)[:, None]
    wrap = rows[:, 10:11]
    lit = np.maximum((cosine + wrap) / (1 + wrap), 0) ** (1 + wrap / 2) * (
        key * (1 - 0.35 * wrap) + 0.35 * wrap
    )
    vertical = np.array([0, -0.8, 0]) + 0.6 * setting.up
    above = np.clip(0.5 + 0.5 * normal @ vertical.astype(np.float32), 0, 1)[:, None]
    ambient = (setting.sky_radiance * above + 0.8 * setting.bounce.astype(np.float32) * (1 - above)) * sky
    through = rows[:, 12:13] * thin * np.maximum(0, 0.2 - 0.8 * cosine) * key
    soft = 1 + wrap * (albedo - 0.5 * lit) / 4
    return np.asarray(albedo * (setting.key_radiance * (lit + through) + ambient) * soft, np.float32)


def _lobe(
    normal: FloatArray, eye: FloatArray, to_light: FloatArray, alpha: FloatArray, f0: FloatArray
) -> FloatArray:
    """GGX with Smith's shadowing times pi, clipped."""
    half = (eye + to_light) / np.linalg.norm(eye + to_light)
    nl = np.clip(normal @ to_light, 0, 1)[:, None]
    nv = np.clip(normal @ eye, 0.03, 1)[:, None]
    nh = np.clip(normal @ half, 0, 1)[:, None]
    a2 = np.maximum(alpha, 0.008) ** 2
    d = a2 / (nh * nh * (a2 - 1) + 1) ** 2
    k = np.maximum(alpha, 0.008) / 2
    visible = 1 / (4 * (nl * (1 - k) + k) * (nv * (1 - k) + k))
    fresnel = f0 + (1 - f0) * (1 - np.clip(eye @ half, 0, 1)) ** 5
    return np.asarray(np.minimum(d * visible * fresnel * nl, 8.0), np.float32)


def _reflected(
    normal: FloatArray, eye: FloatArray, rough: FloatArray, setting: Setting
) -> tuple[FloatArray, FloatArray]:
    mirrored = 2 * (normal @ eye)[:, None] * normal - eye
    return mirrored, setting.environment(mirrored, rough[:, 0], setting.up)


def _coat(
    coat: FloatArray,
    rows: FloatArray,
    lost: FloatArray,
    normal: FloatArray,
    flat: FloatArray,
    key: FloatArray,
    sky: FloatArray,
    setting: Setting,
) -> FloatArray:
    """A clear layer that follows the large form more than the bumps; it mirrors a soft window."""
    eye, to_light = setting.to_eye.astype(np.float32), setting.to_light.astype(np.float32)
    n = 0.7 * flat + 0.3 * normal
    n = _facing(n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-6), eye)
    alpha = rows[:, 15:16] + 0.6 * lost
    spot = np.minimum(1.2 * _lobe(n, eye, to_light, alpha, np.full_like(alpha, 0.045)), 12.0)
    mirrored, seen = _reflected(n, eye, np.sqrt(alpha), setting)
    toward = (mirrored @ to_light)[:, None]
    spread = 0.6 * lost + 0.1 * rows[:, 15:16]
    t = np.clip((toward - (0.90 - spread)) / (0.065 + 2 * spread), 0, 1)
    window = 0.55 * coat * t * t * (3 - 2 * t) * (rows[:, 0:1] != WATER)
    fresnel = 0.045 + 0.955 * (1 - np.clip(n @ eye, 0, 1))[:, None] ** 5
    # Ground and neighbours hide the horizon from a crevice: reflections fade with the sky.
    return np.asarray(
        coat * (spot + window) * key + coat * np.minimum(fresnel, 0.5) * seen * sky * sky, np.float32
    )
