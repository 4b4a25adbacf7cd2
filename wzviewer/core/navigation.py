"""Line 8 of Algorithm 1: the user moves the camera.  Pure functions, float64, no clock.

Two groups of motions, because a zoomed picture has two kinds of freedom::

    picture motions   zoomed, panned     focal length and principal point; the pose stays, so every
                                         pixel follows the hand exactly and nothing is disoccluded
    pose motions      orbited, flown     the camera itself moves; there is parallax
                      turned             the camera looks elsewhere; there is none

Panning moves the principal point and not the camera: at a magnification of 8^n a camera motion of one
pixel is 8^-n of the depth, and points at other depths would run away under the cursor.

``Flight`` goes from one camera to another.  Its focal length follows a straight line in log space
about the one pixel that both cameras agree on; where there is no such pixel near the picture it
rises, travels and descends (van Wijk and Nuij, "Smooth and efficient zooming and panning", 2003).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import DoubleArray

NOTCH_FACTOR = 1.2  # magnification of one notch of the wheel
SPRING_RATE = 11.0  # 1/s; 90 % of a notch within 0.21 s
SPRING_REST = 1e-4  # log magnification below which the spring snaps to its target
FLY_RATE = 0.6  # pictures per second sideways, e-folds of distance per second forwards
ARC = math.sqrt(2.0)  # rho of van Wijk and Nuij: how high a long pan rises
NESTED_LIMIT = 1.5  # widths: a common pixel further outside than this is no straight zoom
SECONDS_PER_FOLD = 0.28  # of a flight, for every e-fold of magnification
FLIGHT_S = (0.45, 4.0)  # shortest and longest flight


@dataclass(frozen=True)
class ZoomSpring:
    """A zoom that runs after the wheel.

    Attributes:
        log_factor: distance to the target in log focal length.
        x_px: the pixel that keeps its place.
        y_px: the same, down.
    """

    log_factor: float = 0.0
    x_px: float = 0.0
    y_px: float = 0.0

    @property
    def is_resting(self) -> bool:
        """Whether the target is reached."""
        return self.log_factor == 0.0

    def turned(self, x_px: float, y_px: float, notches: float) -> "ZoomSpring":
        """Returns the spring after the wheel turned over a pixel; positive is closer."""
        return ZoomSpring(self.log_factor + notches * math.log(NOTCH_FACTOR), x_px, y_px)

    def advanced(self, camera: Camera, dt_s: float) -> "tuple[ZoomSpring, Camera]":
        """Lets time pass: the distance decays exponentially, whatever the frame rate.

        Args:
            camera: the camera before.
            dt_s: time since the last call, s.

        Returns:
            The spring and the camera after.
        """
        left = self.log_factor * math.exp(-SPRING_RATE * dt_s)
        left = 0.0 if abs(left) < SPRING_REST else left
        near = camera.zoomed(self.x_px, self.y_px, math.exp(self.log_factor - left))
        return replace(self, log_factor=left), near


def panned(camera: Camera, dx_px: float, dy_px: float) -> Camera:
    """Returns the camera whose picture is moved by a number of pixels; see the module docstring."""
    return replace(camera, cx=camera.cx + dx_px, cy=camera.cy + dy_px)


def orbited(camera: Camera, pivot: DoubleArray, yaw_rad: float, pitch_rad: float) -> Camera:
    """Returns the camera turned about a world point, which keeps its pixel.

    ``camera_from_world' = camera_from_world T(p) R T(-p)``: yaw about the world's vertical, so that the
    horizon stays level, then pitch about the camera's x axis.  What lies in front of the pivot moves
    right with positive yaw and down with positive pitch.

    Args:
        camera: the camera before.
        pivot: p, (3,), world units, in front of the camera.
        yaw_rad: turn to the right.
        pitch_rad: turn downwards.
    """
    before = camera.project(pivot)
    turn = _rotation(camera.rotation[0], pitch_rad) @ _rotation(np.array([0.0, 1.0, 0.0]), -yaw_rad)
    pose = pose_through(_orthonormal(camera.rotation @ turn), pivot, camera.to_camera(pivot))
    after = replace(camera, camera_from_world=pose)
    # At 8^12 a rounding of the pose is a hundredth of a pixel: the principal point takes it up.
    return panned(after, *(before - after.project(pivot))[:2])


def flown(
    camera: Camera, steps: tuple[float, float, float], dt_s: float, depth: float, magnification: float
) -> Camera:
    """Returns the camera after flying (right, down, forward), each in [-1, 1].

    Sideways the camera crosses ``FLY_RATE`` pictures per second at the focus, so the speed is relative
    to distance and magnification.  Forwards it approaches the focus exponentially: by moving at
    magnification 1, by zooming where the picture is magnified, since no step towards a distant thing
    enlarges it.

    Args:
        camera: the camera before.
        steps: direction keys.
        dt_s: time since the last call, s.
        depth: of the focus, world units.
        magnification: total magnification at the focus.
    """
    right, down, forward = steps
    aside = FLY_RATE * dt_s * camera.width * camera.pixel_scale(depth)
    share = 1.0 / max(magnification, 1.0)
    dolly = depth * -math.expm1(-FLY_RATE * dt_s * forward * share)
    centre = camera.unproject(camera.width / 2, camera.height / 2, 1.0) - camera.position
    step = centre * dolly + aside * (right * camera.rotation[0] + down * camera.rotation[1])
    pose = camera.camera_from_world.copy()
    pose[:3, 3] = -camera.rotation @ (camera.position + step)
    moved = replace(camera, camera_from_world=pose)
    zoom = math.exp(FLY_RATE * dt_s * forward * (1.0 - share))
    return moved.zoomed(camera.width / 2, camera.height / 2, zoom)


def turned(camera: Camera, right_s: float, down_s: float) -> Camera:
    """Returns the camera looking elsewhere from where it is, `FLY_RATE` pictures a second.

    What is seen moves the other way by about that much, whatever the magnification: no parallax.

    Args:
        camera: the camera before.
        right_s: how long it turns to the right, s.
        down_s: how long it turns downwards, s.
    """
    yaw_rad, pitch_rad = (FLY_RATE * time_s * camera.width / camera.focal_px for time_s in (right_s, down_s))
    turn = _rotation(np.array([0.0, 1.0, 0.0]), yaw_rad) @ _rotation(camera.rotation[0], -pitch_rad)
    rotation = _orthonormal(camera.rotation @ turn.T)
    return replace(camera, camera_from_world=pose_through(rotation, camera.position, np.zeros(3)))


def pose_through(rotation: DoubleArray, point: DoubleArray, in_camera: DoubleArray) -> DoubleArray:
    """Returns camera_from_world (4, 4) of a rotation (3, 3) that sees a world point at a place."""
    pose = np.eye(4)
    pose[:3, :3] = rotation
    # t = p_cam - R p; R p is summed once, so that a pose a level away loses no digits to a third term.
    pose[:3, 3] = in_camera - rotation @ point
    return pose


@dataclass(frozen=True, eq=False)
class Flight:
    """A flight from one camera to another of the same size.

    Attributes:
        start: first camera.
        end: last camera.
        focus: (3,) world point that the flight is about, in front of both cameras.
        duration_s: s.
        elapsed_s: s since the start.
    """

    start: Camera
    end: Camera
    focus: DoubleArray
    duration_s: float
    elapsed_s: float = 0.0

    @classmethod
    def between(cls, start: Camera, end: Camera, focus: DoubleArray) -> "Flight":
        """Plans a flight; its duration grows with the change of magnification."""
        end = end if (end.width, end.height) == (start.width, start.height) else _resized_to(end, start)
        folds = abs(math.log(end.focal_px / start.focal_px)) + math.log1p(_distance(start, end, focus))
        duration_s = min(max(FLIGHT_S[0] + SECONDS_PER_FOLD * folds, FLIGHT_S[0]), FLIGHT_S[1])
        return cls(start, end, focus, duration_s)

    @property
    def is_over(self) -> bool:
        """Whether the end is reached."""
        return self.elapsed_s >= self.duration_s

    @property
    def camera(self) -> Camera:
        """The camera at this moment, eased in and out."""
        s = min(self.elapsed_s / self.duration_s, 1.0)
        return interpolated(self.start, self.end, self.focus, s * s * (3.0 - 2.0 * s))

    def advanced(self, dt_s: float) -> "Flight":
        """Returns the flight a little later."""
        return replace(self, elapsed_s=min(self.elapsed_s + dt_s, self.duration_s))


def interpolated(start: Camera, end: Camera, focus: DoubleArray, s: float) -> Camera:
    """Returns the camera at a fraction s of the way; its ends are the given cameras exactly.

    The rotation follows the great circle, the place of the focus in camera space a straight line.  The
    picture is panned and zoomed relative to the focus, so that for equal poses the path is the exact
    straight zoom about the common pixel.

    Args:
        start: camera at s = 0.
        end: camera at s = 1, of the same size.
        focus: (3,) world point, in front of both.
        s: fraction of the way, [0, 1].
    """
    if s <= 0.0 or s >= 1.0:
        return start if s <= 0.0 else end
    p_start, p_end = start.to_camera(focus), end.to_camera(focus)
    p = p_start + s * (p_end - p_start)
    focal, offset = _pan_zoom(start, end, focus, s)
    aspect = (start.fy / start.fx) ** (1.0 - s) * (end.fy / end.fx) ** s
    fx, fy = focal / math.sqrt(aspect), focal * math.sqrt(aspect)
    if np.array_equal(start.camera_from_world, end.camera_from_world):
        pose = start.camera_from_world
    else:
        rotation = slerp(start.rotation, end.rotation, s)
        pose = pose_through(rotation, focus, p)
    cx = start.width / 2 - offset[0] - fx * p[0] / p[2]
    cy = start.height / 2 - offset[1] - fy * p[1] / p[2]
    return Camera(pose, fx, fy, cx, cy, start.width, start.height)


def _pan_zoom(start: Camera, end: Camera, focus: DoubleArray, s: float) -> tuple[float, DoubleArray]:
    """Focal length, and offset of the picture's centre from the focus, px, (2,)."""
    f0, f1 = start.focal_px, end.focal_px
    o0, o1 = _offset_px(start, focus), _offset_px(end, focus)
    log_ratio = math.log(f1 / f0)
    if _is_nested(start, f0, f1, o0, o1):
        # (k^s - 1) / (k - 1): focal length and offset change together, so one pixel stands still.
        share = math.expm1(s * log_ratio) / math.expm1(log_ratio) if abs(log_ratio) > 1e-9 else s
        return f0 * math.exp(s * log_ratio), o0 + share * (o1 - o0)
    return _arc(start.width, f0, f1, o0 / f0, o1 / f1, s)


def _arc(
    width: int, f0: float, f1: float, g0: DoubleArray, g1: DoubleArray, s: float
) -> tuple[float, DoubleArray]:
    """Van Wijk and Nuij, Eq. 9: the optimal path of pan and zoom between two windows."""
    u1 = float(np.linalg.norm(g1 - g0))
    w0, w1, rr = width / f0, width / f1, ARC * ARC
    b0 = (w1 * w1 - w0 * w0 + rr * rr * u1 * u1) / (2.0 * w0 * rr * u1)
    b1 = (w1 * w1 - w0 * w0 - rr * rr * u1 * u1) / (2.0 * w1 * rr * u1)
    r0, r1 = -math.asinh(b0), -math.asinh(b1)
    r = r0 + s * (r1 - r0)
    travelled = w0 / rr * (math.cosh(r0) * math.tanh(r) - math.sinh(r0))
    focal = width / (w0 * math.cosh(r0) / math.cosh(r))
    return focal, focal * (g0 + (g1 - g0) * min(travelled / u1, 1.0))


def _is_nested(camera: Camera, f0: float, f1: float, o0: DoubleArray, o1: DoubleArray) -> bool:
    """Whether the pixel that both cameras agree on lies in or near the picture."""
    difference = f1 / f0 - 1.0
    apart = float(np.linalg.norm(o1 - o0 * (f1 / f0)))
    return apart <= NESTED_LIMIT * camera.width * abs(difference) or apart < 1e-6


def _offset_px(camera: Camera, focus: DoubleArray) -> DoubleArray:
    """From the focus to the centre of the picture, px, (2,)."""
    return np.array([camera.width / 2, camera.height / 2]) - camera.project(focus)[:2]


def _distance(start: Camera, end: Camera, focus: DoubleArray) -> float:
    """How far the pictures lie apart, in widths of the narrower view's picture."""
    g0 = _offset_px(start, focus) / start.focal_px
    g1 = _offset_px(end, focus) / end.focal_px
    return float(np.linalg.norm(g1 - g0)) * min(start.focal_px, end.focal_px) / start.width


def _resized_to(camera: Camera, other: Camera) -> Camera:
    return camera.resized(other.width, other.height)


def slerp(start: DoubleArray, end: DoubleArray, s: float) -> DoubleArray:
    """Returns the rotation (3, 3) at a fraction of the great circle between two rotations."""
    return turned_rotation(start, s * turn_of(end @ start.T))


def turn_of(rotation: DoubleArray) -> DoubleArray:
    """Returns the rotation vector (3,), rad, of a rotation (3, 3)."""
    R = rotation
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    length = float(np.linalg.norm(axis))
    angle_rad = math.atan2(length, float(np.trace(R)) - 1.0)
    if length < 1e-12:  # equal, or opposite: then no circle is shorter than another
        axis, length = np.array([0.0, 1.0, 0.0]), 1.0
    return axis / length * angle_rad


def turned_rotation(rotation: DoubleArray, by: DoubleArray) -> DoubleArray:
    """Returns a rotation (3, 3) turned by a rotation vector (3,), rad."""
    angle_rad = float(np.linalg.norm(by))
    axis = by / angle_rad if angle_rad > 0.0 else np.array([0.0, 1.0, 0.0])
    return _orthonormal(_rotation(axis, angle_rad) @ rotation)


def total_magnification(camera: Camera, home: Camera, focus: DoubleArray) -> float:
    """How much larger a world point (3,) appears than from home: the quotient of Eq. 1."""
    depth, home_depth = camera.to_camera(focus)[2], home.to_camera(focus)[2]
    return home.pixel_scale(float(home_depth)) / camera.pixel_scale(float(depth))


@dataclass(frozen=True)
class ScaleBar:
    """A bar of a round length.

    Attributes:
        length: 1, 2 or 5 times a power of ten, world units.
        width_px: its width on the screen.
    """

    length: float
    width_px: float


def scale_bar(pixel_scale: float, limit_px: float) -> ScaleBar:
    """Returns the longest round bar within a limit.

    Args:
        pixel_scale: world units per pixel at the focus, Eq. 1.
        limit_px: greatest width, px.
    """
    decade = 10.0 ** math.floor(math.log10(pixel_scale * limit_px))
    lengths = [n * decade for n in (5.0, 2.0, 1.0, 0.5)]  # 0.5: log10 may round up
    length = next((x for x in lengths if x <= pixel_scale * limit_px), lengths[-1])
    return ScaleBar(length, length / pixel_scale)


def _rotation(axis: DoubleArray, angle_rad: float) -> DoubleArray:
    """Rodrigues: rotation (3, 3) about a unit axis (3,)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle_rad) * K + 2.0 * math.sin(angle_rad / 2) ** 2 * (K @ K)


def _orthonormal(matrix: DoubleArray) -> DoubleArray:
    """The nearest rotation: a long drag must not let rounding grow."""
    u, _, vt = np.linalg.svd(matrix)
    return u @ vt
