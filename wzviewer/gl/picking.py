"""The surfel under the pointer, exactly and without the GPU: one pixel of the reference."""

from collections.abc import Iterator, Mapping

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.opacity import weights
from wzviewer.core.reference import Blend, Footprints, composite, focus_of, footprints
from wzviewer.core.types import IntArray
from wzviewer.gl.cull import MARGIN_PX
from wzviewer.gl.visible import LevelState, Selection

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


def pick(
    states: Mapping[int, LevelState],
    selection: Selection,
    camera: Camera,
    at_px: tuple[float, float],
    blend: Blend,
) -> tuple[float, int] | None:
    """Returns median depth (world units) and level at a pixel, or near it; None on emptiness."""
    for dx, dy in RING_PX:
        column, row = int(np.floor(at_px[0])) + dx, int(np.floor(at_px[1])) + dy
        parts = _footprints_at(states, selection, camera, (column + 0.5, row + 0.5), blend)
        frame = composite(parts.ordered(), 1, 1, blend, left=column, top=row) if parts else None
        if frame is not None and frame.level[0, 0] >= 0:
            return float(frame.depth[0, 0]), int(frame.level[0, 0])
    return None


def _footprints_at(
    states: Mapping[int, LevelState],
    selection: Selection,
    camera: Camera,
    at_px: tuple[float, float],
    blend: Blend,
) -> Footprints | None:
    focus = focus_of(camera, [state.level.frame for state in states.values()])
    parts = []
    for index, near in _near(selection, at_px):
        state, view = states[index], selection.views[index]
        surfels, acting = state.sets[0].surfels.take(near), selection.seen[index].modulation
        w = np.ones(len(near))
        if acting is not None:
            arrays = (surfels.means, surfels.native_scales, surfels.coverage)
            w = weights(*arrays, view, acting, blend == "transmittance").astype(np.float64)
        parts.append(footprints(surfels, state.level.frame, camera, w, focus, index))
    return Footprints.concatenate(parts) if parts else None


def _near(selection: Selection, at_px: tuple[float, float]) -> Iterator[tuple[int, IntArray]]:
    """Yields (level, indices) of surfels whose footprint may reach the pixel."""
    for run in selection.runs:
        means = run.columns.T
        D = 1.0 + means @ run.view.rows[2, :3].astype(np.float32)
        near = np.abs(D) > 0
        for row, at in zip(run.view.rows[:2], at_px, strict=True):
            offset = means @ row[:3].astype(np.float32) - np.float32(at - row[3]) * D
            near &= np.abs(offset) <= np.float32(selection.radius_px + MARGIN_PX) * np.abs(D)
        if near.any():
            yield run.level.index, (np.flatnonzero(near) + run.piece.start).astype(np.int32)
