"""``bench transition``: what shines through between two levels, and how steady the pictures are.

All levels lie on one plane, and their content is alike: a child is its parent's crop plus detail of mean
zero (`consistent_chain`).  So whatever changes besides the motion of the picture comes from the renderer.

Paths::

    straight   256 frames of a zoom through five levels about one pixel; its keys carry no name
    pan        the same while the centre drifts, so that each child's border crosses the middle of the
               picture half-way to the child's own scale, and comes back
    oblique    the same from aside, while the view turns from 7 to 2 degrees
    slide      128 frames, no zoom: from the middle of a child across its border, half-way between two scales
    slide_native                          the same at the child's own scale

and on each of them, per blend::

    step       mean absolute difference of successive frames, grey levels, with the motion in it
    pop        the same of the mean of the channels, once the former frame has been carried to the new
               camera through the plane, and both are smoothed: motion and the pixel grid are gone, and
               fading and defects are left
    pop_local  the largest pop of a block of 16 pixels

A ratio is the largest over the median of the path.  A step is mostly motion, which a short or small
defect hides behind; a pop is some fifty times smaller, so that it cannot.  The straight path is measured
without modulation too, and with merged surfels as in motion (``merged``).

``transition_pop_max_turn`` shows a limit of sorted surfels: those of an exactly frontal plane are all
equally deep, and their order turns about when an orbit passes the plane's normal, which moves the picture
by a fraction of a native pixel.  Nothing else changes in that orbit, so there is no ratio.

Leak: over a patch that both levels cover fully, the largest (1 - coverage) during the transition
minus the larger of its values at the two ends.  Along a path: the largest mean of (1 - coverage) in any
frame, over the whole picture or over the border of a child, from a pixel of the parent outside of it to
the end of its feather, minus what one level shows alone.
"""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from wzviewer.app.pacing import SPACING_PX
from wzviewer.commands.bench_scenes import PLANE_DEPTH, chain_scene, consistent_chain
from wzviewer.commands.rendering import picture, scene_renderer
from wzviewer.core.camera import Camera
from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.core.navigation import interpolated, orbited, panned
from wzviewer.core.opacity import feather_px
from wzviewer.core.reference import Blend
from wzviewer.core.scene import Scene
from wzviewer.core.types import BoolArray, ByteArray, DoubleArray, FloatArray
from wzviewer.gl.frame import RenderSettings
from wzviewer.gl.renderer import SurfelRenderer

LEAK_STEPS = 17
LEAK_EVERY = 4  # frames of a path
ZOOM_FRAMES = 256
ZOOM_LEVELS = 5
SLIDE_FRAMES = 128
TURN_FRAMES = 64
SIZE_PX = (272, 184)
DRIFT = 0.25  # of the picture's width; a child's border is 0.18 from its middle half-way to its scale
OBLIQUE_DEG = ((7.0, -4.0), (2.0, -1.0))  # yaw and pitch at the first and at the last frame
OBLIQUE_FACTOR = 1.3
TURN_DEG = 2.0
SMOOTH_PX = 1.5  # standard deviation that takes away how a picture falls on the pixel grid
BLOCK_PX = 16
BAND_SHARE = 0.02  # of the picture: a smaller piece of a border may be all peak or all valley
CUBIC_PX = 2.0  # reach of the resampling

Path = Sequence[Camera]


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Returns leaks, steps and pops of all paths, as in the module docstring."""
    record = _leaks(options)
    zoom = consistent_chain(ZOOM_LEVELS, *SIZE_PX)
    with scene_renderer(zoom, options.context, options.rasterizer) as renderer:
        for name, path in paths(zoom).items():
            for blend in get_args(Blend):
                frames = pictures(renderer, path, RenderSettings(blend=blend))
                record |= changes(frames, path).figures(_suffix(name, blend))
        turning = turn(_half_way(zoom), zoom[2].frame.origin)
        turned = changes(pictures(renderer, turning, RenderSettings()), turning)
        record["transition_pop_max_turn"] = float(turned.pops.max())
        straight = straight_zoom(zoom)
        bare = pictures(renderer, straight, RenderSettings(modulation=False))
        record |= changes(bare, straight).figures("_no_modulation")
        renderer.wait_for_merged(zoom)
        merged = pictures(renderer, straight, RenderSettings(spacing_px=SPACING_PX))
        record |= changes(merged, straight).figures("_merged")
    return record


def _suffix(name: str, blend: Blend) -> str:
    return ("" if name == "straight" else f"_{name}") + ("_linear" if blend == "linear" else "")


# ---------------------------------------------------------------- paths


def paths(scene: Scene, frames: int = ZOOM_FRAMES) -> dict[str, Path]:
    """Returns the camera paths of the module docstring through a chain of three levels or more."""
    return {
        "straight": straight_zoom(scene, frames),
        "pan": panning_zoom(scene, frames),
        "oblique": oblique_zoom(scene, frames),
        "slide": slide(_half_way(scene), frames // 2),
        "slide_native": slide(scene[2].camera, frames // 2),
    }


def straight_zoom(scene: Scene, frames: int = ZOOM_FRAMES) -> Path:
    """From C_0 to the last camera of a chain, even in log focal length, about one pixel."""
    last = scene[len(scene) - 1]
    way = np.linspace(0.0, 1.0, frames)
    return [interpolated(scene[0].camera, last.camera, last.frame.origin, float(s)) for s in way]


def panning_zoom(scene: Scene, frames: int = ZOOM_FRAMES) -> Path:
    """The straight zoom, aside by `DRIFT` half-way between any two levels."""
    drifts = DRIFT * np.sin(np.pi * np.linspace(0.0, len(scene) - 1.0, frames)) ** 2
    zoom = straight_zoom(scene, frames)
    return [panned(camera, -float(d) * camera.width, 0.0) for camera, d in zip(zoom, drifts, strict=True)]


def oblique_zoom(scene: Scene, frames: int = ZOOM_FRAMES) -> Path:
    """A zoom to the last camera from near C_0, so that the root fills the view, turned about an anchor."""
    last = scene[len(scene) - 1]
    pivot, root = last.frame.origin, scene[0].camera
    ends = (root.zoomed(*_middle(root), OBLIQUE_FACTOR), last.camera)
    turns = (np.deg2rad(angles) for angles in OBLIQUE_DEG)
    start, end = (orbited(c, pivot, *angles) for c, angles in zip(ends, turns, strict=True))
    return [interpolated(start, end, pivot, float(s)) for s in np.linspace(0.0, 1.0, frames)]


def slide(camera: Camera, frames: int = SLIDE_FRAMES) -> Path:
    """Sideways by three quarters of the picture."""
    return [panned(camera, -float(x) * camera.width, 0.0) for x in np.linspace(0.0, 0.75, frames)]


def turn(camera: Camera, pivot: DoubleArray, frames: int = TURN_FRAMES) -> Path:
    """An orbit through the camera; their number is even, so that none looks along the normal itself."""
    angles = np.deg2rad(np.linspace(-TURN_DEG, TURN_DEG, frames))
    return [orbited(camera, pivot, float(angle), 0.0) for angle in angles]


def _half_way(scene: Scene) -> Camera:
    """Between the scales of levels 1 and 2."""
    return scene[2].camera.zoomed(*_middle(scene[2].camera), ZOOM_FACTOR**-0.5)


def _middle(camera: Camera) -> tuple[float, float]:
    return camera.width / 2, camera.height / 2


# ---------------------------------------------------------------- steps and pops


@dataclass(frozen=True, eq=False)
class Changes:
    """What changes between successive frames of a path, grey levels; see the module docstring.

    Attributes:
        steps: (n - 1,).
        pops: (n - 1,).
        local_pops: (n - 1,).
    """

    steps: DoubleArray
    pops: DoubleArray
    local_pops: DoubleArray

    def figures(self, suffix: str = "") -> dict[str, float]:
        """Returns the keys of one path."""
        record = {
            "step_mean": self.steps.mean(),
            "step_median": np.median(self.steps),
            "step_max": self.steps.max(),
            "step_ratio": ratio(self.steps),
            "pop_median": np.median(self.pops),
            "pop_ratio": ratio(self.pops),
            "pop_local_ratio": ratio(self.local_pops),
        }
        return {f"transition_{name}{suffix}": float(value) for name, value in record.items()}


def ratio(values: DoubleArray) -> float:
    """Largest over median."""
    return float(values.max() / max(float(np.median(values)), 1e-9))


def pictures(renderer: SurfelRenderer, path: Path, settings: RenderSettings) -> Iterator[ByteArray]:
    """Renders a path, (h, w, 3) uint8 each."""
    return (picture(renderer, camera, settings) for camera in path)


def changes(frames: Iterable[ByteArray], path: Path) -> Changes:
    """Measures a film.

    Args:
        frames: (h, w, 3) uint8 each.
        path: their cameras.
    """
    found = []
    before: tuple[FloatArray, FloatArray, Camera] | None = None
    for frame, camera in zip(frames, path, strict=True):
        here = frame.astype(np.float32)
        grey = here.mean(-1)
        if before is not None:
            pop, seen = difference(grey, camera, *before[1:])
            step = np.abs(here - before[0]).mean()
            found.append((step, pop[seen].mean(), _largest_block(np.where(seen, pop, np.float32(0)))))
        before = (here, grey, camera)
    return Changes(*np.array(found, np.float64).T)


def difference(
    grey: FloatArray, camera: Camera, former: FloatArray, former_camera: Camera
) -> tuple[FloatArray, BoolArray]:
    """Absolute smoothed difference of a frame and a former one, motion taken out.

    Args:
        grey: (h, w).
        camera: its camera.
        former: (h, w).
        former_camera: its camera.

    Returns:
        The difference, (h, w), and where both see the plane, (h, w).
    """
    at = image_points(camera, former_camera)
    # Not cv2.remap, which rounds positions to 1/32 px: that would be most of what is measured.
    columns_rows = np.moveaxis(at - 0.5, -1, 0)
    carried = map_coordinates(former, columns_rows[::-1], order=3, mode="nearest", output=np.float32)
    smooth = cv2.GaussianBlur(grey - carried, (0, 0), SMOOTH_PX)
    size = (former_camera.width, former_camera.height)
    seen = np.all((at > CUBIC_PX) & (at < np.subtract(size, CUBIC_PX)), axis=-1)
    return np.abs(smooth), seen


def image_points(camera: Camera, other: Camera) -> DoubleArray:
    """Where another camera sees what lies on the plane in each pixel of a camera, px, (h, w, 2)."""
    y, x = np.mgrid[0 : camera.height, 0 : camera.width] + 0.5
    in_camera = np.stack([(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones_like(x)], -1)
    rays = in_camera @ camera.rotation
    reach = (PLANE_DEPTH - camera.position[2]) / rays[..., 2:]
    return other.project(camera.position + reach * rays)[..., :2]


def _largest_block(pop: FloatArray) -> float:
    h, w = (size // BLOCK_PX * BLOCK_PX for size in pop.shape)
    blocks = pop[:h, :w].reshape(h // BLOCK_PX, BLOCK_PX, w // BLOCK_PX, BLOCK_PX)
    return float(blocks.mean(axis=(1, 3)).max())


# ---------------------------------------------------------------- leaks


def _leaks(options: argparse.Namespace) -> dict[str, float]:
    record = {}
    image = np.full((SIZE_PX[1], SIZE_PX[0], 3), 200, np.uint8)
    scene = chain_scene(ZOOM_LEVELS, image, relief_px=0.0)
    with scene_renderer(scene, options.context, options.rasterizer) as renderer:
        for blend in get_args(Blend):
            record[f"transition_leak{_suffix('straight', blend)}"] = leak(renderer, scene, blend)
            alone = alone_through(renderer, scene, blend)
            for name, path in paths(scene).items():
                key = f"transition_leak_path{_suffix(name, blend)}"
                record[key] = max(0.0, path_through(renderer, scene, path[::LEAK_EVERY], blend) - alone)
    return record


def leak(renderer: SurfelRenderer, scene: Scene, blend: Blend) -> float:
    """Leak between levels 0 and 1 over the middle of level 1."""
    through = []
    for t in np.linspace(0.0, 1.0, LEAK_STEPS):
        camera = interpolated(_at_scale_of_parent(scene), scene[1].camera, scene[1].frame.origin, float(t))
        lost = _through(renderer, camera, blend)
        h, w = lost.shape
        through.append(float(lost[h * 15 // 32 : h * 17 // 32, w * 15 // 32 : w * 17 // 32].mean()))
    return max(0.0, max(through) - max(through[0], through[-1]))


def _through(renderer: SurfelRenderer, camera: Camera, blend: Blend) -> FloatArray:
    """1 - coverage, (h, w)."""
    settings = RenderSettings(blend=blend, outputs=frozenset({"color", "coverage"}))
    return np.float32(1.0) - renderer.render(camera, settings).read_coverage()


def _at_scale_of_parent(scene: Scene) -> Camera:
    """The parent's focal length, centred on what the child shows."""
    child = scene[1].camera
    return child.zoomed(*_middle(child), scene[0].camera.fx / child.fx)


def alone_through(renderer: SurfelRenderer, scene: Scene, blend: Blend) -> float:
    """Mean of 1 - coverage of the root alone, magnified: its pixels' every phase is in view."""
    camera = scene[0].camera.zoomed(*_middle(scene[0].camera), ZOOM_FACTOR)
    scene.hide(1)
    renderer.sync(scene)
    lost = float(_through(renderer, camera, blend).mean())
    scene.show(1)
    renderer.sync(scene)
    return lost


def path_through(renderer: SurfelRenderer, scene: Scene, path: Path, blend: Blend) -> float:
    """Largest mean of 1 - coverage in a frame, over all of the plane in view or a child's border."""
    largest = 0.0
    for camera in path:
        lost = _through(renderer, camera, blend)
        for region in _regions(scene, camera):
            if np.count_nonzero(region) >= BAND_SHARE * region.size:
                largest = max(largest, float(lost[region].mean()))
    return largest


def _regions(scene: Scene, camera: Camera) -> Iterator[BoolArray]:
    """What of the root is in view, and the border of each child with its feather, (h, w)."""
    for level in scene:
        other = level.camera
        at = image_points(camera, other)
        inside = np.minimum(at, (other.width, other.height) - at).min(-1)  # px from the border
        feather = feather_px(other)
        if level.parent is None:
            yield np.greater(inside, feather)
        else:
            yield np.greater(inside, -ZOOM_FACTOR) & np.less(inside, max(feather, ZOOM_FACTOR))
