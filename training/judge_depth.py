"""Shows and measures what the depth estimator says about photos.

    python training/judge_depth.py --out DIR [--weights FILE] [--truth DIR] PHOTO [PHOTO ...]

Writes one strip a photo (photo | inverse depth, blue = sky | orbit -8 | orbit +8, magenta = nothing there)
and prints scale-and-shift-invariant AbsRel and delta1 (both fitted in inverse depth) beside two estimates
that look at no picture: the row ramp, and the best plane through the truth itself.
"""

import argparse
import time
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from safetensors.torch import load_file
from train_depth import started_from

from wzviewer.core.camera import Camera
from wzviewer.worker.models.builtin.depth import DepthEstimator, depth_from_reading
from wzviewer.worker.models.builtin.views import mesh

FloatArray = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
SIZE = (1088, 720)
FOCAL_PX = 1024.0
TEAR_PX = 4.0
ASSETS = Path(__file__).parents[1] / "assets"


def estimator_with(weights: Path | None) -> DepthEstimator:
    """The packaged estimator, or the same with other weights."""
    estimator = DepthEstimator()
    if weights is not None:
        estimator._network.load_state_dict(started_from(load_file(str(weights))))
    return estimator


def picture(path: Path, size: tuple[int, int] | None = SIZE) -> FloatArray:
    """(h, w, 3) sRGB 0..1, cropped about its centre to the aspect of `size` and resized."""
    image = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    if size is not None:
        h, w = image.shape[:2]
        width, height = min(w, h * size[0] // size[1]), min(h, w * size[1] // size[0])
        top, left = (h - height) // 2, (w - width) // 2
        image = cv2.resize(image[top : top + height, left : left + width], size, interpolation=cv2.INTER_AREA)
    return (image / np.float32(255)).astype(np.float32)


def orbited(image: FloatArray, depth: FloatArray, yaw_deg: float) -> FloatArray:
    """The picture as a torn mesh, turned about the point at depth 1 in its centre; magenta = nothing."""
    h, w = depth.shape
    camera = Camera(np.eye(4), FOCAL_PX, FOCAL_PX, w / 2, h / 2, w, h)
    view = mesh.OrbitView.of(camera, mesh.rotation_of(yaw_deg, 0.0)).parameters()
    projected = mesh.project_grid(((depth - 1) * FOCAL_PX).astype(np.float32), (0, 0), 1, view)
    color = np.zeros((h, w, 3), np.float32)
    color[:] = (1, 0, 1)
    nearest = np.full((h, w), mesh.EMPTY, np.float32)
    mesh.draw_grid(image, projected, np.ones((h, w), bool), TEAR_PX, color, nearest)
    return color


def strip(image: FloatArray, estimator: DepthEstimator, height: int) -> FloatArray:
    """The four pictures of the module docstring beside each other."""
    reading = estimator.read(image)
    depth = depth_from_reading(reading)
    shade = (np.clip(reading.disparity / np.percentile(reading.disparity, 99), 0, 1) * 255).astype(np.uint8)
    colored = cv2.applyColorMap(shade, cv2.COLORMAP_INFERNO)[..., ::-1] / np.float32(255)
    colored[reading.sky] = (0.15, 0.35, 0.9)
    parts = [image, colored, orbited(image, depth, -8), orbited(image, depth, 8)]
    size = (round(image.shape[1] * height / image.shape[0]), height)
    return np.hstack([cv2.resize(p, size, interpolation=cv2.INTER_AREA) for p in parts])


def fitted(estimate: FloatArray, depth: FloatArray, where: BoolArray) -> tuple[float, float]:
    """AbsRel and delta1 of a disparity after the best slope and offset in inverse depth.

    Args:
        estimate: (h, w) inverse depth up to slope and offset.
        depth: (h, w) truth, any unit.
        where: (h, w) pixels that count.
    """
    e, z = estimate[where].astype(np.float64), depth[where].astype(np.float64)
    slope, offset = np.linalg.lstsq(np.stack([e, np.ones_like(e)], 1), 1 / z, rcond=None)[0]
    guess = 1 / np.maximum(slope * e + offset, 1e-3 / z.max())
    ratio = np.maximum(guess / z, z / guess)
    return float((np.abs(guess - z) / z).mean()), float((ratio < 1.25).mean())


def baselines(depth: FloatArray, where: BoolArray) -> dict[str, FloatArray]:
    """Two guesses without a picture: rows, and the plane of the true inverse depth."""
    h, w = depth.shape
    y, x = np.mgrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j].astype(np.float32)
    terms = np.stack([x[where], y[where], np.ones(int(where.sum()), np.float32)], 1)
    a, b, c = np.linalg.lstsq(terms, 1 / depth[where], rcond=None)[0]
    return {"row ramp": y, "plane of the truth": (a * x + b * y + c).astype(np.float32)}


def truths(folder: Path | None) -> list[tuple[str, FloatArray, FloatArray, BoolArray]]:
    """Name, picture, depth and where it counts: the bundled scene and pairs color_N.jpg, depth_N.png."""
    with np.load(ASSETS / "meadow_depth.npz") as stored:
        found = [("demo", picture(ASSETS / "meadow.png", None), stored["depth"], ~stored["sky"])]
    for path in sorted(folder.glob("depth_*.png")) if folder else []:
        depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.float32)
        image = picture(path.with_name(path.stem.replace("depth", "color") + ".jpg"), None)
        found.append(("rgbd", image, depth, depth > 0))
    return found


def measure(estimator: DepthEstimator, folder: Path | None) -> None:
    """Prints the means over the pictures with a truth."""
    sums: dict[str, list[tuple[float, float]]] = {}
    for name, image, depth, where in truths(folder):
        reading = estimator.read(image)
        guesses = {"estimator": np.where(reading.sky, 0, reading.disparity), **baselines(depth, where)}
        for guess, values in guesses.items():
            sums.setdefault(f"{name}: {guess}", []).append(fitted(values, depth, where))
        sums.setdefault(f"{name}: called sky, of what is not", []).append(
            (float(reading.sky[where].mean()), 0)
        )
    for name, values in sums.items():
        error, near = np.mean(values, axis=0)
        print(f"{name:38s} AbsRel {error:.3f}  d1 {near:.3f}")


def main() -> None:
    """Reads the command line, writes the strips and one sheet, prints the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("photos", nargs="*", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--weights", type=Path)
    parser.add_argument("--truth", type=Path, help="folder of color_N.jpg and depth_N.png pairs")
    parser.add_argument("--height", type=int, default=300, help="of a strip, px")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    estimator = estimator_with(arguments.weights)
    for path in [ASSETS / "meadow.png", *arguments.photos]:
        image = picture(path)
        started = time.perf_counter()
        estimator.read(image)
        print(f"{path.stem:20s} {time.perf_counter() - started:.2f} s")
        pixels = (np.clip(strip(image, estimator, arguments.height), 0, 1) * 255).astype(np.uint8)
        cv2.imwrite(
            str(arguments.out / f"{path.stem}.jpg"), pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 90]
        )
    measure(estimator, arguments.truth)


if __name__ == "__main__":
    main()
