"""Merged surfels: a level at a half or a quarter of its native resolution.

Surfels whose centres fall into one cell of ``cell_px`` x ``cell_px`` native pixels of the camera that
made them, and that lie on one surface, become one.  Merging keeps the picture, where drawing fewer of
the same surfels destroys it.  In the creating camera's image, with weights o_i a_i and a_i the product
of a footprint's standard deviations::

    p, c, n   means of p_i, c_i, n_i (towards the camera)
    Cov       mean of Cov_i  +  SPREAD  mean of (x_i - x)(x_i - x)^T
    o         mean of o_i, less where the a_i leave gaps in Cov, more where they overlap

The pixel centres of a full cell of k x k have the variance (k^2 - 1) / 12, so with
``SPREAD = 12 SURFEL_SIGMA_PX^2`` their Cov is ``(SURFEL_SIGMA_PX k)^2``: a merged level is what lifting
a picture of a k-th of the resolution would give, and as closed.  A cell that is filled in part (a
silhouette, a strand) grows along what fills it only.  Cov is then carried onto the plane through p with
the normal n.

Surfaces within a cell are told apart by parallax, less the slope that the surfels' own normals explain.
What the creating camera does not see never mixes with what it sees; it is pushed back where a slope is
so steep that its merged surfels would overtake those of the surface before them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ALPHA_MAX, COS_TILT_MIN, OPACITY_MIN, SURFEL_SIGMA_PX
from wzviewer.core.surfels import SURFEL_SHAPES, Surfels
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray

SPREAD = 12.0 * SURFEL_SIGMA_PX**2  # from the variance of pixel centres to that of a closed Gaussian
JUMP = 2.0  # cells of parallax between two surfaces; an 8 degree orbit parts them by 0.3 cells
HIDDEN = 1.0  # px of parallax behind another surfel of the same pixel
REACH = 1.5  # cells that a merged footprint reaches over
SLOPE_MAX = 1.0 / COS_TILT_MIN  # parallax px per px that a normal may explain
BLOCK = 32  # cells a side: blocks follow Hilbert's curve, cells within are row-major
MARGIN = 1.0  # image sizes beyond the border up to which surfels are merged
PIECE = 1 << 15  # surfels that are worked on at once: they stay in the cache

_Index = NDArray[np.int64]
_Floats = NDArray[np.floating[Any]]
_Columns = tuple[FloatArray, ...]  # (n,) each
_TINY = np.float32(1e-12)


def merged(surfels: Surfels, camera: Camera, frame: LevelFrame, cell_px: int) -> Surfels:
    """Merges the surfels of a level that share a cell of its camera's image and a surface.

    Args:
        surfels: (n) of one level, in any order.
        camera: the camera that made the level.
        frame: the level's; its axes are the camera's.
        cell_px: side of a cell, native pixels: 2 or 4 for a half or a quarter of the resolution.

    Returns:
        Surfels in the same frame and units: in compact blocks of cells, and in a cell the visible ones
        first, nearer ones first.  Then, as they were, those behind the camera or far outside of its
        image.  A surfel that is alone keeps its values.  ``native_scales`` and ``coverage`` are means,
        so that a merged level fades exactly when the level does (Eq. 3).

    Raises:
        ValueError: when a cell is smaller than a pixel.
    """
    if cell_px < 1:
        raise ValueError(f"cell_px is {cell_px}, expected 1 or more")
    lens = _Lens.of(camera, frame)
    places = _Places.of(surfels, lens, cell_px)
    order, starts = _groups(places.cells, places.parallax, JUMP * cell_px)
    pieces = [
        _merged_piece(surfels.take(order[begin:end]), places.push[order[begin:end]], lens, within)
        for begin, end, within in _pieces(starts, len(order))
    ]
    return Surfels.concatenate([*pieces, surfels.take(np.flatnonzero(places.cells < 0))])


@dataclass(frozen=True, eq=False)
class _Lens:
    """The creating camera in the level's frame.

    Attributes:
        view: the camera about the level's anchor.
        eye: (3,) float32, from the camera to the anchor in local axes, native pixels.
        focal: (f, fx, fy), px.
        size: (width, height), px.
    """

    view: AnchoredView
    eye: FloatArray
    focal: tuple[float, float, float]
    size: tuple[int, int]

    @classmethod
    def of(cls, camera: Camera, frame: LevelFrame) -> "_Lens":
        eye = (camera.to_camera(frame.origin) / frame.unit).astype(np.float32)
        focal = (camera.focal_px, camera.fx, camera.fy)
        return cls(AnchoredView.expand(camera, frame), eye, focal, (camera.width, camera.height))

    def parallax(self, means: FloatArray, ratio: FloatArray) -> FloatArray:
        """Parallax of points (n, 3) whose D (n,) is known, px; D - 1 would cancel."""
        return (means @ np.float32(-self.focal[0] * self.view.rows[2, :3]) / ratio).astype(np.float32)

    def slopes(self, means: FloatArray, normals: FloatArray) -> _Columns:
        """Parallax px per px along x and y on planes, in whose image 1 / z is affine."""
        facing = _dot(normals, (means + self.eye).T) / np.float32(self.focal[0])
        facing = np.where(np.abs(facing) < _TINY, _TINY, facing)
        across = (np.float32(self.focal[0] / f) for f in self.focal[1:])
        slopes = (n * ratio / facing for n, ratio in zip(normals[:2], across, strict=True))
        return tuple(np.clip(slope, -SLOPE_MAX, SLOPE_MAX) for slope in slopes)

    def moved_px(self, steps: _Floats, points_px: FloatArray, ratio: FloatArray) -> _Floats:
        """Derivative of the image position along local steps (3, n) at points (n, 2), D (n,); (2, n)."""
        gx, gy, g = self.view.rows.astype(np.float32)
        x = gx[0] * steps[0] + (gx[2] - (points_px[:, 0] - gx[3]) * g[2]) * steps[2]
        y = gy[1] * steps[1] + (gy[2] - (points_px[:, 1] - gy[3]) * g[2]) * steps[2]
        return np.stack([x, y]) / ratio


def _dot(a: _Floats, b: _Floats) -> _Floats:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@dataclass(frozen=True, eq=False)
class _Places:
    """Where surfels are in the creating camera's image.

    Attributes:
        cells: (n,) index, times two, plus one for what is hidden; -1 for those not to be merged.
        parallax: (n,) at the middle of the cell, on the surfel's own plane, px.
        push: (n,) parallax by which hidden ones give way, px.
    """

    cells: _Index
    parallax: FloatArray
    push: FloatArray

    @classmethod
    def of(cls, surfels: Surfels, lens: _Lens, cell_px: int) -> "_Places":
        n = len(surfels)
        cells, pixels = (np.empty(n, np.int64) for _ in range(2))
        parallax, steepness, centred = (np.empty(n, np.float32) for _ in range(3))
        for start in range(0, n, PIECE):
            part = slice(start, start + PIECE)
            means, quats = surfels.means[part], surfels.quats[part]
            points, inside = _image_points(means, lens)
            cells[part], pixels[part], offset = _cells(points, lens, cell_px)
            parallax[part] = lens.parallax(means, np.where(inside, lens.view.depth_ratio(means), 1))
            slope_x, slope_y = lens.slopes(means, _normals(quats))
            steepness[part] = np.hypot(slope_x, slope_y)
            centred[part] = parallax[part] - slope_x * offset[0] - slope_y * offset[1]
            cells[part][~inside] = -1
        used = cells >= 0
        behind = _behind(pixels, parallax, used)
        hidden = behind > np.float32(HIDDEN)
        push = np.where(hidden, np.maximum(np.float32(REACH * cell_px) * steepness - behind, 0), 0)
        return cls(np.where(used, 2 * cells + hidden, -1), centred, push.astype(np.float32))


def _image_points(means: FloatArray, lens: _Lens) -> tuple[FloatArray, BoolArray]:
    """Image positions (n, 2), px, and which are near enough to the image; the others are moved to 0."""
    points = lens.view.project(means)
    (x, y), (width, height), margin = points.T, lens.size, MARGIN * max(lens.size)
    inside = (x >= -margin) & (x < width + margin) & (y >= -margin) & (y < height + margin)
    points[~inside] = 0  # nan too
    return points, inside


def _cells(points: FloatArray, lens: _Lens, cell_px: int) -> tuple[_Index, _Index, _Columns]:
    """Indices of cells, row-major indices of pixels, and offsets from the cells' centres, px."""
    border = cell_px * int(np.ceil(MARGIN * max(lens.size) / cell_px))
    pixels = np.floor(points).astype(np.int64) + border
    cells = pixels // cell_px
    offset = points - (cells * cell_px + (cell_px / 2 - border)).astype(np.float32)
    (x, y), (column, row) = (cells % BLOCK).T, (cells // BLOCK).T
    curve = _curve((max(lens.size) + 2 * border) // (cell_px * BLOCK) + 1)
    pixel = pixels[:, 1] * (lens.size[0] + 2 * border) + pixels[:, 0]
    return (curve[row, column] * BLOCK + y) * BLOCK + x, pixel, (offset[:, 0], offset[:, 1])


@lru_cache(maxsize=16)
def _curve(side: int) -> _Index:
    """Position of every block of a square of ``side`` or more on Hilbert's curve: runs stay compact."""
    table = np.zeros((1, 1), np.int64)
    while len(table) < side:
        n = table.size
        table = np.block([[table.T, 3 * n + table[::-1, ::-1].T], [n + table, 2 * n + table]])
    return table


def _behind(pixels: _Index, parallax: FloatArray, used: BoolArray) -> FloatArray:
    """Parallax (n,) that lies between a surfel and the nearest of its pixel; 0 for the nearest."""
    nearest = np.full(int(pixels.max(initial=0)) + 1, -np.inf, np.float32)
    np.maximum.at(nearest, pixels[used], parallax[used])
    return np.where(used, nearest[pixels] - parallax, np.float32(0))


def _groups(cells: _Index, parallax: FloatArray, jump: float) -> tuple[_Index, _Index]:
    """Orders surfels by cell, nearer first, and cuts where the surface changes.

    Returns:
        order: (m,) indices of the surfels that have a cell.
        starts: (k,) positions in the order at which a group begins.
    """
    used = np.flatnonzero(cells >= 0)
    if len(used) == 0:
        return used, used
    index_bits, cell_bits = len(cells).bit_length(), int(cells.max()).bit_length()
    depth_bits = min(32, 64 - index_bits - cell_bits)
    keys = cells[used].astype(np.uint64) << np.uint64(depth_bits)
    keys |= _depth_codes(parallax[used], jump, depth_bits)
    # the index in the key makes the order total, and sorting numbers is ten times as fast as argsort
    keys = np.sort(keys << np.uint64(index_bits) | used.astype(np.uint64))
    order = (keys & np.uint64((1 << index_bits) - 1)).astype(np.int64)
    cell, q = keys >> np.uint64(index_bits + depth_bits), parallax[order]
    cuts = (cell[1:] != cell[:-1]) | (q[:-1] - q[1:] > np.float32(jump))
    return order, np.concatenate([[0], np.flatnonzero(cuts) + 1])


def _depth_codes(parallax: FloatArray, jump: float, bits: int) -> NDArray[np.uint64]:
    """Integers below 2^bits that grow with depth: finest where parallax is small."""
    logs = np.copysign(np.log1p(np.abs(parallax) / np.float32(jump)), -parallax).astype(np.float64)
    largest = max(float(np.abs(logs).max()), 1e-6)
    return ((logs / largest + 1) * ((1 << bits) - 1) / 2).astype(np.uint64)


def _pieces(starts: _Index, total: int) -> Iterator[tuple[int, int, _Index]]:
    """Yields (begin, end, starts from begin on) of runs of whole groups of about PIECE surfels."""
    group = 0
    while group < len(starts):
        begin = int(starts[group])
        after = max(int(np.searchsorted(starts, begin + PIECE)), group + 1)
        end = int(starts[after]) if after < len(starts) else total
        yield begin, end, starts[group:after] - begin
        group = after


def _merged_piece(members: Surfels, push: FloatArray, lens: _Lens, starts: _Index) -> Surfels:
    """Merges the groups of members that begin at ``starts``."""
    counts = np.diff(starts, append=len(members))
    group = np.repeat(np.arange(len(starts)), counts)
    result = _Moments.of(members, lens, group).surfels(lens)
    alone = counts == 1
    arrays = result.arrays()
    for name in SURFEL_SHAPES:
        arrays[name][alone] = getattr(members, name)[starts[alone]]
    return _pushed(Surfels(**arrays), np.bincount(group, push) / counts, lens)


def _pushed(surfels: Surfels, push: DoubleArray, lens: _Lens) -> Surfels:
    """Moves surfels away along their rays, by a parallax (n,), with footprints kept."""
    inverse = 1 / lens.view.depth_ratio(surfels.means).astype(np.float64)
    step = np.minimum(push / lens.focal[0], inverse / 2)
    growth = (step / (inverse - step)).astype(np.float32)[:, None]
    means = surfels.means + (surfels.means + lens.eye) * growth
    return surfels.with_(means=means, scales=surfels.scales * (1 + growth))


def _normals(quats: FloatArray) -> FloatArray:
    """Third column of R(q), (3, n)."""
    w, x, y, z = quats.T
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def _tangents(quats: _Floats) -> tuple[_Floats, _Floats]:
    """First two columns of R(q), (3, n) each."""
    w, x, y, z = quats.T
    t1 = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    return t1, np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])


@dataclass(frozen=True, eq=False)
class _Moments:
    """What is left of groups: weighted means over their members, k groups.

    Attributes:
        means: p, (k, 3).
        normals: n, (3, k), not unit.
        colors: c, (k, 3).
        covariance: Cov, (3, k): xx, xy, yy, px^2.
        opacities: (k,) means of o_i, weighted by a_i.
        areas: (k,) sums of a_i, px^2.
        fading: (2, k) means of s_native and m.
    """

    means: DoubleArray
    normals: DoubleArray
    colors: DoubleArray
    covariance: DoubleArray
    opacities: DoubleArray
    areas: DoubleArray
    fading: DoubleArray

    @classmethod
    def of(cls, members: Surfels, lens: _Lens, group: _Index) -> "_Moments":
        points, footprint, area = _footprints(members, lens)
        weight = area * np.maximum(members.opacities, np.float32(OPACITY_MIN))
        areas, total = (np.bincount(group, w).astype(np.float64) for w in (area, weight))

        def mean(columns: _Floats) -> DoubleArray:
            return np.stack([np.bincount(group, weight * c) for c in columns]) / total

        offset = points - mean(points)[:, group].astype(np.float32)
        dx, dy = offset * np.float32(np.sqrt(SPREAD))
        normals = _normals(members.quats)
        away = _dot(normals, (members.means + lens.eye).T) > 0
        return cls(
            means=mean(members.means.T).T,
            normals=mean(np.where(away, -normals, normals)),
            colors=mean(members.colors.T).T,
            covariance=mean(footprint + np.stack([dx * dx, dx * dy, dy * dy])),
            opacities=total / areas,
            areas=areas,
            fading=mean(np.stack([members.native_scales, members.coverage])),
        )

    def surfels(self, lens: _Lens) -> Surfels:
        """Surfels whose footprints in the creating camera are Cov."""
        normals = self.normals / np.maximum(np.sqrt(_dot(self.normals, self.normals)), 1e-12)
        means = self.means.astype(np.float32)
        base = _quats_facing(normals)
        variances = _on_planes(self.covariance, base, means, lens)
        turn, long, short = _principal(*variances)
        xx, xy, yy = self.covariance
        fill = self.areas / np.sqrt(np.maximum(xx * yy - xy * xy, 1e-12))
        arrays = {
            "quats": _turned(base, turn),
            "scales": np.stack([np.minimum(long, short / COS_TILT_MIN), short], axis=1),
            "opacities": _filled(self.opacities, fill),
            "colors": self.colors,
            "native_scales": self.fading[0],
            "coverage": self.fading[1],
        }
        return Surfels(means=means, **{k: v.astype(np.float32) for k, v in arrays.items()})


def _footprints(surfels: Surfels, lens: _Lens) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Image positions (2, n), Cov as xx, xy, yy (3, n), and the products of deviations (n,), px."""
    points, ratio = lens.view.project(surfels.means), lens.view.depth_ratio(surfels.means)
    t1, t2 = _tangents(surfels.quats)
    ux, uy = lens.moved_px(t1 * surfels.scales[:, 0], points, ratio)
    vx, vy = lens.moved_px(t2 * surfels.scales[:, 1], points, ratio)
    covariance = np.stack([ux * ux + vx * vx, ux * uy + vx * vy, uy * uy + vy * vy])
    return points.T, covariance, np.abs(ux * vy - uy * vx) + np.float32(1e-6)


def _filled(opacities: DoubleArray, fill: DoubleArray) -> DoubleArray:
    """Opacities of groups whose members' areas are ``fill`` times the merged one.

    Coincident members multiply their transmittances.  Where there are gaps, the square root lies
    between their fill, which lets silhouettes leak, and 1, which fattens them: it measured best.
    """
    together = -np.expm1(np.log1p(-np.minimum(opacities, ALPHA_MAX)) * np.maximum(fill, 1))
    o = np.where(fill < 1, opacities * np.sqrt(fill), together)
    return np.clip(o, OPACITY_MIN, ALPHA_MAX)


def _quats_facing(normals: DoubleArray) -> DoubleArray:
    """Quaternions (k, 4) that turn z to unit normals (3, k): half a turn about x, then the shortest.

    Normals point towards the camera, to -z, from where the shortest turn is well defined.
    """
    x, y, z = normals
    quats = np.stack([-y, np.maximum(1 - z, 1e-6), np.zeros_like(x), x], axis=1)
    return quats / np.sqrt((quats * quats).sum(1, keepdims=True))


def _on_planes(covariance: DoubleArray, base: DoubleArray, means: FloatArray, lens: _Lens) -> DoubleArray:
    """Variances (3, k) along the first two axes of ``base`` that look like a covariance in the image."""
    points, ratio = lens.view.project(means), lens.view.depth_ratio(means)
    first, second = _tangents(base)
    ux, uy = lens.moved_px(first, points, ratio)
    vx, vy = lens.moved_px(second, points, ratio)
    det = ux * vy - uy * vx
    least = (COS_TILT_MIN / ratio) ** 2
    det = np.copysign(np.maximum(np.abs(det), least), det)
    a, b, c, d = vy / det, -vx / det, -uy / det, ux / det  # plane from px
    xx, xy, yy = covariance
    along = a * a * xx + 2 * a * b * xy + b * b * yy
    mixed = a * c * xx + (a * d + b * c) * xy + b * d * yy
    return np.stack([along, mixed, c * c * xx + 2 * c * d * xy + d * d * yy])


def _principal(xx: DoubleArray, xy: DoubleArray, yy: DoubleArray) -> tuple[DoubleArray, ...]:
    """Angle of the long axis, and the standard deviations along it and across; (k,) each."""
    middle, swing = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    long = np.maximum(middle + swing, 1e-12)
    short = np.maximum((xx * yy - xy * xy) / long, 1e-12)  # middle - swing would cancel
    return 0.5 * np.arctan2(2 * xy, xx - yy), np.sqrt(long), np.sqrt(short)


def _turned(quats: DoubleArray, angle: DoubleArray) -> DoubleArray:
    """Quaternions (k, 4) after a turn about their own third axis."""
    w, x, y, z = quats.T
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    return np.stack([w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s], axis=1)
