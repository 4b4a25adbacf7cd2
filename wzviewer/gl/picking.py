"""The surfel under the pointer, exactly and without the GPU: one pixel of the reference.

A drag begins with it, so it must not be felt: of a million surfels only those are projected in full
whose footprint may touch a window of seven pixels, which boxes around chunks and one cheap bound find.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from wzviewer.core.anchor import DEPTH_FLOOR
from wzviewer.core.camera import Camera
from wzviewer.core.constants import LOW_PASS_PX2
from wzviewer.core.opacity import weights
from wzviewer.core.reference import Blend, Footprints, composite, focus_of, footprints, setback
from wzviewer.core.types import BoolArray, IntArray
from wzviewer.gl.cull import EXTENT_SIGMAS, MARGIN_PX
from wzviewer.gl.order import Run
from wzviewer.gl.visible import Choice, LevelStates, Selection, select

RING_PX = (
    (0, 0),
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (3, 0),
    (-3, 0),
    (0, 3),
    (0, -3),
)  # around an empty pixel
WINDOW_PX = 7  # along a side: the ring and the pixel in its middle


def pick(
    states: LevelStates, camera: Camera, at_px: tuple[float, float], choice: Choice, blend: Blend
) -> tuple[float, int] | None:
    """Returns median depth (world units) and level at a pixel, or near it; None on emptiness."""
    left, top = (int(np.floor(at)) - WINDOW_PX // 2 for at in at_px)
    window = replace(camera, width=WINDOW_PX, height=WINDOW_PX, cx=camera.cx - left, cy=camera.cy - top)
    parts = _footprints(states, select(states, window, choice), camera, blend)
    if parts is None:
        return None
    for dx, dy in RING_PX:
        column, row = left + WINDOW_PX // 2 + dx, top + WINDOW_PX // 2 + dy
        frame = composite(parts, 1, 1, blend, left=column, top=row)
        if frame.level[0, 0] >= 0:
            return float(frame.depth[0, 0]), int(frame.level[0, 0])
    return None


def _footprints(states: LevelStates, selection: Selection, camera: Camera, blend: Blend) -> Footprints | None:
    """What may touch the window, in order, as the whole camera sees it."""
    focus = focus_of(camera, [state.level.frame for state in states.values()])
    parts = []
    for index, near in _near(selection):
        state, view = states[index], selection.views[index]
        surfels, acting = state.sets[0].surfels.take(near), selection.seen[index].modulation
        w = np.ones(len(near))
        if acting is not None:
            arrays = (surfels.means, surfels.native_scales, surfels.coverage)
            w = weights(*arrays, view, acting, blend == "transmittance").astype(np.float64)
        parts.append(
            footprints(surfels, state.level.frame, camera, w, focus, index, setback(state.level.camera))
        )
    return Footprints.concatenate(parts).ordered() if parts else None


def _near(selection: Selection) -> Iterator[tuple[int, IntArray]]:
    """Yields (level, indices) of surfels whose footprint may reach the window."""
    for run in selection.runs:
        near = _reaches(run, (selection.camera.width, selection.camera.height))
        if near.any():
            yield run.level.index, (np.flatnonzero(near) + run.piece.start).astype(np.int32)


def _reaches(run: Run, size_px: tuple[int, int]) -> BoolArray:
    """Whether a footprint may touch the image, (n,), by a bound that is never too small.

    It reaches at most ``EXTENT sigma |d p / d u|``, and ``|d p / d u| <= (|gx| + |q| |g|) / D``.
    """
    means, scales = run.columns, run.source.surfels.scales[run.piece].max(1)
    gx, gy, g = run.view.rows[:, :3].astype(np.float32)
    D = run.view.side * (np.float32(1.0) + g @ means)
    near: BoolArray = np.greater(D, DEPTH_FLOOR)
    per_D = run.view.side / np.where(near, D, np.float32(1.0))
    for row, base, size in zip((gx, gy), run.view.rows[:2, 3], size_px, strict=True):
        q = (row @ means) * per_D
        stretch = (np.linalg.norm(row) + np.abs(q) * np.linalg.norm(g)) * np.abs(per_D)
        reach = EXTENT_SIGMAS * np.hypot(scales * stretch, np.sqrt(LOW_PASS_PX2)) + MARGIN_PX
        near &= np.abs(q + np.float32(base - 0.5 * size)) <= reach + 0.5 * size
    return near
