"""What the others share: the camera, the sun, the hills, the materials."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
DoubleArray = NDArray[np.float64]
Generator = np.random.Generator

WIDTH, HEIGHT, FOCAL_PX = 1088, 720, 1024.0
SKY_DEPTH = 36.7
EYE_HEIGHT = 0.70
PITCH = np.radians(5.0)  # the camera looks this far down
SUN = np.array([0.85, 0.45, -0.16]) / np.linalg.norm([0.85, 0.45, -0.16])
NEAR, FAR = 0.80, 58.0

GROUND, GRASS, PETAL, FLORET, LEAF, FOLIAGE, WOOD, STONE = range(8)
# Ranges of hills: distance, reach along the view, least height, noise seed,
# peaks (x / z, height, width in x / z).
RANGES = (
    (27.0, 6.0, 0.25, 21.0, ((0.24, 0.9, 0.12), (-0.42, 1.1, 0.14))),
    (38.0, 5.5, 0.7, 33.0, ((0.44, 3.0, 0.17), (-0.10, 2.0, 0.12), (-0.55, 2.6, 0.14))),
    (51.0, 6.0, 1.8, 47.0, ((0.07, 3.6, 0.13), (0.24, 2.6, 0.10), (0.54, 4.2, 0.16), (-0.33, 3.6, 0.16))),
)
# Columns: share of light that passes through, strength and exponent of the highlight,
# wrap of the diffuse term.
MATERIALS = np.array(
    [
        [0.00, 0.00, 8.0, 0.10],
        [0.42, 0.16, 24.0, 0.10],
        [0.40, 0.03, 14.0, 0.04],
        [0.15, 0.05, 16.0, 0.20],
        [0.30, 0.14, 22.0, 0.10],
        [0.30, 0.02, 12.0, 0.25],
        [0.08, 0.04, 12.0, 0.10],
        [0.00, 0.05, 18.0, 0.05],
    ],
    dtype=np.float32,
)
