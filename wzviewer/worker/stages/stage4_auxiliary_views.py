"""Stage 4, Algorithm 1, lines 26-28: neighbouring cameras C^k and what they see.

The hidden and outer parts are decided once, in the source view (`ViewSynthesizer`); a neighbouring
image I^k is then an exact render of image, relief and layers, so all of them agree by construction.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.base import ViewSynthesizer
from wzviewer.worker.models.builtin.views.layers import Layer
from wzviewer.worker.models.builtin.views.mesh import EMPTY, OrbitView, draw_grid, project_grid, rotation_of
from wzviewer.worker.models.builtin.views.synthesizer import ViewSynthesizer as BuiltinSynthesizer

ORBITS_DEG = ((8.0, 0.0), (-8.0, 0.0), (0.0, 5.0), (0.0, -5.0))  # (yaw, pitch) of C^k
TEAR_PX = 3.0  # a quad with a longer side in the neighbouring view spans a depth step


@dataclass(frozen=True)
class AuxiliaryViews:
    """The complete geometry of one level and the cameras it is optimised over.

    Attributes:
        relief: (h, w) float32 native px, the front with sharp steps.
        layers: hidden and outer pixels.
        cameras: C^k, beside the source camera.
    """

    relief: FloatArray
    layers: tuple[Layer, ...]
    cameras: tuple[Camera, ...]


def synthesize_auxiliary_views(
    image: FloatArray,
    relief: FloatArray,
    sky: BoolArray | None,
    camera: Camera,
    depth_z0: float,
    outside: bool,
    synthesizer: ViewSynthesizer | None = None,
    orbits_deg: tuple[tuple[float, float], ...] = ORBITS_DEG,
    seed: int = 0,
    check: Callable[[], None] | None = None,
) -> AuxiliaryViews:
    """Samples neighbouring views and completes the level for them.

    Args:
        image: I, (h, w, 3) float32 sRGB in [0, 1].
        relief: D as relief, (h, w) float32 native px; finite.
        sky: (h, w) bool or None.
        camera: C.
        depth_z0: depth of the anchor, world units.
        outside: True at level 0, where nothing lies around the frame.
        synthesizer: what fills the hidden parts; the built-in one by default.
        orbits_deg: (yaw, pitch) of the neighbours.
        seed: of the fill.
        check: called now and then; raises to cancel.
    """
    synthesizer = synthesizer or BuiltinSynthesizer()
    completion = synthesizer.complete(image, relief, sky, camera, outside, seed=seed, check=check)
    cameras = neighbour_cameras(camera, depth_z0, orbits_deg)
    return AuxiliaryViews(completion.relief, completion.layers, cameras)


def neighbour_cameras(
    camera: Camera, depth_z0: float, angles_deg: tuple[tuple[float, float], ...] = ORBITS_DEG
) -> tuple[Camera, ...]:
    """Returns cameras that orbit about the anchor, which keeps its pixel and its depth.

    Args:
        camera: C.
        depth_z0: depth of the anchor, world units.
        angles_deg: (yaw, pitch) of each neighbour.
    """
    anchor = camera.unproject(camera.width / 2, camera.height / 2, depth_z0)
    return tuple(_orbited(camera, anchor, rotation_of(yaw, pitch)) for yaw, pitch in angles_deg)


def _orbited(camera: Camera, anchor: DoubleArray, rotation: DoubleArray) -> Camera:
    """Rotates the scene about a world point, in the axes of the camera."""
    pose = np.eye(4)
    pose[:3, :3] = rotation @ camera.rotation
    pose[:3, 3] = camera.to_camera(anchor) - pose[:3, :3] @ anchor
    turned = replace(camera, camera_from_world=pose)
    # At f = 1e13 px the pose itself is rounded to 0.05 px; the principal point takes that up.
    x_px, y_px = turned.project(anchor)[:2]
    return replace(
        turned,
        cx=turned.cx + (camera.width / 2 - float(x_px)),
        cy=turned.cy + (camera.height / 2 - float(y_px)),
    )


def warp_view(
    image: FloatArray, relief: FloatArray, layers: tuple[Layer, ...], camera: Camera, neighbour: Camera
) -> tuple[FloatArray, BoolArray]:
    """Renders I^k: image and layers as textured meshes, torn at depth steps, nearest surface wins.

    Args:
        image: I, (h, w, 3) float32.
        relief: (h, w) float32 native px, sharp at steps.
        layers: of the completion.
        camera: C.
        neighbour: one of `neighbour_cameras`: an orbit about the anchor with C's intrinsics.

    Returns:
        (h, w, 3) float32 image, and (h, w) bool where it is known.
    """
    view = OrbitView.of(camera, neighbour.rotation @ camera.rotation.T).parameters()
    color = np.zeros((camera.height, camera.width, 3), np.float32)
    depth = np.full((camera.height, camera.width), EMPTY, np.float32)
    front = Layer(image, relief, np.ones(relief.shape, np.bool_), (0, 0))
    for layer in (front, *layers):
        projected = project_grid(layer.relief, layer.offset_px, layer.stride, view)
        draw_grid(layer.image, projected, layer.mask, TEAR_PX * layer.stride, color, depth)
    return color, depth < EMPTY
