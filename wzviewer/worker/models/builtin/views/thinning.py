"""Which hidden pixels are worth a surfel: those that some neighbouring camera can see."""

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.mesh import (
    EMPTY,
    OrbitView,
    rotation_of,
    splat_depth,
    visible_from,
)
from wzviewer.worker.models.builtin.views.smoothing import dilated

CELL_PX = 2.0  # of the visibility grid; two native px, so that stretched surfaces stay closed
GROW_PX = 2
SLACK_PX = 3.0
MARGIN = 0.3  # of the frame, around it: what the largest orbit moves out of sight, a smaller one shows
NEARER_SHARES = (1.0, 0.4, 0.15, 0.05)  # of the angle
DIAGONAL = 0.75  # angle of the diagonal probes relative to the straight ones


def probe_angles(angle_deg: float, wide: bool = True) -> list[tuple[float, float]]:
    """Returns (yaw, pitch) of eight probes, straight and diagonal, degrees; where not wide also nearer ones.

    Where depths differ by many times the field of view, as at deep levels, what is behind an edge is in
    sight for a small part of the orbit only, so the straight probes are repeated at smaller angles.
    """
    diagonal = DIAGONAL * angle_deg
    outer = [(x, y) for x in (-diagonal, diagonal) for y in (-diagonal, diagonal)]
    for share in (1.0,) if wide else NEARER_SHARES:
        angle = share * angle_deg
        outer += [(angle, 0.0), (-angle, 0.0), (0.0, angle), (0.0, -angle)]
    return outer


def visible_pixels(
    reliefs: list[FloatArray],
    masks: list[BoolArray],
    offset_px: tuple[int, int],
    camera: Camera,
    angle_deg: float,
) -> list[BoolArray]:
    """Finds the pixels of stacked surfaces that at least one probe camera sees.

    Args:
        reliefs: (h, w) float32 of the front and of each layer behind it, on one canvas, native px.
        masks: (h, w) bool, pixels that exist in each.
        offset_px: image pixel of the canvas origin.
        camera: the source camera.
        angle_deg: of the probes.

    Returns:
        A mask (h, w) for each surface, grown by 2 px within its own mask; the first one is whole.
    """
    margin_px = (round(MARGIN * camera.width), round(MARGIN * camera.height))
    rows, columns = camera.height + 2 * margin_px[1], camera.width + 2 * margin_px[0]
    wide = DepthAxis.of(camera).wide
    probes = [
        OrbitView.of(camera, rotation_of(*angles)).shifted(*margin_px)
        for angles in probe_angles(angle_deg, wide)
    ]
    views = np.stack([probe.parameters() for probe in probes])
    depth = np.full((len(views), int(rows // CELL_PX) + 1, int(columns // CELL_PX) + 1), EMPTY, np.float32)
    for relief, mask in zip(reliefs, masks, strict=True):
        splat_depth(relief, mask, offset_px, views, CELL_PX, depth)
    kept = [masks[0]]
    for relief, mask in zip(reliefs[1:], masks[1:], strict=True):
        seen = visible_from(relief, mask, offset_px, views, CELL_PX, depth, SLACK_PX)
        kept.append(dilated(seen, GROW_PX) & mask)
    return kept
