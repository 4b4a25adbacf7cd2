"""Constants of the image formation, shared by every renderer and injected into GLSL.

They are frozen together: a surfel must look the same in the reference, the differentiable
rasteriser and the shaders.
"""

ALPHA_CUT = 1.0 / 255.0  # below this a fragment is not drawn; tested before the Eq. 3 weight
SETBACK_PX = 4.0  # native px: so much a level gives way to finer ones, where both are as deep
ALPHA_MAX = 0.99  # no surfel is fully opaque, so the transmittance stays invertible
WEIGHT_MIN = 1e-4  # of Eq. 3: below it even alpha .99 adds less than an eighth of 1/255
LOW_PASS_PX2 = 0.02  # added to both diagonal entries of the screen covariance
SURFEL_SIGMA_PX = 0.55  # standard deviation of a new surfel, native pixels (the paper: 0.7)
SURFEL_OPACITY = 0.99  # of a new surfel (the paper: 0.1, then 100 steps of Adam)
OPACITY_MIN, OPACITY_MAX = 1e-4, 0.995  # range that the optimiser may use
COS_TILT_MIN = 0.1  # a surfel seen edge-on is stretched at most tenfold
TRANSMITTANCE_STOP = 1e-4  # front to back only: what lies behind is invisible at 8 bits
ZOOM_FACTOR = 8.0  # focal length of a new level, relative to its parent
FOCAL_PX, IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX = 1024.0, 1088, 720  # the paper's first camera
COVERAGE_FEATHER = 0.04  # of the shorter image side: where a child fades into its parent
FEATHER_MIN_PX = 3.5 * ZOOM_FACTOR  # the same, at least: three and a half pixels of the parent
PARENT_REACH_PX = 15.0  # of a parent's surfel, px of the child: where its alpha falls below ALPHA_CUT
SKY_DEPTH = 36.7  # world units, where the median depth of E_0 is 1
MAX_LEVELS = 256  # in one scene
