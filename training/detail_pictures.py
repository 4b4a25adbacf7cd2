"""Endless sharp pictures that the built-in detail network learns from; no photograph among them.

    kind (leaves, shapes, strokes, text, facade, blobs, material) x2-3, joined along a random outline
        -> shading, defocus of one side, colour -> (n, n, 3) uint8

The only files read are the project's own: its drawn demo picture and its material tiles.
"""

import math
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from wzviewer.worker.models.builtin.detail.library import INT8_PER_DEVIATION, TileLibrary
from wzviewer.worker.models.builtin.detail.noise import fractal
from wzviewer.worker.models.builtin.detail.tiles import TILE_MAKERS

FloatArray = NDArray[np.float32]
Generator = np.random.Generator
SIDE_PX = 640
MEADOW = Path(__file__).parents[1] / "assets" / "meadow.png"
FONTS = (
    cv2.FONT_HERSHEY_SIMPLEX,
    cv2.FONT_HERSHEY_DUPLEX,
    cv2.FONT_HERSHEY_COMPLEX,
    cv2.FONT_HERSHEY_TRIPLEX,
    cv2.FONT_HERSHEY_SCRIPT_COMPLEX,
    cv2.FONT_HERSHEY_TRIPLEX | cv2.FONT_ITALIC,
)
LETTERS = "ABCDEFGHIJKLMNOPRSTUVWXYZabcdefghijklmnoprstuvwxyz0123456789&?!"


class Pictures:
    """The maker; keeps tiles and noise fields, so that a picture takes about 0.1 s."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        library = TileLibrary()
        self.tiles = [library.tile(name).astype(np.float32) / INT8_PER_DEVIATION for name in TILE_MAKERS]
        self.noises = [
            fractal(SIDE_PX, slope, self.random) for slope in (0.6, 0.9, 1.2, 1.5, 1.8, 2.1) for _ in range(3)
        ]
        self.meadow = np.ascontiguousarray(cv2.imread(str(MEADOW))[..., ::-1])
        self.kinds: tuple[tuple[float, Callable[[], FloatArray]], ...] = (
            (0.18, self.leaves), (0.14, self.shapes), (0.2, self.strokes), (0.06, self.text),
            (0.1, self.facade), (0.1, self.blobs), (0.16, self.material), (0.06, self.branches),
        )  # fmt: skip

    def picture(self) -> NDArray[np.uint8]:
        """Returns one ``(n, n, 3)`` picture, sRGB."""
        r = self.random
        if r.random() < 0.05:
            return self._meadow_piece()
        canvas = self._any()
        for _ in range(int(r.choice(3, p=(0.45, 0.4, 0.15)))):
            other = self._any()
            if r.random() < 0.3:
                sigma = math.exp(r.uniform(0.5, 3.2))
                canvas = cv2.GaussianBlur(canvas, (0, 0), sigma)
            mask = self._outline()
            canvas += mask[..., None] * (other - canvas)
        light = 1 + r.uniform(0, 0.35) * self._noise(2.0)[..., None]
        canvas = 0.5 + (canvas * light - 0.5) * r.uniform(0.6, 1.25) + r.normal(0, 0.06)
        return (np.clip(canvas, 0, 1) * 255 + 0.5).astype(np.uint8)

    def _any(self) -> FloatArray:
        shares = np.array([share for share, _ in self.kinds])
        return self.kinds[self.random.choice(len(shares), p=shares / shares.sum())][1]()

    def _meadow_piece(self) -> NDArray[np.uint8]:
        r = self.random
        size = int(SIDE_PX * r.uniform(0.9, 1.12))
        x, y = r.integers(0, self.meadow.shape[1] - size + 1), r.integers(0, self.meadow.shape[0] - size + 1)
        return cv2.resize(
            self.meadow[y : y + size, x : x + size], (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA
        )

    # ---- colours and fields

    def _noise(self, slope: float) -> FloatArray:
        """A fractal field of unit deviation, shifted and turned at random."""
        r = self.random
        near = min(range(6), key=lambda index: abs((0.6, 0.9, 1.2, 1.5, 1.8, 2.1)[index] - slope))
        field = self.noises[3 * near + int(r.integers(3))]
        field = np.roll(field, r.integers(0, SIDE_PX, 2), (0, 1))
        return np.ascontiguousarray(np.rot90(field, int(r.integers(4))))

    def _palette(self, count: int) -> FloatArray:
        """Colours of one family: a base in HSV, natural saturation, a wide range of lightness."""
        r = self.random
        hue = r.uniform(0, 360) + r.normal(0, r.uniform(4, 60), count)
        saturation = np.clip(r.beta(1.6, 2.2) + r.normal(0, 0.12, count), 0, 1)
        value = np.clip(r.uniform(0.25, 0.8) + r.normal(0, r.uniform(0.05, 0.28), count), 0.02, 1)
        hsv = np.stack([hue % 360, saturation, value], 1).astype(np.float32)[None]
        colours: FloatArray = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0]
        return colours

    def _ground(self, contrast: float = 0.15) -> FloatArray:
        """A plain, softly varying colour field."""
        a, b = self._palette(2)
        field = np.clip(0.5 + contrast * self._noise(self.random.uniform(1.2, 2.1)), 0, 1)[..., None]
        return (a + (b - a) * field).astype(np.float32)

    def _outline(self) -> FloatArray:
        """A sharp mask: half planes, discs, rough or smooth islands."""
        r, n = self.random, SIDE_PX
        y, x = np.mgrid[0:n, 0:n].astype(np.float32)
        kind = r.integers(4)
        if kind == 0:
            angle = r.uniform(0, 2 * math.pi)
            signed = (x - n / 2) * math.cos(angle) + (y - n / 2) * math.sin(angle) + r.normal(0, 80)
        elif kind == 1:
            signed = r.uniform(80, 300) - np.hypot(
                x - r.uniform(0, n), (y - r.uniform(0, n)) * r.uniform(0.6, 1.6)
            )
        else:
            signed = 60 * (self._noise(r.choice((1.5, 1.8, 2.1))) + r.normal(0, 0.5))
        if r.random() < 0.4:
            signed = signed + r.uniform(1, 8) * self._noise(0.9)
        return np.clip(signed * np.float32(1 / r.uniform(0.8, 1.6)) + 0.5, 0, 1).astype(np.float32)

    # ---- kinds

    def leaves(self) -> FloatArray:
        """Dead leaves (Matheron): opaque things of all sizes, one over the other, each shaded."""
        r = self.random
        canvas, colours = self._ground(), self._palette(24)
        power, smallest = r.uniform(1.6, 2.6), r.uniform(2, 8)
        count = int(r.uniform(150, 900))
        sizes = smallest * (1 - r.random(count)) ** (-1 / power)
        for size in np.minimum(sizes, 160):
            outline = self._body(size) + r.uniform(0, SIDE_PX, 2)
            _fill(canvas, outline, colours[r.integers(24)] * r.uniform(0.8, 1.2))
            if r.random() < 0.35 and size > 5:  # a lit half
                _fill(canvas, outline[: len(outline) // 2 + 1], colours[r.integers(24)])
        return canvas * (1 + np.float32(r.uniform(0, 0.06)) * self._noise(0.9)[..., None])

    def _body(self, size: float) -> FloatArray:
        """A random closed outline around the origin: ellipse, polygon, leaf, or wavy blob."""
        r = self.random
        kind, turn, stretch = r.integers(4), r.uniform(0, 2 * math.pi), math.exp(r.normal(0, 0.5))
        t = np.linspace(0, 2 * math.pi, 48, endpoint=False)
        if kind == 0:
            radius = np.ones_like(t)
        elif kind == 1:
            t = np.sort(r.uniform(0, 2 * math.pi, int(r.integers(3, 8))))
            radius = np.ones_like(t)
        elif kind == 2:
            radius, stretch = np.abs(np.sin(t)) ** 0.4 * 0.4 + 0.6 * np.abs(np.cos(t)) ** 3, 2.2
        else:
            radius = 1 + sum(r.normal(0, 0.22) * np.cos(k * t + r.uniform(0, 6.3)) for k in range(2, 7))
        points = np.stack([radius * np.cos(t) * stretch, radius * np.sin(t) / stretch], 1) * size
        c, s = math.cos(turn), math.sin(turn)
        return (points @ np.array([[c, s], [-s, c]])).astype(np.float32)

    def shapes(self) -> FloatArray:
        """Few big smooth things with gradients inside: man-made objects, petals, fruit."""
        r = self.random
        canvas = self._ground()
        for _ in range(int(r.integers(4, 22))):
            mask = np.zeros((SIDE_PX, SIDE_PX), np.float32)
            _fill(mask, self._body(math.exp(r.uniform(2.6, 5.3))) + r.uniform(0, SIDE_PX, 2), 1.0)
            inside = self._ground(r.uniform(0, 0.4))
            if r.random() < 0.3:
                inside = (
                    inside + np.float32(r.uniform(0.02, 0.1)) * self._noise(r.uniform(0.6, 1.2))[..., None]
                )
            canvas += mask[..., None] * (inside - canvas)
            if r.random() < 0.4:
                _stroke(canvas, self._curve(200), self._palette(1)[0], int(r.integers(1, 6)))
        return canvas

    def _curve(self, length: float) -> FloatArray:
        r = self.random
        t = np.linspace(0, 1, 24)
        angle = r.uniform(0, 2 * math.pi) + r.normal(0, 1.2) * t + r.normal(0, 0.8) * t * t
        steps = np.stack([np.cos(angle), np.sin(angle)], 1) * length / 24
        return (np.cumsum(steps, 0) + r.uniform(0, SIDE_PX, 2)).astype(np.float32)

    def strokes(self) -> FloatArray:
        """Fur, grass, hair, needles: many tapering strokes along a smooth direction field."""
        r = self.random
        canvas, colours = self._ground(), self._palette(32)
        angles = r.uniform(0, 2 * math.pi) + self._noise(2.1) * r.uniform(0.2, 1.2)
        width, length = math.exp(r.uniform(-0.2, 2.0)), math.exp(r.uniform(2.8, 4.6))
        spread = r.uniform(0.03, 0.5)
        count = int(min(3800, 2.2 * SIDE_PX**2 / (width * length)))
        start = r.uniform(-20, SIDE_PX + 20, (count, 2))
        t = np.linspace(0, 1, 6)
        for index in range(count):
            x, y = start[index]
            angle = angles[int(np.clip(y, 0, SIDE_PX - 1)), int(np.clip(x, 0, SIDE_PX - 1))] + r.normal(
                0, spread
            )
            bent = angle + r.normal(0, 0.5) * t
            line = np.stack(
                [x + np.cumsum(np.cos(bent)) * length / 6, y + np.cumsum(np.sin(bent)) * length / 6], 1
            )
            tone = (0.75 + 0.5 * index / count) * r.uniform(0.8, 1.2)
            if width < 1.6:
                _stroke(canvas, line, colours[index % 32] * tone, 1)
            else:
                side = np.stack([-np.sin(bent), np.cos(bent)], 1) * (width / 2 * (1 - t**2))[:, None]
                _fill(canvas, np.concatenate([line + side, (line - side)[::-1]]), colours[index % 32] * tone)
        return canvas

    def branches(self) -> FloatArray:
        """Veins, twigs, cracks: lines that split and thin."""
        r = self.random
        canvas = self._ground(0.25)
        colour = self._palette(1)[0]
        stack = [(r.uniform(0, SIDE_PX, 2), r.uniform(0, 6.3), math.exp(r.uniform(1, 2.6))) for _ in range(6)]
        for _ in range(700):
            if not stack:
                break
            place, angle, width = stack.pop(0)
            angle += r.normal(0, 0.25)
            end = place + np.array([math.cos(angle), math.sin(angle)]) * r.uniform(8, 40)
            _stroke(canvas, np.stack([place, end]), colour, max(1, round(width)))
            if width > 0.7:
                stack.append((end, angle, width * 0.95))
                if r.random() < 0.45:
                    stack.append((end, angle + r.choice((-1, 1)) * r.uniform(0.4, 1.1), width * 0.6))
        return canvas

    def text(self) -> FloatArray:
        """Lines of letters and flat graphics."""
        r = self.random
        canvas = np.empty((SIDE_PX, SIDE_PX, 3), np.uint8)
        canvas[:] = self._palette(1)[0] * 255
        for _ in range(int(r.integers(3, 26))):
            words = "".join(r.choice(list(LETTERS), int(r.integers(3, 16))))
            where = (int(r.integers(-40, SIDE_PX - 60)), int(r.integers(0, SIDE_PX)))
            size = math.exp(r.uniform(-0.4, 1.6))
            colour = _scalar(self._palette(1)[0] * 255)
            cv2.putText(canvas, words, where, FONTS[r.integers(len(FONTS))], size, colour,
                        int(max(1, round(size * r.uniform(1, 4)))), cv2.LINE_AA)  # fmt: skip
        flat = canvas.astype(np.float32) / 255
        return self._tilted(flat) if r.random() < 0.6 else flat

    def facade(self) -> FloatArray:
        """Bricks, windows, planks, tiles, seen at a slant."""
        r = self.random
        canvas, colours = self._ground(), self._palette(12)
        width, height = math.exp(r.uniform(2.2, 4.6)), math.exp(r.uniform(2.0, 4.4))
        joint = r.uniform(0.5, 0.12 * min(width, height) + 1.5)
        for row in range(int(SIDE_PX / height) + 1):
            shift = (row % 2) * width / 2 if r.random() < 0.95 else 0
            for column in range(-1, int(SIDE_PX / width) + 1):
                x, y = column * width + shift, row * height
                box = np.array(
                    [
                        [x, y],
                        [x + width - joint, y],
                        [x + width - joint, y + height - joint],
                        [x, y + height - joint],
                    ]
                )
                _fill(canvas, (box + r.normal(0, 0.4, (4, 2))).astype(np.float32), colours[r.integers(12)])
        canvas = canvas * (1 + np.float32(r.uniform(0, 0.12)) * self._noise(r.uniform(0.6, 1.2))[..., None])
        return self._tilted(canvas)

    def _tilted(self, canvas: FloatArray) -> FloatArray:
        r, n = self.random, SIDE_PX
        square = np.array([[0, 0], [n, 0], [n, n], [0, n]], np.float32)
        centred = (square - n / 2) * r.uniform(1.0, 1.5)
        turn = r.normal(0, 0.6)
        c, s = math.cos(turn), math.sin(turn)
        target = centred @ np.array([[c, s], [-s, c]]) + n / 2 + r.normal(0, 60, (4, 2))
        matrix = cv2.getPerspectiveTransform(square, target.astype(np.float32))
        return cv2.warpPerspective(
            canvas, matrix, (n, n), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101
        )

    def blobs(self) -> FloatArray:
        """Rounded bodies with shading, highlight and rim: berries, pebbles, drops, glossy plastic."""
        r, n = self.random, SIDE_PX
        canvas = self._ground()
        y, x = np.mgrid[0:n, 0:n].astype(np.float32)
        light = np.array([r.normal(), r.normal(), 1.2])
        light /= np.linalg.norm(light)
        half = light + np.array([0, 0, 1.0])
        half /= np.linalg.norm(half)
        for _ in range(int(r.integers(3, 40))):
            radius = math.exp(r.uniform(2.2, 4.8))
            cx, cy = r.uniform(0, n, 2)
            x0, x1 = int(max(cx - radius - 2, 0)), int(min(cx + radius + 2, n))
            y0, y1 = int(max(cy - radius - 2, 0)), int(min(cy + radius + 2, n))
            if x1 <= x0 or y1 <= y0:
                continue
            dx, dy = (x[y0:y1, x0:x1] - cx) / radius, (y[y0:y1, x0:x1] - cy) / radius
            z = np.sqrt(np.clip(1 - dx * dx - dy * dy, 0, 1))
            mask = np.clip((1 - np.hypot(dx, dy)) * radius + 0.5, 0, 1)[..., None]
            diffuse = np.clip(dx * light[0] + dy * light[1] + z * light[2], 0, 1)
            shine = np.clip(dx * half[0] + dy * half[1] + z * half[2], 0, 1) ** r.uniform(8, 160)
            body = (
                self._palette(1)[0] * (0.25 + 0.85 * diffuse[..., None])
                + r.uniform(0, 0.8) * shine[..., None]
            )
            piece = canvas[y0:y1, x0:x1]
            piece += mask * (body - piece)
        return canvas

    def material(self) -> FloatArray:
        """One of the project's tiles, enlarged by up to three, as light on a soft colour field."""
        r = self.random
        tile = np.rot90(self.tiles[r.integers(len(self.tiles))], int(r.integers(4)))
        side = int(SIDE_PX / r.uniform(0.85, 3))
        tile = np.roll(tile, r.integers(0, 768, 2), (0, 1))[:side, :side]
        plane = cv2.resize(np.ascontiguousarray(tile), (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_CUBIC)
        amount = np.float32(r.uniform(0.03, 0.28))
        ground = self._ground(0.3)
        tint = (self._palette(1)[0] - 0.5) * r.uniform(0, 0.5)
        return ground * (1 + amount * plane[..., None]) + amount * plane[..., None] * tint


def _fill(canvas: FloatArray, outline: FloatArray, colour: FloatArray | float) -> None:
    points = np.round(outline * 16).astype(np.int32)
    cv2.fillPoly(canvas, [points], _scalar(colour), lineType=cv2.LINE_AA, shift=4)


def _stroke(canvas: FloatArray, line: FloatArray, colour: FloatArray | float, width: int) -> None:
    cv2.polylines(
        canvas, [np.round(line * 16).astype(np.int32)], False, _scalar(colour), width, cv2.LINE_AA, 4
    )


def _scalar(colour: FloatArray | float) -> tuple[float, ...]:
    return tuple(float(v) for v in np.atleast_1d(np.asarray(colour)))
