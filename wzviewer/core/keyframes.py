"""Camera paths through keyframes: smooth in log focal length, so that a zoom of x8^4 is even.

Every piece between two keys is the flight of `navigation.interpolated` (a straight zoom about the
common pixel, or the arc of van Wijk and Nuij), run through at a changing speed and bent a little, so
that speed and direction go on unbroken through a key::

    key 0 ──── piece 0 ──── key 1 ──── piece 1 ──── key 2
               speed s'(t): a cubic             the motion at a key: the weighted mean of the two
               bend: cubics that vanish         pieces' own (Catmull-Rom on uneven times), limited
               at both keys                     so that no zoom overshoots (Fritsch and Carlson)

A motion is a vector (9,): log focal length, shift in picture widths (2), turn in rad (3), drift of the
focus in units of its depth (3); the last six are exactly zero between equal poses, so a pure zoom stays
one at any depth.  Speeds are continuous, accelerations are bounded and jump at keys.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wzviewer.core import navigation
from wzviewer.core.camera import Camera
from wzviewer.core.types import DoubleArray

Pace = Literal["flow", "stop", "corner"]
SECONDS_LIMIT = (0.05, 600.0)  # of a piece
MAX_KEYS = 500
STEP = 1.0 / 1024.0  # of a piece, for the motion at its ends
SPEED_LIMIT = 3.0  # of the slower neighbour: above, a cubic overshoots
PARTS = (slice(0, 1), slice(1, 3), slice(3, 6), slice(6, 9))
STILL = np.zeros(9)
NEAREST = 1e-12  # world units, of what a piece is about
ROUNDING_S = 1e-9  # of times that are sums


@dataclass(frozen=True, eq=False)
class Key:
    """A view that the path goes through.

    Attributes:
        camera: C there.
        focus: (3,) world point that is looked at.
        seconds: until the next key; of the last one, back to the first, where the path is a loop.
        pace: goes through it smoothly, stops, or changes direction at once.
    """

    camera: Camera
    focus: DoubleArray
    seconds: float = 2.0
    pace: Pace = "flow"


@dataclass(frozen=True, eq=False)
class KeyPath:
    """Keys in order.

    Attributes:
        keys: the views.
        is_loop: whether the last key leads to the first.
    """

    keys: tuple[Key, ...] = ()
    is_loop: bool = False

    @property
    def num_pieces(self) -> int:
        """Pieces between keys."""
        count = len(self.keys)
        return (count if self.is_loop else count - 1) if count > 1 else 0

    @property
    def duration_s(self) -> float:
        """Length, s."""
        return sum(key.seconds for key in self.keys[: self.num_pieces])

    @property
    def times_s(self) -> tuple[float, ...]:
        """When each key is reached, s."""
        times = [0.0]
        for key in self.keys[:-1]:
            times.append(times[-1] + key.seconds)
        return tuple(times[: len(self.keys)])

    def sized(self, width: int, height: int) -> "KeyPath":
        """Returns the path at another size of the picture, px; what fits is kept whole."""
        return replace(self, keys=tuple(_sized(key, width, height) for key in self.keys))

    def lasting(self, duration_s: float) -> "KeyPath":
        """Returns the path run through in another time."""
        ratio = duration_s / self.duration_s if self.duration_s > 0 else 1.0
        return replace(self, keys=tuple(replace(k, seconds=k.seconds * ratio) for k in self.keys))


class KeyTrack:
    """A path that can be asked for the camera of any moment.

    Args:
        path: at least one key.
        size: width and height of all pictures, px.
    """

    def __init__(self, path: KeyPath, size: tuple[int, int]) -> None:
        self.path = path.sized(*size)
        self._pieces: dict[int, _Piece] = {}  # made when they are needed: a preview needs three

    def camera_at(self, time_s: float) -> Camera:
        """Returns the camera of a moment; before the start and after the end, the first and the last."""
        index, t = self._place(time_s)
        if index < 0:
            return self.path.keys[0 if t <= 0 else -1].camera
        leaving, arriving = self._motion(index)[1], self._motion(index + 1)[0]
        return self._piece(index).camera_at(t, leaving, arriving)

    def focus_at(self, time_s: float) -> DoubleArray:
        """Returns the world point (3,) that is looked at."""
        index, t = self._place(time_s)
        if index < 0:
            return self.path.keys[0 if t <= 0 else -1].focus
        return self._piece(index).focus

    def cameras(self, fps: float) -> list[Camera]:
        """Returns the camera of every frame of a film.

        The first is that of the first key and the last that of the last one; a loop ends a frame before
        it would begin anew.
        """
        count = max(round(self.path.duration_s * fps), 1)
        steps = count if self.path.is_loop else max(count - 1, 1)
        return [self.camera_at(self.path.duration_s * i / steps) for i in range(count)]

    def _place(self, time_s: float) -> tuple[int, float]:
        """Piece, and fraction of it; piece -1 is before (0) or after (1) all of them."""
        for index, key in enumerate(self.path.keys[: self.path.num_pieces]):
            if -ROUNDING_S <= time_s < key.seconds - ROUNDING_S:
                return index, time_s / key.seconds if time_s > ROUNDING_S else 0.0
            time_s -= key.seconds
        return -1, float(time_s >= -ROUNDING_S and self.path.num_pieces > 0 and not self.path.is_loop)

    def _piece(self, index: int) -> "_Piece":
        """The piece after a key; counts on from the last to the first."""
        index %= self.path.num_pieces
        if index not in self._pieces:
            keys = self.path.keys
            self._pieces[index] = _Piece(keys[index], keys[(index + 1) % len(keys)])
        return self._pieces[index]

    def _motion(self, at: int) -> tuple[DoubleArray, DoubleArray]:
        """Motion per second when arriving at a key, and when leaving it."""
        count = self.path.num_pieces
        at_key = at % len(self.path.keys)
        pace = self.path.keys[at_key].pace
        is_end = not self.path.is_loop and at in (0, count)
        if pace == "stop" or (is_end and pace == "flow"):
            return STILL, STILL
        before, after = self._piece(at - 1), self._piece(at)
        if pace == "corner" or is_end:
            return before.arrival / before.start.seconds, after.departure / after.start.seconds
        through = _through(before, after)
        return through, through


class _Piece:
    """The way from one key to the next, before its ends are fitted to their neighbours."""

    def __init__(self, start: Key, end: Key) -> None:
        self.start, self.end = start, end
        self.is_still = start.camera.key == end.camera.key
        near, far = (start, end) if _fineness(start) < _fineness(end) else (end, start)
        shared = [k.focus for k in (near, far) if _sees(start.camera, k.focus) and _sees(end.camera, k.focus)]
        self.is_free = not shared
        self.focus = shared[0] if shared else start.focus
        self._pivots = [
            k.focus if _sees(start.camera, k.focus) and _sees(end.camera, k.focus) else self.focus
            for k in (start, end)
        ]
        self.departure, self.arrival = self._ends()

    def camera_at(self, t: float, leaving: DoubleArray, arriving: DoubleArray) -> Camera:
        """Returns the camera at a fraction of the time, with given motions per second at the ends."""
        if t <= 0.0 or t >= 1.0 or self.is_still:
            return self.start.camera if t < 1.0 else self.end.camera
        h00_end, h10, h11 = t * t * (3.0 - 2.0 * t), t * (1.0 - t) ** 2, t * t * (t - 1.0)
        first, last = leaving * self.start.seconds, arriving * self.start.seconds
        slow_in, slow_out = _share(first, self.departure), _share(last, self.arrival)
        s = min(max(h00_end + h10 * slow_in + h11 * slow_out, 0.0), 1.0)
        camera = self._base(s)
        if self.is_free:
            return camera
        camera = moved(camera, self._pivots[0], h10 * (first - slow_in * self.departure))
        return moved(camera, self._pivots[1], h11 * (last - slow_out * self.arrival))

    def _base(self, s: float) -> Camera:
        start, end = self.start.camera, self.end.camera
        if self.is_free:
            return _straight(start, end, s)
        return navigation.interpolated(start, end, self.focus, s)

    def _ends(self) -> tuple[DoubleArray, DoubleArray]:
        """Motions at the ends, for s from 0 to 1: one-sided differences of second order."""
        if self.is_still:
            return STILL, STILL
        a, b = self.start.camera, self.end.camera
        pivots = self._pivots if not self.is_free else [self.start.focus, self.end.focus]
        ahead = [motion(a, self._base(i * STEP), pivots[0]) for i in (1, 2)]
        back = [motion(b, self._base(1.0 - i * STEP), pivots[1]) for i in (1, 2)]
        return (4 * ahead[0] - ahead[1]) / (2 * STEP), -(4 * back[0] - back[1]) / (2 * STEP)


def motion(near: Camera, camera: Camera, focus: DoubleArray) -> DoubleArray:
    """Returns how a camera differs from one nearby, (9,): see the module docstring.

    Args:
        near: the camera that is moved from.
        camera: the one moved to, of the same size.
        focus: (3,) world point that the motion is measured at.
    """
    fold = math.log(camera.focal_px / near.focal_px)
    centre = np.array([near.width / 2, near.height / 2])
    before, after = near.project(focus)[:2] - centre, camera.project(focus)[:2] - centre
    shift = (after - before * math.exp(fold)) / near.width
    if np.array_equal(near.camera_from_world, camera.camera_from_world):
        return np.concatenate([[fold], shift, np.zeros(6)])
    p = near.to_camera(focus)
    drift = (camera.to_camera(focus) - p) / p[2]
    return np.concatenate([[fold], shift, navigation.turn_of(camera.rotation @ near.rotation.T), drift])


def moved(camera: Camera, focus: DoubleArray, by: DoubleArray) -> Camera:
    """Returns a camera after a motion (9,); `motion` undoes it."""
    if by[3:].any():
        p, before = camera.to_camera(focus), camera.project(focus)
        rotation = navigation.turned_rotation(camera.rotation, by[3:6])
        camera = replace(
            camera, camera_from_world=navigation.pose_through(rotation, focus, p + p[2] * by[6:])
        )
        camera = navigation.panned(camera, *(before - camera.project(focus))[:2])
    if by[:3].any():
        camera = camera.zoomed(camera.width / 2, camera.height / 2, math.exp(by[0]))
        camera = navigation.panned(camera, by[1] * camera.width, by[2] * camera.width)
    return camera


def _through(before: _Piece, after: _Piece) -> DoubleArray:
    """The motion per second through a key that is not stopped at."""
    t_in, t_out = before.start.seconds, after.start.seconds
    came, goes = before.arrival / t_in, after.departure / t_out
    mean = (t_out * came + t_in * goes) / (t_in + t_out)
    through = np.zeros(9)
    for part in PARTS:
        length = float(np.linalg.norm(mean[part]))
        limit = SPEED_LIMIT * min(float(np.linalg.norm(came[part])), float(np.linalg.norm(goes[part])))
        through[part] = mean[part] * min(1.0, limit / length) if length > 0 else 0.0
    if came[0] * goes[0] <= 0:
        through[0] = 0.0
    return through


def _share(wanted: DoubleArray, own: DoubleArray) -> float:
    """How much of a piece's own motion is in a wanted one: its speed there, 0 to 3."""
    square = float(own @ own)
    return min(max(float(wanted @ own) / square, 0.0), SPEED_LIMIT) if square > 0 else 1.0


def _sized(key: Key, width: int, height: int) -> Key:
    same = (key.camera.width, key.camera.height) == (width, height)
    return key if same else replace(key, camera=key.camera.resized(width, height))


def _fineness(key: Key) -> float:
    """World length of a pixel at the focus."""
    return key.camera.pixel_scale(float(key.camera.to_camera(key.focus)[2]))


def _sees(camera: Camera, point: DoubleArray) -> bool:
    return bool(camera.to_camera(point)[2] > NEAREST)


def _straight(start: Camera, end: Camera, s: float) -> Camera:
    """Between cameras that look at nothing in common: straight, with an even zoom."""
    if s <= 0.0 or s >= 1.0:
        return start if s <= 0.0 else end
    rotation = navigation.slerp(start.rotation, end.rotation, s)
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = -rotation @ (start.position + s * (end.position - start.position))
    fx, fy = (a ** (1.0 - s) * b**s for a, b in ((start.fx, end.fx), (start.fy, end.fy)))
    slopes = [((a.cx - a.width / 2) / a.fx, (a.cy - a.height / 2) / a.fy) for a in (start, end)]
    x, y = ((1.0 - s) * slopes[0][i] + s * slopes[1][i] for i in range(2))
    return Camera(
        pose, fx, fy, start.width / 2 + fx * x, start.height / 2 + fy * y, start.width, start.height
    )


# ------------------------------------------------------------------ keys to begin with


def along(stops: list[tuple[Camera, DoubleArray]], seconds: float) -> KeyPath:
    """Returns a path through views (camera, focus) in equal times, s."""
    return KeyPath(tuple(Key(camera, focus, seconds) for camera, focus in stops))


def swing(camera: Camera, pivot: DoubleArray, angle_deg: float, duration_s: float) -> KeyPath:
    """Returns a loop that turns about a world point to both sides and back.

    Args:
        camera: in the middle.
        pivot: (3,) world point that keeps its pixel.
        angle_deg: to either side.
        duration_s: of the loop.
    """
    return KeyPath(tuple(_turned(camera, pivot, angle_deg, duration_s)), is_loop=True)


def _turned(camera: Camera, pivot: DoubleArray, angle_deg: float, duration_s: float) -> Iterator[Key]:
    for share in (0.0, 1.0, 0.0, -1.0):
        yaw = math.radians(angle_deg * share)
        yield Key(navigation.orbited(camera, pivot, yaw, 0.0), pivot, duration_s / 4)
