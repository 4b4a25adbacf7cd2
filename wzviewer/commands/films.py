"""Frames -> H.264 in mp4 or an animated GIF, whole or not at all.

::

    frames (h, w, 3) ──► ffmpeg ──► .NAME.xxxx.part.{mp4,gif} ──► rename
                           mp4   constant quality, yuv420p
                           gif   256 colours chosen anew for every frame, error-diffused

The encoder comes with imageio-ffmpeg.  A GIF has a palette of its own for each frame: a zoom from a
meadow to a ladybug shares few colours, and one palette for all of them bands (37.1 against 33.2 dB on
the demo's zoom, at 0.64 against 0.42 bytes a pixel).
"""

import os
import signal
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from wzviewer.commands.progress import Progress
from wzviewer.core.camera import Camera
from wzviewer.core.types import ByteArray
from wzviewer.errors import InputError, OutputError

H264_QUALITY = "18"  # constant rate factor: visually lossless
SUFFIXES = (".mp4", ".gif")
GIF_FPS = 20.0  # a GIF counts in hundredths of a second: 10, 20, 25 and 50 are exact
GIF_FPS_MAX = 50.0  # viewers play anything faster at 10
GIF_LONG_SIDE_PX = 640  # unless another size is asked for
GIF_MAX_PIXELS = 120_000_000  # of all frames together
GIF_BYTES_PER_PIXEL = 0.65  # measured on the demo's zoom
GIF_FILTER = "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=sierra2_4a"
STEP_FRAMES = 10  # between two reports


def check_film(path: Path, cameras: Sequence[Camera], fps: float) -> None:
    """Refuses a film that would be of no use, before anything is drawn.

    Raises:
        InputError: when a GIF would be too large or too fast.
    """
    reason = why_not(path.suffix, cameras[0].width, cameras[0].height, len(cameras), fps)
    if reason:
        raise InputError(str(path), reason)


def why_not(suffix: str, width: int, height: int, count: int, fps: float) -> str:
    """Returns why a film cannot be made, in a few words; empty when it can."""
    if suffix.lower() != ".gif":
        return ""
    if fps > GIF_FPS_MAX:
        return f"a GIF plays at most {GIF_FPS_MAX:.0f} frames per second. Take fewer, or an mp4"
    if width * height * count > GIF_MAX_PIXELS:
        size_mb = gif_bytes(width, height, count) / 1e6
        return f"a GIF of {count} frames of {width}x{height} is too large, about {size_mb:.0f} MB. " + (
            "Make it smaller, shorter or slower, or take an mp4"
        )
    return ""


def gif_bytes(width: int, height: int, count: int) -> float:
    """About how large a GIF becomes."""
    return GIF_BYTES_PER_PIXEL * width * height * count


def gif_size(width: int, height: int) -> tuple[int, int]:
    """Returns a size within the usual long side of a GIF, of the same aspect."""
    ratio = min(1.0, GIF_LONG_SIDE_PX / max(width, height))
    return max(round(width * ratio), 1), max(round(height * ratio), 1)


def write_film(path: Path, frames: Iterable[ByteArray], fps: float, count: int, progress: Progress) -> None:
    """Writes a film, whole or not at all; frame i is shown from i / fps on.

    Args:
        path: of the film; its suffix says which kind.
        frames: (h, w, 3) uint8 each; an mp4 of odd size loses its last row or column.
        fps: frames per second.
        count: of the frames, for the progress.
        progress: told about every tenth frame.

    Raises:
        OutputError: when it cannot be written.
    """
    with _whole_film(path) as temporary, _ends_cleanly():
        writer: Any = None
        try:
            for i, frame in enumerate(frames):
                image = _even(frame) if path.suffix.lower() == ".mp4" else frame
                if writer is None:
                    writer = _encoder(temporary, image, fps)
                writer.send(np.ascontiguousarray(image))
                if i % STEP_FRAMES == 0:
                    progress.step(f"frame {i} of {count}", i / max(count, 1))
        except OSError as error:
            raise OutputError(str(path), (error.strerror or str(error)).lower()) from error
        finally:
            if writer is not None:
                writer.close()


def _even(frame: ByteArray) -> ByteArray:
    return frame[: frame.shape[0] & ~1, : frame.shape[1] & ~1]


def _encoder(path: Path, image: ByteArray, fps: float) -> Any:  # noqa: ANN401 - a generator of a library
    import imageio_ffmpeg

    size = (image.shape[1], image.shape[0])
    arguments: dict[str, Any] = {
        "fps": fps,
        "macro_block_size": 1,
        "quality": None,
        "ffmpeg_log_level": "error",
    }
    if path.suffix == ".gif":
        arguments |= {"codec": "gif", "pix_fmt_out": "pal8"}
        arguments |= {"output_params": ["-filter_complex", GIF_FILTER, "-loop", "0"]}
    else:
        arguments |= {"output_params": ["-crf", H264_QUALITY, "-preset", "medium"]}
    writer = imageio_ffmpeg.write_frames(str(path), size, **arguments)
    writer.send(None)
    return writer


@contextmanager
def _whole_film(path: Path) -> Iterator[Path]:
    """Yields a hidden file beside the film, which takes its place in the end, or goes."""
    try:
        descriptor, name = tempfile.mkstemp(f".part{path.suffix.lower()}", f".{path.stem}.", path.parent)
        os.close(descriptor)
    except OSError as error:
        raise OutputError(str(path), (error.strerror or str(error)).lower()) from error
    temporary = Path(name)
    try:
        yield temporary
        if not temporary.stat().st_size:
            raise OutputError(str(path), "the encoder wrote nothing")
        temporary.chmod(0o644)
        temporary.replace(path)
    except OSError as error:
        raise OutputError(str(path), (error.strerror or str(error)).lower()) from error
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def _ends_cleanly() -> Iterator[None]:
    """Being asked to end is an interrupt, so that nothing half-made is left behind."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    try:
        kept = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # not the main thread: then nobody sends signals to it
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, kept)
