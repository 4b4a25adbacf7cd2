"""Algorithm 1 of the WonderZoom paper: line 1, and Thread 2, lines 10-32.

Five stages, each in ``stages/``, called in the paper's order.  The models behind them are the
Protocols of ``models/base.py``; ``models/builtin`` needs no weights.  A level is shown as soon as it
can be seen (`Report.level`), refined in place, and returned once it is final.
"""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Protocol

from wzviewer.core.assembly import finished
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, StageRecord
from wzviewer.core.types import ByteArray
from wzviewer.worker.levels import as_level, preview_level
from wzviewer.worker.models.base import Synthesizer
from wzviewer.worker.photograph import sharpened, with_photo
from wzviewer.worker.stages.stage0_initial_scene import flat_scene, read_scene
from wzviewer.worker.stages.stage1_new_scale_image import (
    edit_image,
    observe,
    preview_edit,
    preview_image,
    upscale_image,
)
from wzviewer.worker.steps import complete_scene, optimize_level, register_depth

STAGE_SHARE = {0: 0.25, 1: 0.35, 2: 0.15, 3: 0.05, 4: 0.15, 5: 0.3}  # of the time of a level


class Report(Protocol):
    """Where a level in the making is announced."""

    def check(self) -> None:
        """Raises `errors.Cancelled` when the request was cancelled."""

    def stage(self, stage: int, name: str, fraction: float) -> None:
        """A stage began."""

    def level(self, level: Level) -> None:
        """A complete revision of the level can be shown."""


def reconstruct_scene(
    image: ByteArray, seed: int, models: Synthesizer, report: Report, photo: ByteArray | None = None
) -> Level:
    """E_0 from a photo (line 1).

    Args:
        image: I_0, (h, w, 3) uint8 sRGB.
        seed: of every generator.
        models: the backends.
        report: told about stages and revisions.
        photo: (H, W, 3) uint8, I_0 with more pixels, if there are any; kept for the first zooms.

    Returns:
        The finished level 0.

    Raises:
        Cancelled: when the request was cancelled.
    """
    clock = StageClock(report, (0, 3, 4, 5))
    camera = Camera.initial(image.shape[1], image.shape[0])
    report.level(flat_scene(image, camera, seed))
    with clock.stage(0, "initial scene"):
        draft = read_scene(image, camera, models, seed, report.check)
    with clock.stage(3, "surfels"):
        report.level(as_level(draft, 0, None, "", seed))
    with clock.stage(4, "auxiliary views"):
        draft = complete_scene(draft, models, seed, report.check, outside=True)
    with clock.stage(5, "optimisation"):
        surfels = optimize_level(draft, report.check)
    return _finish(with_photo(as_level(draft, 0, None, "", seed, surfels), photo), clock, models, report)


def synthesize_level(
    path: Sequence[Level],
    index: int,
    camera: Camera,
    prompt: str,
    seed: int,
    models: Synthesizer,
    report: Report,
    cutout: ByteArray | None = None,
    beside: Sequence[Level] = (),
) -> Level:
    """E_{i+1}: finer content inside level i, seen by ``camera`` (lines 10-32).

    Args:
        path: the levels from the root to the parent E_i.
        index: of the new level.
        camera: C_{i+1}.
        prompt: U_{i+1}; empty for none.
        seed: of every generator.
        models: the backends.
        report: told about stages and revisions.
        cutout: (h, w, 4) uint8 sRGB and alpha, put in instead of what the prompt names; or None.
        beside: what else it will lie over, from `core.beside.levels_beside`; with a level also those
            between it and the parent.

    Returns:
        The finished level.

    Raises:
        PromptError: when the prompt or the cut-out is not understood; before any work.
        Cancelled: when the request was cancelled.
    """
    edit = models.editor.parse(prompt) if cutout is None else models.editor.insertion(cutout, prompt)
    clock = StageClock(report, (1, 2, 3, 4, 5))
    parent = path[-1].index

    with clock.stage(1, "new scale image"):
        # lines 11, 12 and 20: O, S and the target depth
        seen = sharpened(observe(path, camera, seed, report.check, beside))
        quick = preview_image(seen, models, seed)
        report.level(preview_level(quick, index, parent, prompt, seed))
        if edit:  # what was asked for is seen within a second, too
            quick = preview_edit(quick, edit, models, seed, report.check)
            report.level(preview_level(quick, index, parent, prompt, seed))
        upscaled = upscale_image(seen, models, seed, report.check)  # lines 13, 14
        draft = edit_image(upscaled, edit, models, seed, report.check)  # lines 15-19
    with clock.stage(2, "depth registration"):
        draft = register_depth(draft, models, seed, report.check)  # lines 21, 22
    with clock.stage(3, "surfels"):
        report.level(as_level(draft, index, parent, prompt, seed))  # lines 23-25
    with clock.stage(4, "auxiliary views"):
        draft = complete_scene(draft, models, seed, report.check, outside=False)  # lines 26-28
    with clock.stage(5, "optimisation"):
        surfels = optimize_level(draft, report.check)  # lines 29-31
    return _finish(as_level(draft, index, parent, prompt, seed, surfels), clock, models, report)


def _finish(level: Level, clock: "StageClock", models: Synthesizer, report: Report) -> Level:
    """Line 32: freezes the level's bytes and streams its last revision."""
    stages = {name: StageRecord(models.name, seconds) for name, seconds in clock.seconds.items()}
    surfels = finished(level.surfels, level.camera, level.frame)
    level = replace(level, stages=stages, surfels=surfels)
    report.level(level)
    return level


@dataclass
class StageClock:
    """Reports stages as they begin, and measures them."""

    report: Report
    plan: tuple[int, ...]
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, stage: int, name: str) -> Iterator[None]:
        """Announces a stage, runs the block, records its time under the stage's name."""
        done = sum(STAGE_SHARE[s] for s in self.plan[: self.plan.index(stage)])
        self.report.stage(stage, name, done / sum(STAGE_SHARE[s] for s in self.plan))
        start_s = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - start_s
