"""Where an object stands: a plane fitted to the support, a pose on it, contact with it.

Image space is (x px, y px, relief): rays are parallel and slanted by `ray`, so a shear of the
relief along the rays leaves the picture as it is.  That is how the support is followed exactly even
where its tilt is outside the range in which an object looks good.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.bodies import Body
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import render_mask

MARGIN = 0.08  # an object's bounding box stays this far inside the frame
_PROBE = 168
LEAST_SUPPORT = 0.04  # of the surroundings: with less before the sky it is in the sky
_STEEPEST = 6.0
_STANDS_DEG = 60.0  # what is seen from the side stands, and has its own footing
_STANDING_RAD, _LYING_RAD = 0.12, 1.0
"""How far it leans to a side with its ground: what stands is upright on a slope, too, as weight demands."""
_NEAREST = 1e-3  # of the anchor's distance
_IN_FRONT = 0.40  # of its length: what is nearer by less is the support's own roughness
_MOST_HIDDEN = 0.6
_UPRIGHT, _LEAN = 1.73, 0.35  # px of relief per px: its own ground is seen from 30 degrees or flatter


@dataclass(frozen=True, eq=False)
class Support:
    """The surface that objects stand on.

    Attributes:
        relief: (h, w) native px along camera z, + = farther; nan where unknown.
        focal_px: focal length of this level, px.
        ray_x: slope of the ray of the image centre, (w/2 - cx) / f.
        ray_y: the same in y.
        sky: (h, w) where nothing can stand; None if unknown.
        metres_per_px: what a pixel is worth over the view, of any size, nan where nothing stands; None if
            the picture says nothing about it.
    """

    relief: FloatArray
    focal_px: float
    ray_x: float = 0.0
    ray_y: float = 0.0
    sky: BoolArray | None = None
    metres_per_px: FloatArray | None = None

    def range_at(self, relief: float) -> float:
        """Returns how far a relief is, the level's anchor being 1: so much larger are the pixels there."""
        return max(1.0 + relief / self.focal_px, _NEAREST)

    def ray_at(self, x: float, y: float) -> tuple[float, float]:
        """Returns the slope of the ray through a pixel."""
        h, w = self.relief.shape
        return self.ray_x + (x - w / 2) / self.focal_px, self.ray_y + (y - h / 2) / self.focal_px


@dataclass(frozen=True)
class Plane:
    """relief = at + slope_x (x - x0) + slope_y (y - y0)."""

    x0: float
    y0: float
    at: float
    slope_x: float
    slope_y: float

    def __call__(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Returns relief at pixels."""
        return self.at + self.slope_x * (x - self.x0) + self.slope_y * (y - self.y0)

    def at_range(self, share: float) -> "Plane":
        """Returns the plane with slopes in pixels of its own distance, where those are of the anchor's."""
        steep = np.clip(np.array([self.slope_x, self.slope_y]) / share, -_STEEPEST, _STEEPEST)
        return replace(self, slope_x=float(steep[0]), slope_y=float(steep[1]))

    def normal(self, ray: tuple[float, float]) -> DoubleArray:
        """Returns the unit normal towards the camera of the surface in camera axes."""
        rx, ry = ray
        a, b = self.slope_x, self.slope_y
        n = np.cross([1 + a * rx, a * ry, a], [b * rx, 1 + b * ry, b])
        return -n / np.linalg.norm(n) * np.sign(n @ np.array([rx, ry, 1.0]))


def fit_plane(support: Support, x: float, y: float, radius_px: float) -> Plane:
    """Fits a plane to the relief around a pixel; trims what does not belong to that surface.

    What is on the edge of something before the sky stands on that thing alone: a plane through both
    would lead from one into the distance of the other.
    """
    h, w = support.relief.shape
    step = max(int(radius_px / 24), 1)
    ys, xs = np.mgrid[
        max(int(y - radius_px), 0) : min(int(y + radius_px) + 1, h) : step,
        max(int(x - radius_px), 0) : min(int(x + radius_px) + 1, w) : step,
    ]
    z = support.relief[ys, xs].astype(np.float64)
    far = np.hypot(xs - x, ys - y)
    good = np.isfinite(z) & (far <= radius_px)
    if support.sky is not None and (solid := good & ~support.sky[ys, xs]).sum() >= LEAST_SUPPORT * good.sum():
        good = solid
    if good.sum() < 12:
        return Plane(x, y, 0.0, 0.0, 0.0)
    core = good & (far <= max(0.35 * radius_px, far[good].min() + 1))
    at = float(np.median(z[core]))
    u, v, z = xs[good] + 0.5 - x, ys[good] + 0.5 - y, z[good] - at
    fit = np.zeros(3)
    near = support.range_at(at)
    keep = np.abs(z) < 3.0 * near * radius_px
    for _ in range(4):
        if keep.sum() < 12:
            break
        basis = np.stack([u[keep], v[keep], np.ones(int(keep.sum()))], 1)
        fit = np.linalg.lstsq(basis, z[keep], rcond=None)[0]
        off = np.abs(z - fit[0] * u - fit[1] * v - fit[2])
        keep = off <= max(2.0 * float(np.median(off)), 0.5 * near)
    slope = np.clip(fit[:2], -_STEEPEST * near, _STEEPEST * near)
    off_px = float(np.clip(fit[2], -near * radius_px, near * radius_px))
    return Plane(x, y, at + off_px, float(slope[0]), float(slope[1]))


def stands(body: Body) -> bool:
    """Tells whether a body is one that stands, and does not lie or creep."""
    return body.tilt_deg[0] >= _STANDS_DEG


def orientation(
    body: Body, normal: DoubleArray, ray: tuple[float, float], rng: np.random.Generator
) -> DoubleArray:
    """Returns camera_from_object (3, 3): on the support, tilted so that it looks good, best side shown."""
    eye = -np.array([ray[0], ray[1], 1.0])
    eye /= np.linalg.norm(eye)
    up = np.array([0.0, -1.0, 0.0])
    up -= (up @ eye) * eye
    up /= np.linalg.norm(up)
    tilt = float(np.degrees(np.arccos(np.clip(normal @ eye, -1, 1))))
    lean = normal - (normal @ eye) * eye
    lean = lean / max(float(np.linalg.norm(lean)), 1e-9)
    trust = np.clip((tilt - 8.0) / 14.0, 0, 1)
    side = np.cross(eye, up)
    most = _STANDING_RAD if stands(body) else _LYING_RAD
    angle = trust * np.clip(np.arctan2(lean @ side, lean @ up), -most, most)
    toward = np.cos(angle) * up + np.sin(angle) * side
    tilt = np.radians(np.clip(tilt if trust > 0 else 0.5 * sum(body.tilt_deg), *body.tilt_deg))
    n = np.cos(tilt) * eye + np.sin(tilt) * toward
    yaw = np.radians(body.yaw_deg + rng.uniform(-12, 12))
    yaw = np.pi - yaw if rng.random() < 0.5 and body.turns else yaw
    right = np.cross(n, eye)
    right = right / np.linalg.norm(right) if tilt > 1e-3 else np.cross(up, -eye)
    ahead = np.cos(yaw) * right + np.sin(yaw) * np.cross(n, right)
    return np.stack([np.cross(ahead, n), ahead, n], 1)


def pose_on(
    body: Body, support: Support, centre_px: tuple[float, float], width_px: float, rng: np.random.Generator
) -> tuple[Pose, Plane]:
    """Returns the pose of a body whose picture is about `width_px` wide and centred, and its support plane.

    The width is half way between the body's with and without its legs and feelers; the bounding
    box stays inside the frame's margins.
    """
    h, w = support.relief.shape
    plane = fit_plane(support, *centre_px, 0.6 * width_px)
    ray = support.ray_at(*centre_px)
    local = plane.at_range(support.range_at(plane.at))
    rotation = orientation(body, local.normal(ray), ray, rng)
    low, high, core = _extent(body, Pose(rotation, 1.0, (0.0, 0.0, 0.0), ray))
    size = width_px / (0.5 * core + 0.5 * float((high - low).max()))
    frame = np.array([w, h], np.float64)
    size = min(size, float(((1 - 2 * MARGIN) * frame / (high - low)).min()))
    origin = np.asarray(centre_px) - size * (low + high) / 2
    origin = np.clip(origin, MARGIN * frame - size * low, (1 - MARGIN) * frame - size * high)
    x, y = float(origin[0]), float(origin[1])
    relief = float(plane(np.float64(x), np.float64(y)))  # type: ignore[arg-type]
    return Pose(rotation, size, (x, y, relief), ray), plane


def hovering(pose: Pose, height: float) -> Pose:
    """Returns a pose raised above its ground by body lengths, where it was in the picture.

    So the ground goes down in the picture as far as the body is raised, and the body stays in view.
    """
    rise = float(pose.camera_from_object[2, 2]) * height * pose.size_px
    x, y, z = pose.position
    return replace(pose, position=(x, y, z + rise))


def _extent(body: Body, pose: Pose) -> tuple[DoubleArray, DoubleArray, float]:
    """Returns the corners of the body's picture and its width without thin parts, all at size 1."""
    centre = pose.project(body.primitives[:, 30:33])
    reach = float((np.abs(centre) + body.primitives[:, 33:34]).max())
    size = 0.48 * _PROBE / reach
    probe = Pose(pose.camera_from_object, size, (_PROBE / 2, _PROBE / 2, 0.0), pose.ray)
    mask, _ = render_mask(Scene(body, probe, _PROBE, _PROBE))
    y, x = np.nonzero(mask)
    corners = np.stack([x, y], 1).astype(np.float64)
    low, high = (corners.min(0) - _PROBE / 2) / size, (corners.max(0) + 1 - _PROBE / 2) / size
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
    ys, xs = np.nonzero(cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc))
    core = max(np.ptp(xs), np.ptp(ys)) / size if len(xs) else float((high - low).max())
    return low, high, float(core)


def is_upright(pose: Pose) -> bool:
    """Tells whether a body stands in the picture, so that its own ground is seen at a flat angle."""
    return bool(np.hypot(*_own_slope(pose)) > _UPRIGHT)


def _own_slope(pose: Pose) -> DoubleArray:
    """Returns (2,) how steeply a body's own ground rises against its relief, px of relief a px."""
    n = pose.camera_from_object[:, 2]
    return np.asarray(n[:2] / (n @ np.array([pose.ray[0], pose.ray[1], 1.0])))


def from_above(pose: Pose) -> Plane | None:
    """Returns what to add to the relief of an upright body's own ground to see it from 30 degrees.

    Its own is seen so flat that no shadow on it would show.  None if the body lies.
    """
    if not is_upright(pose):
        return None
    slope = _own_slope(pose)
    slope *= 1 - _UPRIGHT / float(np.hypot(*slope))
    return Plane(pose.position[0], pose.position[1], 0.0, float(slope[0]), float(slope[1]))


def lift_onto(pose: Pose, plane: Plane) -> Plane:
    """Returns what to add to the marched relief so that the body's own ground becomes the fitted plane."""
    x, y, z = pose.position
    slope = np.array([plane.slope_x, plane.slope_y]) + _own_slope(pose)
    if is_upright(pose):  # laid onto a wall it would lean as far as the wall is from lying
        slope *= min(1.0, _LEAN / max(float(np.hypot(*slope)), 1e-9))
    return Plane(x, y, float(plane(np.float64(x), np.float64(y))) - z, float(slope[0]), float(slope[1]))  # type: ignore[arg-type]


def hidden_by(support: FloatArray, relief: FloatArray, mask: BoolArray, size_px: float) -> BoolArray:
    """Tells where something else stands clearly in front of a body (h, w): by a share of its own length.

    A body of which little would be left is in front of everything instead.
    """
    with np.errstate(invalid="ignore"):
        nearer = mask & (support < relief - np.float32(_IN_FRONT * size_px))
    if nearer.sum() > _MOST_HIDDEN * max(int(mask.sum()), 1):
        return np.zeros_like(mask)
    # Specks are noise of the depth; what is wider counts up to its rim.
    wide = cv2.morphologyEx(nearer.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return np.asarray(nearer & (cv2.dilate(wide, np.ones((7, 7), np.uint8)) > 0))


def settle(
    relief: FloatArray,
    mask: BoolArray,
    support: FloatArray,
    size_px: float,
    *,
    floats: bool = False,
    share: float = 1.0,
) -> tuple[FloatArray, float]:
    """Brings a body's relief into contact: touching the support, never behind it.

    Args:
        relief: (h, w) of the body, nan outside.
        mask: (h, w) where it is.
        support: (h, w), nan where unknown.
        size_px: the body's length, px.
        floats: True for what is in the air: then it only stays in front.
        share: how far it is, the level's anchor being 1; its depths are in pixels of the anchor's.

    Returns:
        the relief in contact, and the uniform shift that was part of it.
    """
    known = mask & np.isfinite(support) & np.isfinite(relief)
    if not floats:
        known &= ~hidden_by(support, relief, mask, share * size_px)
    if not known.any():
        return relief, 0.0
    gap = support[known] - relief[known]
    # A few feet may sink into bumps: what touches is the 2 % of the body nearest to the support.
    shift = float(np.percentile(gap, 2.0))
    shift = min(shift, 0.0) if floats else shift
    moved = relief + np.float32(shift)
    short = np.where(known, np.maximum(moved - support, 0), 0).astype(np.float32)
    if short.max() > 0:
        k = max(int(size_px / 12), 1) | 1
        moved = moved - cv2.GaussianBlur(cv2.dilate(short, np.ones((k, k), np.uint8)), (0, 0), k / 2)
    limit = np.where(np.isfinite(support), support - np.float32(0.25), np.float32(np.inf))
    return np.where(mask, np.minimum(moved, limit), np.nan).astype(np.float32), shift
