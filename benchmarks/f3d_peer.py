"""Times f3d (https://f3d.app) on one scene and prints one JSON object.

Runs in an environment of its own that has f3d, with nothing but the standard library besides.
A frame's time runs until its pixels are here, so what the software driver had to draw is in it.
"""

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path
from typing import Any

import f3d  # type: ignore[import-not-found]


def make_engine(scene: Path, camera: dict[str, Any], blending: str) -> Any:  # noqa: ANN401  f3d has no types
    """Loads a ``.splat`` file into an off-screen EGL engine."""
    engine = f3d.Engine.create_egl()
    engine.window.size = (camera["width_px"], camera["height_px"])
    settings = {
        "model.point_sprites.type": "gaussian",
        "model.point_sprites.size": 1.0,
        "model.point_sprites.absolute_size": True,  # the standard deviations of the file as they are
        "model.coloring": "direct",
        "render.effect.blending.mode": blending,
        "render.background.color": [0.0, 0.0, 0.0],
    }
    for name, value in settings.items():
        engine.options[name] = value
    engine.scene.add(str(scene))
    engine.window.camera.view_angle = math.degrees(
        2 * math.atan(camera["height_px"] / 2 / camera["focal_px"])
    )
    return engine


def place(engine: Any, pose: list[list[float]]) -> None:  # noqa: ANN401
    """Moves the camera to a camera_from_world (OpenCV axes)."""
    R = [row[:3] for row in pose[:3]]
    t = [row[3] for row in pose[:3]]
    position = [-sum(R[i][k] * t[i] for i in range(3)) for k in range(3)]
    camera = engine.window.camera
    camera.position = position
    camera.focal_point = [position[k] + 4.0 * R[2][k] for k in range(3)]
    camera.view_up = [-R[1][k] for k in range(3)]


def run(engine: Any, poses: list[list[list[float]]]) -> list[float]:  # noqa: ANN401
    """Frame times, ms."""
    times = []
    for pose in poses:
        began = time.perf_counter()
        place(engine, pose)
        engine.window.render_to_image()
        times.append(1e3 * (time.perf_counter() - began))
    return times


def bouncing(index: int, count: int) -> int:
    """There and back again through ``count`` poses."""
    at = index % (2 * count - 2)
    return min(at, 2 * count - 2 - at)


def main() -> None:
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description="Times f3d on one scene.")
    parser.add_argument("--scene", required=True, help="name of the scene's files")
    parser.add_argument("--scenes", type=Path, required=True, help="folder of the scenes")
    parser.add_argument("--picture", type=Path, help="PNG to write")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--warm", type=int, default=3)
    parser.add_argument("--blending", default="sort", choices=("sort", "sort_cpu"))
    options = parser.parse_args()
    camera = json.loads((options.scenes / "camera.json").read_text(encoding="utf-8"))
    began = time.perf_counter()
    engine = make_engine(options.scenes / f"{options.scene}.splat", camera, options.blending)
    load_ms = 1e3 * (time.perf_counter() - began)
    poses = camera["camera_from_world"]
    total = options.warm + options.runs * options.frames
    sweep = [poses[bouncing(i, len(poses))] for i in range(total)]
    run(engine, sweep[: options.warm])
    starts = range(options.warm, total, options.frames)
    times = [run(engine, sweep[start : start + options.frames]) for start in starts]
    place(engine, poses[0])
    picture = engine.window.render_to_image()
    if options.picture:
        picture.save(str(options.picture))
    record = {
        "version": f3d.__version__,
        "renderer": f"EGL, blending {options.blending}",
        "size_px": [picture.width, picture.height],
        "load_ms": load_ms,
        "runs_ms": times,
    }
    sys.stdout.write(json.dumps(record) + "\n")
    sys.stdout.flush()
    os._exit(0)  # some builds crash while they take their context down


if __name__ == "__main__":
    main()
