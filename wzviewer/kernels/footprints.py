"""Surfels of one set to rows of a frame, in one pass: project, weigh, key.

A frame starts few parallel loops: on a busy machine each of them waits until every core has a moment.
So the pieces of a set go through all steps in one loop, a task of at most 4096 surfels at a time.
"""

import numba
import numpy as np
from numpy.typing import NDArray

from wzviewer.core.types import FloatArray
from wzviewer.kernels.binning import Indices, depth_bits
from wzviewer.kernels.elementary import ONE, ZERO
from wzviewer.kernels.opacity import weigh_range
from wzviewer.kernels.projection import CULLED, drop_small, may_be_seen, project_range

TASK_SURFELS = 1024
PLAIN, BY_CAMERAS, GIVEN = 0, 1, 2  # where the weights of a task come from
_REACH_UNLIMITED_PX = 1e30

Seen = NDArray[np.bool_]
Places = NDArray[np.int64]
Tasks = NDArray[np.int64]  # (tasks, 4): first and last surfel, row of the first, kind of weights


def tasks_of(pieces: list[tuple[slice, int]], row: int) -> Tasks:
    """Cuts pieces of a set into tasks.

    Args:
        pieces: (surfels, kind of weights).
        row: where the first surfel of the first piece goes; the others follow.
    """
    tasks = []
    for piece, kind in pieces:
        starts = np.arange(piece.start, piece.stop, TASK_SURFELS)
        stops = np.minimum(starts + TASK_SURFELS, piece.stop)
        kinds = np.full(len(starts), kind)
        tasks.append(np.stack([starts, stops, row + starts - piece.start, kinds], 1))
        row += piece.stop - piece.start
    return np.concatenate(tasks) if tasks else np.empty((0, 4), np.int64)


def in_view(tasks: Tasks, seen: Seen, row: int) -> tuple[Tasks, Places]:
    """Leaves out tasks that touch nothing of the image, and moves the others up.

    Args:
        tasks: from `tasks_of`.
        seen: (tasks,) from `look`.
        row: where the first one goes.

    Returns:
        The tasks that are left, and by how much their rows moved up.
    """
    kept = tasks[seen]
    rows = row + np.cumsum(kept[:, 1] - kept[:, 0]) - (kept[:, 1] - kept[:, 0])
    moved = kept[:, 2] - rows
    kept[:, 2] = rows
    return kept, moved


@numba.njit(cache=True, nogil=True, parallel=True)
def look(
    means: FloatArray, scales: FloatArray, tasks: Tasks, view: FloatArray, width: int, height: int, seen: Seen
) -> None:
    """Writes which tasks may touch the image, (tasks,) bool; arguments as of `splat`."""
    for task in numba.prange(tasks.shape[0]):
        seen[task] = may_be_seen(means, scales, view, width, height, tasks[task, 0], tasks[task, 1])


@numba.njit(cache=True, nogil=True, parallel=True)
def splat(
    means: FloatArray,
    quats: FloatArray,
    scales: FloatArray,
    opacities: FloatArray,
    colors: FloatArray,
    native_scales: FloatArray,
    coverage: FloatArray,
    given: FloatArray,
    tasks: Tasks,
    view: FloatArray,
    texels: FloatArray,
    depth_row: FloatArray,
    width: int,
    height: int,
    contribution_min: float,
    rows: FloatArray,
    row_colors: FloatArray,
    row_weights: FloatArray,
    row_bits: Indices,
) -> None:
    """Carries out tasks.

    Args:
        means: (n, 3) and so on: the arrays of the set's surfels.
        quats: (n, 4).
        scales: (n, 2).
        opacities: (n,).
        colors: (n, 3).
        native_scales: (n,).
        coverage: (n,).
        given: (n,) weights of `GIVEN` tasks; (0,) where there are none.
        tasks: from `tasks_of`.
        view: (13,) from `projection.view_vector`.
        texels: from `Modulation.texels`, of `BY_CAMERAS` tasks.
        depth_row: (4,) from `core.reference.depth_row`.
        width: image width, px.
        height: image height, px.
        contribution_min: surfels whose opacity times area, px^2, is less are left out; 0 keeps all.
        rows: (>= rows, 8) written, see `projection`.
        row_colors: (>= rows, 3) written.
        row_weights: (>= rows,) written.
        row_bits: (>= rows,) written, see `binning.depth_bits`.
    """
    for task in numba.prange(tasks.shape[0]):
        first, last, row, kind = tasks[task, 0], tasks[task, 1], tasks[task, 2], tasks[task, 3]
        end = row + last - first
        project_range(
            means, quats, scales, opacities, view, width, height, _REACH_UNLIMITED_PX, rows, first, last, row
        )
        row_colors[row:end] = colors[first:last]
        if kind == BY_CAMERAS:
            weigh_range(means, native_scales, coverage, view, texels, row_weights, rows, first, last, row)
        else:
            for i in range(first, last):
                weight = given[i] if kind == GIVEN else ONE
                row_weights[row + i - first] = weight
                if weight <= ZERO:
                    rows[row + i - first, 6] = CULLED
        if contribution_min > 0.0:
            drop_small(rows, contribution_min, row, end)
        for i in range(first, last):
            row_bits[row + i - first] = depth_bits(means, depth_row, i)
