"""The first run of an installation compiles the kernels, later ones load them: both make the same bytes."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
OPTIMISE = """
import hashlib
import numpy as np
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.worker.stages.stage3_surfel_generation import generate_surfels
from wzviewer.worker.stages.stage5_optimization import optimize

rng = np.random.default_rng(3)
image = rng.random((72, 96, 3), np.float32)
relief = (3 * rng.standard_normal((72, 96))).astype(np.float32)
camera = Camera.initial(96, 72)
surfels = optimize(generate_surfels(image, relief, camera), image, camera, LevelFrame.of_camera(camera, 1.0))
print(hashlib.sha256(b"".join(a.tobytes() for a in surfels.arrays().values())).hexdigest())
"""


def test_the_first_run_makes_the_bytes_of_all_later_ones(tmp_path):
    runs = [
        subprocess.run(
            [sys.executable, "-c", OPTIMISE],
            capture_output=True,
            text=True,
            check=True,
            cwd=ROOT,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        ).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1]
