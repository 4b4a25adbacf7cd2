"""The two scenes that every program is timed on, and the files that they read.

A box of round, flat surfels that face the camera: uniform positions, opacity 0.6, seeded.  The near
half of the box is blue with a white disc at the upper left, the far half orange with dark stripes, so
a mirrored, turned or badly sorted picture looks wrong.

World axes are OpenCV's (x right, y down, z forward), as in the PLY files of 3D Gaussian splatting.

    python benchmarks/scenes.py OUT    writes OUT/{200k,1m}.{ply,splat} and OUT/camera.json
"""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
DoubleArray = NDArray[np.float64]

WIDTH_PX, HEIGHT_PX, FOCAL_PX = 1280, 720, 1024.0
DISTANCE = 4.0  # from the camera to the middle of the box, which is the world's origin
HALF_BOX = (2.25, 1.265625, 0.4)  # its nearest face just fills the image
OPACITY = 0.6
SIGMAS_PER_DIAMETER = 6.0  # a footprint's diameter is counted at 3 standard deviations
THICKNESS = 1e-5  # standard deviation along the normal: flat, and above what the peers clamp at
STEP_DEG = 1.0  # orbit per frame: enough that each peer sorts anew by its own rules
NUM_POSES = 25  # -12 to +12 degrees
SH_BAND_0 = 0.28209479177387814  # Y_00: colour = 1/2 + Y_00 f_dc
WRITE_ROWS = 1 << 18  # rows per piece of a file

BLUE, PALE_BLUE = np.array([[0.05, 0.25, 0.45], [0.25, 0.75, 0.85]])
ORANGE, BROWN, WHITE = np.array([[0.95, 0.5, 0.1], [0.35, 0.12, 0.05], [0.95, 0.95, 0.9]])


@dataclass(frozen=True)
class SceneSpec:
    """What a scene is made of.

    Attributes:
        name: of its files.
        num_surfels: how many.
        diameter_px: of a footprint at the middle of the box.
        seed: of the positions and colours.
    """

    name: str
    num_surfels: int
    diameter_px: float
    seed: int = 1


SCENES = {spec.name: spec for spec in (SceneSpec("200k", 200_000, 10.0), SceneSpec("1m", 1_000_000, 5.0))}


@dataclass(frozen=True, eq=False)
class Splats:
    """Surfels as three-axis Gaussians; all float32.

    Attributes:
        means: (n, 3), world units.
        scales: (n, 3), standard deviations, world units; the third is `THICKNESS`.
        quats: (n, 4) wxyz.
        opacities: (n,), [0, 1].
        colors: (n, 3), sRGB-encoded [0, 1].
    """

    means: FloatArray
    scales: FloatArray
    quats: FloatArray
    opacities: FloatArray
    colors: FloatArray

    def __len__(self) -> int:
        return len(self.means)


def make_splats(spec: SceneSpec) -> Splats:
    """Returns the surfels of a scene; equal for equal specs."""
    rng = np.random.default_rng(spec.seed)
    n = spec.num_surfels
    means = (rng.uniform(-1.0, 1.0, (n, 3)) * np.array(HALF_BOX)).astype(np.float32)
    sigma = spec.diameter_px / SIGMAS_PER_DIAMETER * DISTANCE / FOCAL_PX
    scales = np.tile(np.array([sigma, sigma, THICKNESS], np.float32), (n, 1))
    quats = np.tile(np.array([1, 0, 0, 0], np.float32), (n, 1))
    jitter = rng.uniform(-0.05, 0.05, (n, 3)).astype(np.float32)
    colors = np.clip(_pattern(means) + jitter, 0.0, 1.0).astype(np.float32)
    return Splats(means, scales, quats, np.full(n, OPACITY, np.float32), colors)


def _pattern(means: FloatArray) -> FloatArray:
    x, y, z = (means / np.array(HALF_BOX, np.float32)).T
    ramp = (0.5 + 0.5 * x)[:, None]
    near = (1 - ramp) * BLUE + ramp * PALE_BLUE
    disc = np.hypot(16 / 9 * (x + 0.55), y + 0.45) < 0.35
    near = np.where(disc[:, None], WHITE, near)
    stripes = np.sin(12.0 * (x + 0.5 * y)) > 0.5
    far = np.where(stripes[:, None], BROWN, ORANGE)
    return np.where((z < 0)[:, None], near, far).astype(np.float32)


# ------------------------------------------------------------------ camera


def orbit_poses() -> DoubleArray:
    """camera_from_world of each frame, (NUM_POSES, 4, 4): an orbit about the world's vertical axis."""
    poses = np.tile(np.eye(4), (NUM_POSES, 1, 1))
    for pose, step in zip(poses, range(NUM_POSES), strict=True):
        angle = np.radians(STEP_DEG * (step - NUM_POSES // 2))
        c, s = np.cos(angle), np.sin(angle)
        pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        pose[2, 3] = DISTANCE  # the origin stays in the middle of the image
    return poses


def camera_record() -> dict[str, Any]:
    """The camera as every program reads it."""
    return {
        "axes": "OpenCV: x right, y down, z forward; row-major matrices",
        "width_px": WIDTH_PX,
        "height_px": HEIGHT_PX,
        "focal_px": FOCAL_PX,
        "near": 0.1,
        "far": 100.0,
        "target": [0.0, 0.0, 0.0],
        "camera_from_world": orbit_poses().tolist(),
    }


# ------------------------------------------------------------------ files


def write_ply(path: Path, splats: Splats, num_rest: int = 0) -> None:
    """Writes a binary little-endian PLY in the layout of 3D Gaussian splatting (Kerbl et al. 2023).

    Args:
        path: to write.
        splats: stored as logarithms of the standard deviations, logits and band 0.
        num_rest: zero coefficients of the higher bands; 45 for readers that insist.
    """
    names = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"]
    names += [f"f_rest_{i}" for i in range(num_rest)]
    names += ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(splats)}"]
    header += [f"property float {name}" for name in names] + ["end_header\n"]
    rows = np.zeros((len(splats), len(names)), "<f4")
    rows[:, 0:3] = splats.means
    rows[:, 6:9] = (splats.colors - 0.5) / SH_BAND_0
    rows[:, -8] = np.log(splats.opacities / (1 - splats.opacities))
    rows[:, -7:-4] = np.log(splats.scales)
    rows[:, -4:] = splats.quats
    _write(path, "\n".join(header).encode("ascii"), rows)


SPLAT_DTYPE = np.dtype([("mean", "<f4", 3), ("sigmas", "<f4", 3), ("rgba", "u1", 4), ("quat", "u1", 4)])


def write_splat(path: Path, splats: Splats) -> None:
    """Writes a ``.splat`` file: 32 bytes a surfel, no header, quaternions as bytes 128 q + 128."""
    rows = np.zeros(len(splats), SPLAT_DTYPE)
    rows["mean"], rows["sigmas"] = splats.means, splats.scales
    rows["rgba"][:, :3] = np.rint(255 * splats.colors)
    rows["rgba"][:, 3] = np.rint(255 * splats.opacities)
    rows["quat"] = np.clip(np.rint(128 * splats.quats + 128), 0, 255)
    _write(path, b"", rows)


def _write(path: Path, header: bytes, rows: NDArray[Any]) -> None:
    partial = path.with_name(path.name + ".part")
    with partial.open("wb") as file:
        file.write(header)
        for start in range(0, len(rows), WRITE_ROWS):
            file.write(rows[start : start + WRITE_ROWS].tobytes())
    partial.replace(path)


def write_scene(folder: Path, spec: SceneSpec) -> None:
    """Writes the files of a scene and the camera, unless they are there."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "camera.json").write_text(json.dumps(camera_record()), encoding="utf-8")
    ply, splat = folder / f"{spec.name}.ply", folder / f"{spec.name}.splat"
    stamp = folder / f"{spec.name}.json"
    recipe = json.dumps([repr(spec), HALF_BOX, OPACITY, DISTANCE, THICKNESS])
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == recipe and ply.is_file() and splat.is_file():
        return
    splats = make_splats(spec)
    write_ply(ply, splats)
    write_splat(splat, splats)
    stamp.write_text(recipe, encoding="utf-8")


def main() -> None:
    """Writes both scenes."""
    parser = argparse.ArgumentParser(description="Writes the scenes that the programs are timed on.")
    parser.add_argument("out", type=Path, help="folder")
    options = parser.parse_args()
    for spec in SCENES.values():
        write_scene(options.out, spec)


if __name__ == "__main__":
    main()
