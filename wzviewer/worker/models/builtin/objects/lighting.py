"""Light read from the photograph: a key direction, colours, exposure, and a small mirror-ball map.

Camera axes (x right, y down, z forward).  A `Light` is small enough to be saved with a placement,
so that a deeper level shades the same object by the same light.
"""

import base64
from dataclasses import dataclass

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, DoubleArray, FloatArray

MAP_WIDTH, MAP_HEIGHT = 48, 32
_BLURS = (0.9, 2.2, 6.0)
_ASIDE = 0.42


def linear_from_srgb(image: FloatArray) -> FloatArray:
    """Returns linear light of sRGB values, any shape."""
    x = np.clip(image, 0, 1)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4).astype(np.float32)


def srgb_from_linear(image: FloatArray) -> FloatArray:
    """Returns sRGB values of linear light, any shape."""
    x = np.clip(image, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Light:
    """The light of one picture.

    Attributes:
        direction: (3,) unit, towards the key light, camera axes.
        key: (3,) colour of the key, mean 1.
        ambient: (3,) colour of the sky light, mean 1.
        ratio: key to ambient.
        exposure: irradiance that fits the picture.
        mirror: (32, 48, 3) uint8 sRGB, what a mirror ball would show.
    """

    direction: DoubleArray
    key: DoubleArray
    ambient: DoubleArray
    ratio: float
    exposure: float
    mirror: ByteArray

    def to_dict(self) -> dict[str, object]:
        """Returns a JSON-able form."""
        return {
            "direction": [round(float(v), 6) for v in self.direction],
            "key": [round(float(v), 6) for v in self.key],
            "ambient": [round(float(v), 6) for v in self.ambient],
            "ratio": round(self.ratio, 6),
            "exposure": round(self.exposure, 6),
            "mirror": base64.b64encode(self.mirror.tobytes()).decode("ascii"),
        }

    @classmethod
    def from_dict(cls, data: dict[str, object]) -> "Light":
        """Returns the light that `to_dict` wrote."""
        mirror = np.frombuffer(base64.b64decode(str(data["mirror"])), np.uint8)
        return cls(
            np.asarray(data["direction"], np.float64),
            np.asarray(data["key"], np.float64),
            np.asarray(data["ambient"], np.float64),
            float(data["ratio"]),  # type: ignore[arg-type]
            float(data["exposure"]),  # type: ignore[arg-type]
            mirror.reshape(MAP_HEIGHT, MAP_WIDTH, 3),
        )

    def above(self, normal: DoubleArray, least: float = 0.35) -> DoubleArray:
        """Returns the key direction, raised to at least `least` above a support with this normal."""
        missing = least - float(self.direction @ normal)
        if missing <= 0:
            return self.direction
        raised = self.direction + missing * 1.2 * normal
        return raised / np.linalg.norm(raised)


def light_from_photo(image: FloatArray, spot_px: tuple[float, float], radius_px: float) -> Light:
    """Reads the light from a picture (h, w, 3) sRGB 0..1; exposure also from the spot's surroundings."""
    small = cv2.resize(image, (136, 90), interpolation=cv2.INTER_AREA)
    lin = linear_from_srgb(small)
    luma = lin @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    low, middle, high = (float(np.percentile(luma, q)) for q in (25, 50, 97))
    bright = lin[(luma >= np.percentile(luma, 88)) & (small.max(-1) < 0.985)]
    dark = lin[luma <= max(low, 1e-4)]
    return Light(
        direction=_direction(luma),
        key=_tinted(bright.mean(0) if len(bright) else np.ones(3), 0.25),
        ambient=_tinted(dark.mean(0) + 0.004, 0.25),
        ratio=float(np.clip(0.9 * (high / max(middle, 1e-3) - 1), 1.8, 3.2)),
        exposure=_exposure(image, luma, spot_px, radius_px),
        mirror=_mirror(image),
    )


def _direction(luma: FloatArray) -> DoubleArray:
    """Fits the blurred log brightness by a plane: bright sides are where the light comes from."""
    soft = cv2.GaussianBlur(np.log(luma + 0.01), (0, 0), 5.0)
    h, w = soft.shape
    v, u = np.meshgrid(np.linspace(-1, 1, h), np.linspace(-1, 1, w), indexing="ij")
    basis = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], 1)
    slope = np.linalg.lstsq(basis, soft.ravel().astype(np.float64), rcond=None)[0]
    x, up = np.clip(0.8 * slope[0], -0.8, 0.8), np.clip(0.55 - 0.4 * slope[1], 0.15, 0.9)
    # A light straight behind the viewer flattens every form and hides its shadow: keep it to one side.
    x = x if abs(x) > _ASIDE else np.copysign(_ASIDE, x if x != 0 else -1.0)
    direction = np.array([x, -up, -0.62])
    return direction / np.linalg.norm(direction)


def _tinted(color: DoubleArray, strength: float) -> DoubleArray:
    """Returns a colour of mean 1: the hue of `color`, mostly desaturated."""
    c = np.sqrt(np.maximum(np.asarray(color, np.float64), 1e-4))
    c = 1 + strength * (c / c.mean() - 1)
    return c / c.mean()


def _exposure(image: FloatArray, luma: FloatArray, spot_px: tuple[float, float], radius_px: float) -> float:
    h, w = image.shape[:2]
    x0, y0 = (int(max(c - radius_px, 0)) for c in spot_px)
    x1, y1 = int(min(spot_px[0] + radius_px, w)), int(min(spot_px[1] + radius_px, h))
    patch = image[y0 : max(y1, y0 + 1) : 3, x0 : max(x1, x0 + 1) : 3]
    local = float((linear_from_srgb(patch) @ np.array([0.2126, 0.7152, 0.0722], np.float32)).mean())
    local, world = local / 0.32, float(np.percentile(luma, 92)) / 0.62
    return float(np.clip(max(0.5 * local + 0.5 * world, 0.75 * local, 0.75 * world), 0.55, 1.5))


def _mirror(image: FloatArray) -> ByteArray:
    small = cv2.resize(image[:, ::-1], (MAP_WIDTH, MAP_HEIGHT), interpolation=cv2.INTER_AREA)
    return np.round(np.clip(small, 0, 1) * 255).astype(np.uint8)


class Environment:
    """The mirror-ball map at three roughnesses, with the contrast from above to below it needs."""

    def __init__(self, light: Light, bounce: DoubleArray) -> None:
        lin = linear_from_srgb(np.asarray(light.mirror / 255, np.float32))
        big = cv2.resize(lin, (4 * MAP_WIDTH, 4 * MAP_HEIGHT), interpolation=cv2.INTER_CUBIC)
        blurs = [cv2.GaussianBlur(big, (0, 0), 4 * s, borderType=cv2.BORDER_REPLICATE) for s in _BLURS]
        self._maps = np.stack(blurs)
        self._key = (light.exposure * light.key).astype(np.float32)
        self._bounce = bounce.astype(np.float32)

    def __call__(self, direction: FloatArray, rough: FloatArray, up: DoubleArray) -> FloatArray:
        """Returns (n, 3) linear radiance seen along directions (n, 3), camera axes."""
        h, w = self._maps.shape[1:3]
        column = np.clip((0.5 + 0.5 * direction[:, 0]) * w, 0, w - 1).astype(np.int32)
        row = np.clip((0.5 + 0.5 * direction[:, 1]) * h, 0, h - 1).astype(np.int32)
        pick = np.clip(rough * 4.0, 0, 1.999)
        t = (pick - np.floor(pick))[:, None].astype(np.float32)
        index = pick.astype(np.int32)
        seen = self._maps[index, row, column] * (1 - t) + self._maps[index + 1, row, column] * t
        rise = direction @ up.astype(np.float32)
        skyward = np.clip(0.5 + 0.8 * rise, 0, 1)[:, None]
        gray = seen.mean(1, keepdims=True)
        seen = seen + 0.65 * skyward * (gray * self._key / self._key.mean() - seen)
        s = np.clip((rise + 0.2) / 1.1, 0, 1)
        gain = (0.22 + 1.5 * s * s * (3 - 2 * s))[:, None]
        below = np.clip(-1.6 * rise + 0.1, 0, 1)[:, None]
        return np.asarray(seen * gain * (1 - below) + 0.55 * self._bounce * below, np.float32)
