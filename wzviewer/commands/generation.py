"""Photo and zooms -> scene, through the worker.  Used by ``generate``, ``demo``, ``bench`` and the API."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from wzviewer.commands.progress import Progress
from wzviewer.config import Generation, Zoom
from wzviewer.core.beside import levels_beside
from wzviewer.core.camera import Camera
from wzviewer.core.photos import finer_photo, fit_photo, load_photo
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.errors import Cancelled, InputError, WorkerError
from wzviewer.worker.client import (
    Event,
    LevelDropped,
    LevelFinished,
    LevelPreviewed,
    WorkerClient,
    WorkerLost,
    WorkerStarted,
)

START_TIMEOUT_S = 300.0  # a cold start compiles the CPU kernels, once per machine
LEVEL_TIMEOUT_S = 900.0


@dataclass
class Timings:
    """Seconds per level, as ``generate --json`` reports them."""

    seconds: list[float] = field(default_factory=list)
    first_preview_seconds: list[float] = field(default_factory=list)


def generate_scene(plan: Generation, progress: Progress) -> tuple[Scene, Timings]:
    """Makes E_0 and every zoom of a plan.

    Raises:
        InputError: for a bad photo, prompt, or parent.
        WorkerError: when the worker failed.
    """
    check_backend(plan.synthesizer)
    image, photo = read_photo(plan)
    check_prompts(plan.zooms)
    with WorkerClient(plan.synthesizer) as client:
        progress.line("starting the worker (the first time on a machine it compiles its kernels)")
        _wait_until(client, lambda e: isinstance(e, WorkerStarted), START_TIMEOUT_S)
        return run_plan(client, image, plan, progress, photo)


def read_photo(plan: Generation) -> tuple[ByteArray, ByteArray | None]:
    """Returns the photo of a plan at its working size, and with more pixels if it has them."""
    photo = load_photo(plan.image)
    image = fit_photo(photo, max(plan.size)) if plan.size else fit_photo(photo)
    return image, finer_photo(photo, image)


def check_backend(name: str) -> None:
    """Raises InputError unless a backend of this name exists."""
    from wzviewer.worker.models.catalogue import BACKENDS

    if name not in BACKENDS:
        raise InputError(f"--synthesizer {name}", "unknown backend", f"Known: {', '.join(BACKENDS)}.")


def check_prompts(zooms: tuple[Zoom, ...]) -> None:
    """Refuses what is not understood before any work.

    Raises:
        PromptError: with the words that are known.
    """
    from wzviewer.worker.models.builtin.objects.grammar import parse

    for zoom in zooms:
        parse(zoom.prompt)


def run_plan(
    client: WorkerClient,
    image: ByteArray,
    plan: Generation,
    progress: Progress,
    photo: ByteArray | None = None,
) -> tuple[Scene, Timings]:
    """Makes the levels of a plan with a running worker."""
    scene, timings = Scene(), Timings()
    progress.begin("level 0")
    _collect(client, scene, client.reconstruct(image, plan.seed, photo), timings, progress)
    for number, zoom in enumerate(plan.zooms, start=1):
        parent = len(scene) - 1 if zoom.parent is None else zoom.parent
        if not 0 <= parent < len(scene):
            raise InputError(f"parent = {parent}", f"there are levels 0 to {len(scene) - 1} before this zoom")
        progress.begin(f"level {number}" + (f" ({zoom.prompt})" if zoom.prompt else ""))
        camera = camera_of_zoom(scene, parent, zoom)
        beside = levels_beside(scene, parent, camera, zoom.prompt)
        request_id = client.synthesize(parent, camera, zoom.prompt, plan.seed + number, beside=beside)
        _collect(client, scene, request_id, timings, progress)
    return scene, timings


def camera_of_zoom(scene: Scene, parent: int, zoom: Zoom) -> Camera:
    """C_{i+1}: the region of the parent's image that a zoom names."""
    return scene[parent].camera.zoomed_to_region(zoom.x, zoom.y, zoom.factor)


def _collect(
    client: WorkerClient, scene: Scene, request_id: int, timings: Timings, progress: Progress
) -> None:
    start_s = time.perf_counter()
    first_preview_s = np.nan

    def on_event(event: Event) -> bool:
        nonlocal first_preview_s
        progress.event(event)
        if isinstance(event, LevelPreviewed) and np.isnan(first_preview_s):
            first_preview_s = time.perf_counter() - start_s
        if isinstance(event, LevelDropped):
            raise _error_of(event)
        if isinstance(event, LevelFinished):
            scene.append(event.level)
            scene.commit(event.level.index)
        return isinstance(event, LevelFinished) and event.request_id == request_id

    _wait_until(client, on_event, LEVEL_TIMEOUT_S)
    timings.seconds.append(time.perf_counter() - start_s)
    timings.first_preview_seconds.append(first_preview_s)
    progress.done()


def _wait_until(client: WorkerClient, is_end: Callable[[Event], bool], timeout_s: float) -> None:
    deadline = time.perf_counter() + timeout_s
    while time.perf_counter() < deadline:
        for event in client.poll(0.05):
            if is_end(event):
                return
            if isinstance(event, WorkerLost) and not client.is_busy:
                raise WorkerError("worker", f"it {event.why}", "Try again, perhaps with a smaller --size.")
        client.channel_wait(0.02)
    raise WorkerError("worker", f"no result within {timeout_s:.0f} s")


def _error_of(event: LevelDropped) -> Exception:
    if event.bad_input:
        return InputError(event.what, event.why, event.hint)
    if event.cancelled:
        return Cancelled()
    return WorkerError(event.what, event.why, event.hint)
