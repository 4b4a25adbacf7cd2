"""Loops compiled by numba for the CPU at hand: no GL, no torch, shared by the worker and the renderer.

::

    image, relief ── lifting.lift ──► Surfels
                                         │
    means, quats, scales, opacities ◄────┘   one row a surfel, level-local
          │ projection.project_range         screen centre, conic, opacity, half extents
          ▼
    projected (n, 8) ── binning.depth_keys ──► sort ──► order       front to back, once per view
          │ binning.bin_tiles                lists of 8x8 tiles, each front to back
          ▼
    starts, members ── forward.composite ──► image, transmittance
          │            forward.median_relief ──► depth where the transmittance crosses 0.5
          │ loss.ssim_partials, loss.loss_gradient      0.8 L1 + 0.2 D-SSIM against a target
          ▼
    backward.accumulate ──► dL/d(conic, opacity) ── chain.chain_range ──► dL/d(quat, log scale, x)
                                                         │ adam.adam_range, both in stepping.descend
                                                         ▼
                                                    the next quats, scales, opacities

A tile is walked surfel by surfel and a row of eight pixels at a time, so that one row is one vector
register and no list per pixel is ever built.  Every parallel loop has a fixed partition and every
float sum a fixed order: the bytes do not depend on the number of threads.
"""

from pathlib import Path

from wzviewer.kernels.freshness import drop_stale

drop_stale(Path(__file__).parent)
