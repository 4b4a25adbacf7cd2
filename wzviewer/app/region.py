"""The frame of the next level: drawn by the user, or where Enter would go by itself."""

from dataclasses import dataclass, replace

from wzviewer.core.camera import Camera
from wzviewer.core.types import DoubleArray

SMALLEST_PX = 16.0  # a frame that was drawn; less is a click

Point = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Region:
    """What the next level shows, where that is not simply the view.

    Attributes:
        is_drawing: whether a drag draws a frame.
        start_px: where the drag began, framebuffer px; None while none goes on.
        end_px: where it is.
        camera: of the frame that was drawn, in the window's size; None for none.
        focus: (3,) world point at its centre.
        is_of_drop: whether it is about the place where a picture was dropped, and goes with the question.
        aim: camera that Enter would fly to, where it would; None for none.
        aimed_for: what the aim was found for: (camera, revision of the scene, frame).
    """

    is_drawing: bool = False
    start_px: Point | None = None
    end_px: Point | None = None
    camera: Camera | None = None
    focus: DoubleArray | None = None
    is_of_drop: bool = False
    aim: Camera | None = None
    aimed_for: tuple[object, ...] = ()

    def with_aim(self, aim: Camera | None, aimed_for: tuple[object, ...]) -> "Region":
        """Returns the region with another aim."""
        return replace(self, aim=aim, aimed_for=aimed_for)


def drawn_frame(start: Point, end: Point, size: Point) -> tuple[float, float, float, float]:
    """Returns (x, y, width, height) of a frame between two points, in the aspect of a picture.

    Args:
        start: the corner that stands, px.
        end: the corner that follows the hand, px.
        size: width and height of the picture, px.
    """
    dx, dy = end[0] - start[0], end[1] - start[1]
    share = max(abs(dx) / size[0], abs(dy) / size[1])
    width, height = share * size[0], share * size[1]
    x = start[0] if dx >= 0 else start[0] - width
    y = start[1] if dy >= 0 else start[1] - height
    return x, y, width, height


def framed(camera: Camera, frame: tuple[float, float, float, float]) -> Camera:
    """Returns the camera that sees a frame of a picture as a whole picture."""
    x, y, width, height = frame
    centre = ((x + width / 2) / camera.width, (y + height / 2) / camera.height)
    return camera.zoomed_to_region(*centre, camera.width / width)
