"""Scene -> pictures and films, through the same renderer as the window."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from wzviewer.commands.progress import Progress
from wzviewer.core.camera import Camera
from wzviewer.core.photos import encode_png, whole_file
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray
from wzviewer.gl.context import ContextKind, create_context
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import RasterizerName, SurfelRenderer
from wzviewer.gl.tiles import tiled

KERNELS_WAIT_S = 3.0  # loading them from the cache takes one


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


def picture(
    renderer: SurfelRenderer,
    camera: Camera,
    settings: RenderSettings | None = None,
    transparent: bool = False,
) -> ByteArray:
    """Renders (h, w, 3) uint8, or (h, w, 4) with coverage as straight alpha; tile by tile if it is large."""
    return tiled(renderer, camera, settings or RenderSettings(), transparent)


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
