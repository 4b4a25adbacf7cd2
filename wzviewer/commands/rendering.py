"""Scene -> pictures and films, through the same renderer as the window."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from wzviewer.commands.progress import Progress
from wzviewer.core.camera import Camera
from wzviewer.core.photos import encode_png, whole_file
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.errors import OutputError
from wzviewer.gl.context import ContextKind, create_context
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import RasterizerName, SurfelRenderer

KERNELS_WAIT_S = 3.0  # loading them from the cache takes one
H264_QUALITY = "18"  # constant rate factor: visually lossless


@contextmanager
def scene_renderer(
    scene: Scene, kind: ContextKind = "auto", rasterizer: RasterizerName = "auto"
) -> Iterator[SurfelRenderer]:
    """Yields a renderer that holds a scene, on a context of its own.

    Raises:
        ContextError: when no context can be made; names the missing system package.
    """
    context = create_context(kind)
    try:
        renderer = SurfelRenderer(context, rasterizer, patient=False)
        try:
            _wait_for_kernels(renderer)
            renderer.sync(scene)
            yield renderer
        finally:
            renderer.release()
    finally:
        context.close()


def _wait_for_kernels(renderer: SurfelRenderer) -> None:
    """Says what takes so long, the first time on a machine."""
    if not renderer.is_ready(KERNELS_WAIT_S):
        with Progress() as progress:
            progress.line("compiling the drawing kernels for this processor, once: about half a minute")
        renderer.is_ready(None)
    renderer.patient = True


def picture(renderer: SurfelRenderer, camera: Camera, settings: RenderSettings | None = None) -> ByteArray:
    """Renders (h, w, 3) uint8."""
    return renderer.render(camera, settings or RenderSettings()).read_color8()


def film_frames(
    renderer: SurfelRenderer, film: Sequence[Camera], settings: RenderSettings
) -> Iterator[ByteArray]:
    """Renders a camera path; a camera that rests is rendered once."""
    camera: Camera | None = None
    for upcoming in film:
        if upcoming is not camera:
            camera, image = upcoming, picture(renderer, upcoming, settings)
        yield image


def write_png(path: Path, image: ByteArray) -> None:
    """Writes a picture whole or not at all.

    Raises:
        OutputError: when it cannot be written.
    """
    data = encode_png(image)
    with whole_file(path) as file:
        file.write(data)


def write_film(path: Path, frames: Iterable[ByteArray], fps: int, count: int, progress: Progress) -> None:
    """Writes H.264 in mp4, whole or not at all.

    Args:
        path: of the film.
        frames: (h, w, 3) uint8 each; odd sizes lose their last row or column.
        fps: frames per second.
        count: of the frames, for the progress.
        progress: told about every tenth frame.

    Raises:
        OutputError: when it cannot be written.
    """
    import imageio_ffmpeg

    temporary = path.with_name(f".{path.stem}.part.mp4")
    writer = None
    try:
        for i, frame in enumerate(frames):
            even = frame[: frame.shape[0] & ~1, : frame.shape[1] & ~1]
            if writer is None:
                size = (even.shape[1], even.shape[0])
                options = ["-crf", H264_QUALITY, "-preset", "medium"]
                arguments = {"fps": fps, "macro_block_size": 1, "output_params": options}
                writer = imageio_ffmpeg.write_frames(str(temporary), size, quality=None, **arguments)
                writer.send(None)
            writer.send(np.ascontiguousarray(even))
            if i % 10 == 0:
                progress.step(f"frame {i} of {count}", i / max(count, 1))
        if writer is not None:
            writer.close()
            writer = None
            temporary.replace(path)
    except OSError as error:
        raise OutputError(str(path), (error.strerror or str(error)).lower()) from error
    finally:
        if writer is not None:
            writer.close()
        temporary.unlink(missing_ok=True)
