"""The kernels of `strokes`: what a leaf, a face of stone, a mark of a brush and a hair look like from above.

A stroke is ``(x, y, cos, sin, half length, half width, bend, chance)`` in px of the new image.  It is laid
into two maps: `top`, which stroke is seen in a pixel, and `shade`, the light on it relative to its colour.
So its colour can be found afterwards.  Light falls from the upper left, as on the `tiles`.
"""

import math

import numpy as np
from numba import njit

from wzviewer.core.types import FloatArray, IntArray

LEAF, MARK, FACET = 0, 1, 2
LIGHT_X, LIGHT_Y = -0.6, -0.8
PIECE_PX = 3.0  # a hair is drawn in straight pieces
SHADE_PX, SHADE = 3.0, 0.12  # beside a hair
ALIKE = 50.0
"""In squared grey levels: what differs by less fits, or strokes in soft shade swirled along its contours."""
SHADOW = 0.42
"""How much light a stroke takes from what lies just behind it."""


@njit(cache=True, nogil=True)
def sampled(image: FloatArray, x: float, y: float, channel: int) -> float:
    """Returns the bilinear value of ``(h, w, 3)`` at a place in px; pixel centres are at .5."""
    rows, columns = image.shape[:2]
    x = min(max(x - 0.5, 0.0), columns - 1.001)
    y = min(max(y - 0.5, 0.0), rows - 1.001)
    i, j = int(x), int(y)
    fx, fy = x - i, y - j
    upper = image[j, i, channel] * (1 - fx) + image[j, i + 1, channel] * fx
    lower = image[j + 1, i, channel] * (1 - fx) + image[j + 1, i + 1, channel] * fx
    return upper * (1 - fy) + lower * fy


@njit(cache=True, nogil=True)
def fit(
    seen: FloatArray,
    sites: FloatArray,
    angles: FloatArray,
    halves: FloatArray,
    slim: FloatArray,
    first: int,
    last: int,
    chosen: FloatArray,
) -> None:
    """Writes per site the candidate stroke under which the picture is the most of one colour.

    Args:
        seen: ``(h, w, 3)`` the observation in grey levels.
        sites: ``(n, 2)`` centres in its px.
        angles: ``(n, k)`` rad.
        halves: ``(n, k)`` half lengths in px of the observation.
        slim: ``(n, k)`` half widths as a share of them.
        first: site to begin with.
        last: one past the last site.
        chosen: ``(n, 6)`` result: angle, half length, half width, mean colour.
    """
    mean = np.zeros(3)
    for s in range(first, last):
        best = 1e30
        for k in range(angles.shape[1]):
            a = halves[s, k]
            b = a * slim[s, k]
            cosine, sine = math.cos(angles[s, k]), math.sin(angles[s, k])
            count, squares = 0.0, 0.0
            mean[:] = 0
            for i in range(-2, 3):
                u = 0.42 * i
                weight = 1 - u * u
                for j in range(-1, 2):
                    v = 0.62 * j * weight
                    x = sites[s, 0] + cosine * u * a - sine * v * b
                    y = sites[s, 1] + sine * u * a + cosine * v * b
                    count += weight
                    for c in range(3):
                        value = sampled(seen, x, y, c)
                        mean[c] += weight * value
                        squares += weight * value * value
            for c in range(3):
                mean[c] /= count
            unlike = squares / count - mean[0] ** 2 - mean[1] ** 2 - mean[2] ** 2
            score = max(unlike, ALIKE) / a**1.2
            if score < best:
                best = score
                chosen[s, 0], chosen[s, 1], chosen[s, 2] = angles[s, k], a, b
                chosen[s, 3], chosen[s, 4], chosen[s, 5] = mean[0], mean[1], mean[2]


@njit(cache=True, nogil=True)
def chance_of(chance: float, k: int) -> float:
    """Returns a number in 0..1 that a stroke's own chance and an index determine."""
    value = chance * 61.7 + k * 0.7548776662
    value = (value - math.floor(value)) * 91.3
    return value - math.floor(value)


@njit(cache=True, nogil=True)
def leaf_at(
    u: float, v: float, a: float, b: float, across: float, along: float, chance: float
) -> tuple[float, float]:
    """Returns how far inside a leaf a place is, in px, and the light on it."""
    t = u + 0.15 * (1 - u * u)
    room = b * (1 - t * t) * (1 + 0.35 * t * t)
    depth = room - abs(v)
    if abs(u) > 1:
        return -math.hypot((abs(u) - 1) * a, v), 1.0
    side = across if v > 0 else -across
    fold = 0.16 if chance > 0.5 else -0.16
    edge = abs(v) / max(room, 1.0)
    light = 1 + fold * side + 0.10 * along * u - 0.12 * edge * edge * side
    rib = max(0.0, 1 - (v / (1.2 + 0.025 * b)) ** 2)
    light += 0.16 * rib * rib * (1 - 0.5 * abs(u))
    phase = a * (0.31 * u - 0.16 * abs(v) / b)
    phase -= math.floor(phase)
    vein = max(0.0, 1 - ((phase - 0.5) / 0.16) ** 2)
    light += 0.06 * vein * vein * min(b / 14, 1.0) - 0.10 * max(0.0, 1 - depth / 1.6)
    return depth, light


@njit(cache=True, nogil=True)
def mark_at(
    u: float, v: float, a: float, b: float, across: float, along: float, chance: float
) -> tuple[float, float]:
    """Returns how far inside a brush's mark a place is, in px, and the light on its ridges."""
    w = v / b
    groove = w * b * 0.9
    cell = math.floor(groove)
    t = groove - cell
    t = t * t * (3 - 2 * t)
    low, high = chance_of(chance, int(cell) + 100), chance_of(chance, int(cell) + 101)
    height = low + (high - low) * t
    ragged = 1 - 0.30 * height * height
    depth = min(b * (1 - 0.12 * u * u) - abs(v), (ragged - abs(u)) * a)
    light = 1 + 0.9 * (high - low) * across * 0.16 + 0.10 * (height - 0.5)
    ridge = max(0.0, 1 - abs(b - abs(v) - 1.6) / 2.4)
    light += 0.20 * ridge * (across if v > 0 else -across)
    return depth, light


@njit(cache=True, nogil=True)
def facet_at(
    u: float, v: float, a: float, b: float, across: float, along: float, chance: float
) -> tuple[float, float]:
    """Returns how far inside a face of broken stone, a convex polygon, a place is, in px, and its light."""
    w = v / b
    wave = 0.05 * math.sin(9 * u + 40 * chance) + 0.04 * math.sin(17 * w + 11 * u + 70 * chance)
    depth = 1e9
    for k in range(6):
        angle = (k + 0.7 * (chance_of(chance, k) - 0.5)) * (math.pi / 3)
        away = 0.70 + 0.3 * chance_of(chance, k + 7) + wave - math.cos(angle) * u - math.sin(angle) * w
        depth = min(depth, away)
    tilt_x, tilt_y = chance_of(chance, 20) - 0.5, chance_of(chance, 21) - 0.5
    light = 1 + 0.34 * (tilt_x * along + tilt_y * across) + 0.22 * (tilt_x * u + tilt_y * w)
    rim = max(0.0, 1 - depth * b / 2.5)
    return depth * b, light + 0.14 * rim * (u * along + w * across)


@njit(cache=True, nogil=True)
def lay(
    kind: int, strokes: FloatArray, offset: int, top: IntArray, shade: FloatArray, first: int, last: int
) -> None:
    """Lays strokes over one another, in their order, into the rows from `first` to before `last`.

    Args:
        kind: `LEAF`, `MARK` or `FACET`.
        strokes: ``(n, 8)``, see the module.
        offset: number of the first stroke.
        top: ``(H, W)`` i32, number of the stroke that is seen.
        shade: ``(H, W)`` f32, the light on it.
        first: row.
        last: row.
    """
    width = top.shape[1]
    for s in range(len(strokes)):
        cx, cy, cosine, sine, a, b, bend, chance = strokes[s]
        reach = 0.10 * b + 3.0
        reach_x = abs(cosine) * a + abs(sine) * (b + abs(bend)) + reach
        reach_y = abs(sine) * a + abs(cosine) * (b + abs(bend)) + reach
        along, across = LIGHT_X * cosine + LIGHT_Y * sine, LIGHT_Y * cosine - LIGHT_X * sine
        for y in range(max(int(cy - reach_y), first), min(int(cy + reach_y) + 1, last)):
            for x in range(max(int(cx - reach_x), 0), min(int(cx + reach_x) + 1, width)):
                dx, dy = x + 0.5 - cx, y + 0.5 - cy
                u = (cosine * dx + sine * dy) / a
                if abs(u) > 1.3:
                    continue
                v = cosine * dy - sine * dx - bend * (u * u - 0.35)
                if abs(v) > b + reach:
                    continue
                if kind == LEAF:
                    depth, light = leaf_at(u, v, a, b, across, along, chance)
                elif kind == FACET:
                    depth, light = facet_at(u, v, a, b, across, along, chance)
                else:
                    depth, light = mark_at(u, v, a, b, across, along, chance)
                if depth > 0:
                    top[y, x] = offset + s
                    shade[y, x] = light
                elif depth > -reach:
                    near = 1 + depth / reach
                    behind = 1.0 if dx * LIGHT_X + dy * LIGHT_Y < 0.35 * b else 0.35
                    shade[y, x] *= 1 - SHADOW * behind * near * near


@njit(cache=True, nogil=True)
def comb(
    hairs: FloatArray,
    along_x: FloatArray,
    along_y: FloatArray,
    seen: FloatArray,
    canvas: FloatArray,
    cover: FloatArray,
    first: int,
    last: int,
) -> None:
    """Draws hairs along a direction field, in their order, into the rows from `first` to before `last`.

    Args:
        hairs: ``(n, 6)``: root x and y, length and width in px of the new image, brightness, stray in rad.
        along_x: ``(rows, columns)`` unit vectors of the field.
        along_y: the same.
        seen: ``(h, w, 3)`` the observation in grey levels.
        canvas: ``(H, W, 3)`` result in grey levels.
        cover: ``(H, W)`` result, 1 where there is a hair.
        first: row.
        last: row.
    """
    height, width = cover.shape
    rows, columns = along_x.shape
    grow = np.float32(width / seen.shape[1])
    root, hue = np.zeros(3), np.zeros(3)
    for s in range(len(hairs)):
        x, y, length, wide, bright, stray = hairs[s]
        if y < first - length or y > last + length:
            continue
        for c in range(3):
            root[c] = sampled(seen, x / grow, y / grow, c)
        vx, vy = 0.0, 1.0  # coats lie downwards
        pieces = int(length / PIECE_PX)
        for k in range(pieces):
            i = min(max(int(x * columns / width), 0), columns - 1)
            j = min(max(int(y * rows / height), 0), rows - 1)
            turn = stray * (1 + 0.8 * math.sin(0.09 * k + 40 * stray))
            cosine, sine = math.cos(turn), math.sin(turn)
            dx = cosine * along_x[j, i] - sine * along_y[j, i]
            dy = sine * along_x[j, i] + cosine * along_y[j, i]
            if dx * vx + dy * vy < 0:
                dx, dy = -dx, -dy
            vx, vy = dx, dy
            t = k / pieces
            half = 0.5 * wide * min(1.0, 2.5 * (1 - t), 0.3 + 5 * t) + 0.3
            gloss = max(0.0, 1 - ((t - 0.35) / 0.25) ** 2)
            for c in range(3):
                hue[c] = bright * (0.45 * root[c] + 0.55 * sampled(seen, x / grow, y / grow, c))
            piece(x, y, dx, dy, half, gloss, hue, canvas, cover, first, last)
            x, y = x + PIECE_PX * dx, y + PIECE_PX * dy


@njit(cache=True, nogil=True)
def piece(
    x: float,
    y: float,
    dx: float,
    dy: float,
    half: float,
    gloss: float,
    hue: FloatArray,
    canvas: FloatArray,
    cover: FloatArray,
    first: int,
    last: int,
) -> None:
    """Draws a short straight piece of a hair, round and lit, with a little shade beside it; see `comb`."""
    facing = 1.0 if LIGHT_Y * dx - LIGHT_X * dy > 0 else -1.0
    reach = half + SHADE_PX
    nx, ny = x + PIECE_PX * dx, y + PIECE_PX * dy
    for py in range(max(int(min(y, ny) - reach), first), min(int(max(y, ny) + reach) + 1, last)):
        for px in range(max(int(min(x, nx) - reach), 0), min(int(max(x, nx) + reach) + 1, canvas.shape[1])):
            ox, oy = px + 0.5 - x, py + 0.5 - y
            u, v = ox * dx + oy * dy, oy * dx - ox * dy
            if u < -0.5 or u >= PIECE_PX + 0.5:
                continue
            depth = half - abs(v)
            if depth < 0.5 and not 0 <= u < PIECE_PX:  # a rim that is drawn twice is beaded
                continue
            if depth > -0.5:
                share, w = min(depth + 0.5, 1.0), max(min(v / half, 1.0), -1.0)
                light = 0.80 + 0.34 * (1 - w * w) * (1 + 0.25 * gloss) + 0.16 * w * facing
                for c in range(3):
                    canvas[py, px, c] += share * (hue[c] * light - canvas[py, px, c])
                cover[py, px] = max(cover[py, px], share)
            elif v * facing < 0 and depth > -SHADE_PX:
                for c in range(3):
                    canvas[py, px, c] *= 1 - SHADE * (1 + depth / SHADE_PX)
