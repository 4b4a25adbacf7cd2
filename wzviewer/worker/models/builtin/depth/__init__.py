"""Depth of one photograph without a download.

picture -> network (two sizes, mirrored) -> sky rules and outline ----+
                  |                     -> close-up? focus reading    |
                  v                                                   v
              disparity -> smooth -> upright, figures -> planes per segment -> snapped steps -> `DepthReading`

network     the U-Net                     sky      where nothing is
macro       the thing in focus            calm     what crisp edges cut off from the sky
grid        what a view may train         outline  thin things that stick out into it
upright     what stands on the ground     figures  small things that stand there, too small for it
refine      segments, planes, steps       estimator   the public face
"""

from wzviewer.worker.models.builtin.depth.estimator import (
    DepthEstimator,
    DepthReading,
    depth_from_reading,
)

__all__ = ["DepthEstimator", "DepthReading", "depth_from_reading"]
