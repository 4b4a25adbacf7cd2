"""Times wzviewer's renderer on one scene of `scenes` and prints one JSON object.

Public classes only: a scene of one level, drawn by `SurfelRenderer` with its default settings.  A
frame's time runs from before `render` until the driver has drawn it.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import scenes
from scenes import SCENES, Splats

from wzviewer import __version__
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene
from wzviewer.core.surfels import Surfels
from wzviewer.gl.context import create_context
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer


def read_cameras(folder: Path) -> list[Camera]:
    """The cameras of the sweep."""
    record = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    width, height, f = record["width_px"], record["height_px"], record["focal_px"]
    poses = [np.array(pose, np.float64) for pose in record["camera_from_world"]]
    return [Camera(pose, f, f, width / 2, height / 2, width, height) for pose in poses]


def make_scene(splats: Splats, camera: Camera) -> Scene:
    """The surfels as a finished scene of one level whose camera is the given one."""
    frame = LevelFrame.of_camera(camera, scenes.DISTANCE)
    local = (splats.means.astype(np.float64) - frame.origin) @ frame.axes.T / frame.unit
    sigmas = splats.scales[:, :2].astype(np.float64) / frame.unit
    means = local.astype(np.float32)
    native = np.exp2(AnchoredView.expand(camera, frame).log_scale(means))
    surfels = Surfels(
        means=means,
        quats=splats.quats,
        scales=sigmas.astype(np.float32),
        opacities=splats.opacities,
        colors=splats.colors,
        native_scales=native,
        coverage=np.ones(len(splats), np.float32),
    )
    size = (camera.height, camera.width)
    scene = Scene()
    image, relief = np.zeros((*size, 3), np.uint8), np.zeros(size, np.float32)
    scene.append(Level(0, None, camera, frame, surfels, image, relief))
    scene.commit(0)
    return scene


def run(renderer: SurfelRenderer, cameras: list[Camera]) -> list[float]:
    """Frame times, ms."""
    times = []
    for camera in cameras:
        began = time.perf_counter()
        renderer.render(camera)
        renderer.context.ctx.finish()
        times.append(1e3 * (time.perf_counter() - began))
    return times


def bouncing(cameras: list[Camera], length: int) -> list[Camera]:
    """There and back again through the cameras."""
    period = 2 * len(cameras) - 2
    return [cameras[min(i % period, period - i % period)] for i in range(length)]


def measure(options: argparse.Namespace) -> dict[str, object]:
    """Times the runs and writes the picture."""
    cameras = read_cameras(options.scenes)
    splats = scenes.make_splats(SCENES[options.scene])
    with create_context(options.context) as context:
        renderer = SurfelRenderer(context)
        began = time.perf_counter()
        scene = make_scene(splats, cameras[len(cameras) // 2])
        renderer.sync(scene)
        load_ms = 1e3 * (time.perf_counter() - began)
        run(renderer, cameras[:2])  # compiles what there is to compile
        total = options.warm + options.runs * options.frames
        sweep = bouncing(cameras, total)
        run(renderer, sweep[: options.warm])
        starts = range(options.warm, total, options.frames)
        times = [run(renderer, sweep[start : start + options.frames]) for start in starts]
        # Presented as it was rendered: by default almost closed surfaces are shown as closed.
        frame = renderer.render(cameras[0], RenderSettings(closed_coverage=1.0))
        picture = frame.read_color8()
        stats = frame.stats
        renderer.release()
        if options.picture:
            cv2.imwrite(str(options.picture), picture[..., ::-1])
        return {
            "version": __version__,
            "renderer": context.renderer_name,
            "size_px": [picture.shape[1], picture.shape[0]],
            "load_ms": load_ms,
            "runs_ms": times,
            "num_visible": stats.num_visible,
            "gpu_bytes": stats.gpu_bytes,
        }


def main() -> None:
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description="Times wzviewer on one scene.")
    parser.add_argument("--scene", required=True, choices=sorted(SCENES))
    parser.add_argument("--scenes", type=Path, required=True, help="folder with camera.json")
    parser.add_argument("--picture", type=Path, help="PNG to write")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--warm", type=int, default=3)
    parser.add_argument("--context", default="egl", choices=("egl", "osmesa", "auto"))
    sys.stdout.write(json.dumps(measure(parser.parse_args())) + "\n")


if __name__ == "__main__":
    main()
