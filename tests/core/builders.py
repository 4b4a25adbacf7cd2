"""Small scenes for the tests of core, files and worker."""

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.assembly import finished
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene, StageRecord, coverage_for
from wzviewer.core.surfels import Surfels


def random_surfels(n: int, seed: int = 0) -> Surfels:
    rng = np.random.default_rng(seed)
    means = (rng.random((n, 3)) - 0.5) * [64, 48, 4]
    scales = rng.random((n, 2)) + 0.3
    quats = rng.normal(size=(n, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    ones = np.ones(n)
    return Surfels(means, quats, scales, rng.random(n), rng.random((n, 3)), ones, ones)


def small_level(scene: Scene, parent: int | None, camera: Camera, n: int = 50, seed: int = 0) -> Level:
    rng = np.random.default_rng(seed)
    frame = LevelFrame.of_camera(camera, 1.0)
    surfels = random_surfels(n, seed)
    surfels = surfels.with_(coverage=coverage_for(scene, parent, camera, frame, surfels.means))
    shape = (camera.height, camera.width)
    return Level(
        index=len(scene),
        parent=parent,
        camera=camera,
        frame=frame,
        surfels=finished(surfels, camera, frame),
        image=rng.integers(0, 256, (*shape, 3), dtype=np.uint8),
        relief=rng.normal(size=shape).astype(np.float32),
        prompt="" if parent is None else "a ladybug",
        seed=seed,
        stages={"surfels": StageRecord("builtin", 0.25)},
        maps={"labels": rng.integers(0, 9, shape, dtype=np.uint8)},
        notes={"materials": ["leaf"], "depth": parent},
    )


def small_scene(num_levels: int = 3) -> Scene:
    scene = Scene()
    camera = Camera.initial(64, 48)
    for i in range(num_levels):
        scene.append(small_level(scene, i - 1 if i else None, camera, 40 + i, i))
        scene.commit(i)
        camera = camera.zoomed_to_region(0.4, 0.6, 8.0)
    return scene
