"""What stands is put on a surface that faces up: the nearest one to where it was asked for.

The depth of a picture may have a wall, or nothing but one slanting sheet, where a chair meets the floor.
Feet in the middle of that hover over what is seen from any other side.
"""

import cv2
import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.objects.placement import MARGIN, Support

_THUMB_PX = 192
_LYING = 0.68  # relief falls by .93 px a px of height or more: seen from 47 degrees or flatter
_FLAT = 0.90  # faces up without doubt
_REACH = 0.55  # of the body's width: farther is another place
_FOOT = 0.10  # of the body's width: the surface it needs, to each side
_UPHILL = 1.8  # how much farther up is than down: what is below a body catches it


def lying(support: Support) -> FloatArray:
    """Returns (h, w) of a thumbnail: -1 (overhead) to 1 (faces up); 0 where unknown and in the sky."""
    h, w = support.relief.shape
    ratio = min(_THUMB_PX / w, 1.0)
    size = (max(round(w * ratio), 8), max(round(h * ratio), 8))
    known = np.isfinite(support.relief)
    if support.sky is not None:
        known = known & ~support.sky
    relief = np.where(known, support.relief, 0).astype(np.float32) * np.float32(ratio)
    share = cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    small = cv2.resize(relief, size, interpolation=cv2.INTER_AREA) / np.maximum(share, 1e-3)
    smooth = cv2.GaussianBlur(small, (0, 0), 1.5)
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0) / 8, cv2.Sobel(smooth, cv2.CV_32F, 0, 1) / 8
    faces = -gy / np.sqrt(gx**2 + gy**2 + 1)
    return np.where(cv2.erode(share, np.ones((3, 3), np.uint8)) > 0.99, faces, 0).astype(np.float32)


def footing(support: Support, foot: tuple[float, float], width_px: float) -> tuple[float, float]:
    """Returns how far to move a body, (x, y) px, so that its foot is on something that faces up.

    Nothing if it is already, or if there is nothing of that kind close by.

    Args:
        support: relief of the view.
        foot: (x, y) px, where the body stands.
        width_px: of the body.
    """
    faces = lying(support)
    ratio = faces.shape[1] / support.relief.shape[1]
    spread = max(_FOOT * width_px * ratio, 0.8)
    stands = cv2.GaussianBlur((faces > _LYING).astype(np.float32), (0, 0), spread) > 0.6
    rows, columns = np.mgrid[: faces.shape[0], : faces.shape[1]]
    across, down = (columns + 0.5) / ratio - foot[0], (rows + 0.5) / ratio - foot[1]
    far = np.hypot(across, np.where(down < 0, _UPHILL * down, down))
    far += width_px * np.clip(_FLAT - cv2.GaussianBlur(faces, (0, 0), spread), 0, 1)
    far[~stands | (rows + 0.5 > (1 - MARGIN) * len(rows)) | (far > _REACH * width_px)] = np.inf
    y, x = np.unravel_index(int(np.argmin(far)), far.shape)
    if not np.isfinite(far[y, x]) or max(abs(across[y, x]), abs(down[y, x])) < 1.0 / ratio:
        return 0.0, 0.0
    return float(across[y, x]), float(down[y, x])
