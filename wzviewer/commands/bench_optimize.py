"""``bench optimize``: one step of stage 5, and the whole stage, on a full level."""

import argparse
import time
from typing import Any

import numpy as np

from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.worker.rasterize import LevelPart, render
from wzviewer.worker.stages.stage5_optimization import STEPS, optimize


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns ms of a step, seconds of the stage, and PSNR at C before and after."""
    level = chain_scene(1)[0]
    target = level.image.astype(np.float32) / np.float32(255.0)
    ticks: list[float] = []

    def on_step(step: int, total: int) -> None:
        ticks.append(time.perf_counter())

    arguments = (level.surfels, target, level.camera, level.frame)
    optimize(*arguments, steps=2, color_steps=0)  # loads the kernels
    start = time.perf_counter()
    result = optimize(*arguments, on_step=on_step)
    seconds = time.perf_counter() - start
    steps_ms = 1e3 * np.diff(ticks[: STEPS + 1])
    before, after = (
        render([LevelPart.of(s, level.frame)], level.camera, depth=False).color
        for s in (level.surfels, result)
    )
    return {
        "surfels": len(level.surfels),
        "optimize_step_ms": float(np.median(steps_ms)),
        "optimize_seconds": seconds,
        "render_psnr_db_before": psnr_db(before, target),
        "render_psnr_db": psnr_db(after, target),
    }


def psnr_db(image: Any, target: Any) -> float:  # noqa: ANN401
    """PSNR of images in [0, 1], dB."""
    error = float(np.mean((np.asarray(image, np.float64) - target) ** 2))
    return 10.0 * float(np.log10(1.0 / max(error, 1e-12)))
