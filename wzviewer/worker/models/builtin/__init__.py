"""Models that need no download.

::

    depth/    stage 0, 2   own small network + sky, macro and edge readings; grid that Eq. 5 tunes
    detail/   stage 1      crisp base + material texture + consistency
    objects/  stage 1      prompt grammar, signed-distance bodies, light from the photo, compositing
    views/    stage 4      background layers and padded frame by depth-aware exemplars
    relief.py stage 2      new relief from shading
    weights/               of the depth network, 3 MB
"""
