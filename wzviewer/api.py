"""The command line's verbs in Python.

Example:
    ::

        import wzviewer

        scene = wzviewer.generate("photo.jpg", zooms=[(0.5, 0.6, "a ladybug")], seed=1)
        scene.save("scene.wz")
        with wzviewer.Renderer() as renderer:
            image = renderer.render(scene, scene[1].camera)  # (h, w, 3) uint8
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from wzviewer.core.camera import Camera
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray


def generate(
    image: str | Path, zooms: Sequence[tuple[Any, ...]] = (), seed: int = 0, synthesizer: str = "builtin"
) -> Scene:
    """Makes a scene from a photo.

    Args:
        image: path of the photo.
        zooms: (x, y) or (x, y, prompt) each; the centre as fractions of the level before.
        seed: of every generator.
        synthesizer: backend name.

    Raises:
        InputError: for a bad photo or prompt.
        WorkerError: when the worker failed.
    """
    from wzviewer.commands.generation import generate_scene
    from wzviewer.commands.progress import Progress
    from wzviewer.config import Generation, Zoom

    steps = tuple(Zoom(float(z[0]), float(z[1]), prompt=str(z[2]) if len(z) > 2 else "") for z in zooms)
    scene, _ = generate_scene(Generation(Path(image), steps, seed, synthesizer), Progress(silent=True))
    return scene


class Renderer:
    """Draws scenes without a window.

    Args:
        context: "auto", "egl", "osmesa" or "window".
    """

    def __init__(self, context: Any = "auto") -> None:  # noqa: ANN401
        from wzviewer.gl.context import create_context
        from wzviewer.gl.renderer import SurfelRenderer

        self._context = create_context(context)
        self._renderer = SurfelRenderer(self._context)

    def render(self, scene: Scene, camera: Camera) -> ByteArray:
        """Returns (h, w, 3) uint8."""
        self._renderer.sync(scene)
        return self._renderer.render(camera).read_color8()

    def close(self) -> None:
        """Frees the context."""
        self._renderer.release()
        self._context.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
