"""Depth of one photograph without a download.

picture -> network (two sizes, mirrored) -> sky rules and outline ----+
                  |                     -> close-up? focus reading    |
                  v                                                   v
              disparity -> smooth -> planes per segment -> snapped steps -> `DepthReading`

network     the U-Net                     sky      where nothing is
macro       focus as depth                refine   segments, planes, steps
grid        what a view may train         estimator   the public face
"""

from wzviewer.worker.models.builtin.depth.estimator import (
    DepthEstimator,
    DepthReading,
    depth_from_reading,
)

__all__ = ["DepthEstimator", "DepthReading", "depth_from_reading"]
