"""`ViewSynthesizer`: the hidden and the outer part of a picture with depth, as layers."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, FloatArray
from wzviewer.worker.models.builtin.views.axis import DepthAxis
from wzviewer.worker.models.builtin.views.backdrop import backdrop
from wzviewer.worker.models.builtin.views.edges import clean_edges, even_small_steps, has_steps
from wzviewer.worker.models.builtin.views.hidden_sky import calm_sky, sky_field
from wzviewer.worker.models.builtin.views.layers import (
    BEHIND,
    DEEPER_RULE,
    FIRST_RULE,
    Layer,
    Original,
    Surface,
    background_layer,
    far_as_sky,
)
from wzviewer.worker.models.builtin.views.leftovers import leftover_layer
from wzviewer.worker.models.builtin.views.outpaint import Canvas, outpaint, unpadded
from wzviewer.worker.models.builtin.views.smoothing import dilated
from wzviewer.worker.models.builtin.views.thinning import visible_pixels
from wzviewer.worker.models.builtin.views.underlay import underlay

NUM_LAYERS = 2  # the backdrop is behind them, and at deep levels what coarser ones hid
SHARP_PAD_PX = 20  # pad pixels farther out are emitted at half the resolution
PAD_STRIDE = 2
OVERLAP_PX = 2
MIN_LAYER_PIXELS = 16
SKY_FRINGE_PX = 6
OWN_REACH_PX = 225.0  # of image motion: what is farther behind an edge is left to the coarser levels
LIKE_SKY = 0.5  # of the sky's depth, from which on a deep level counts a point as sky
SAME_SKY = 0.85  # of the sky's depth; what is not sky is nearer (`depth.estimator.depth_from_reading`)


@dataclass(frozen=True)
class Completion:
    """A picture with everything that a neighbouring camera may see beside it.

    Attributes:
        image: (h, w, 3) float32, the picture, unchanged.
        relief: (h, w) float32 native px, with sharp steps at the colour edges.
        layers: hidden and outer pixels, all behind the front in the source view.
    """

    image: FloatArray
    relief: FloatArray
    layers: tuple[Layer, ...]


class ViewSynthesizer:
    """Completes a picture with depth, without network weights.

    Args:
        seed: default seed of the candidate search.
    """

    name = "builtin"

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed

    def complete(
        self,
        image: FloatArray,
        relief: FloatArray,
        sky: BoolArray | None,
        camera: Camera,
        outside: bool,
        angle_deg: float = 12.0,
        seed: int | None = None,
        check: Callable[[], None] | None = None,
    ) -> Completion:
        """Adds what cameras within an orbit angle see beside the picture itself.

        Args:
            image: (h, w, 3) float32 sRGB in [0, 1].
            relief: (h, w) float32, native px, + farther; finite.
            sky: (h, w) bool, or None where there is none.
            camera: of the picture.
            outside: True to pad the frame too (level 0; deeper levels have their parent around them).
            angle_deg: largest orbit about the anchor.
            seed: of the candidate search; the same seed gives the same bytes.
            check: called every few hundredths of a second; raises to cancel.

        Returns:
            The completion; without steps and without a pad it has no layers and the relief as given.
        """
        axis = DepthAxis.of(camera)
        gain = float(np.tan(np.deg2rad(angle_deg)))
        seed = self.seed if seed is None else seed
        if not outside:  # at level 0 they hardly show, and layers are made for what does
            relief = even_small_steps(relief, axis, gain)
        shift = axis.shift_of(relief)
        clean = clean_edges(shift, image, axis, gain)
        stepped = has_steps(clean, axis, gain)
        if not (outside or stepped):
            return Completion(image, relief, ())
        clean, sky = _with_sky(clean, shift, sky, axis)
        relief = np.where(clean == shift, relief, axis.relief_of(clean)).astype(np.float32, copy=False)
        frame = Surface(np.ascontiguousarray(image, np.float32), clean, relief, sky)
        canvas = outpaint(frame, axis, gain, seed, check) if outside else unpadded(frame)
        surfaces, masks = _background(canvas, axis, gain, seed, check)
        painted = masks[min(1, len(masks) - 1)]
        masks = visible_pixels([s.relief for s in surfaces], masks, _offset(canvas), camera, angle_deg)
        if outside:  # around and behind a deeper level there is its parent
            surfaces, masks = _with_leftovers(canvas, surfaces, masks, camera, angle_deg, seed, check)
        else:
            masks = [
                masks[0],
                *(
                    mask & ~_inner_sky(s, frame.sky) & (frame.shift - s.shift < OWN_REACH_PX / gain)
                    for s, mask in zip(surfaces[1:], masks[1:], strict=True)
                ),
            ]
        if not outside:
            return Completion(image, relief, _layers(canvas, surfaces, masks, axis))
        last = backdrop(canvas, axis)
        surfaces = _under_one_sky(canvas, surfaces, masks, last)
        layers = _layers(canvas, surfaces, masks, axis)
        if len(surfaces) > 1:
            layers += (underlay(canvas.surface, surfaces[1], painted, masks[1], _offset(canvas), axis),)
        return Completion(image, relief, (*layers, last))


def _under_one_sky(
    canvas: Canvas, surfaces: list[Surface], masks: list[BoolArray], behind: Layer
) -> list[Surface]:
    """Returns the surfaces with one smooth sky in all that is hidden."""
    field = sky_field(canvas, behind)
    seen = canvas.surface.sky
    calm = [
        replace(s, image=calm_sky(s.image, s.sky & mask, seen & ~mask, field))
        for s, mask in zip(surfaces[1:], masks[1:], strict=True)
    ]
    return [surfaces[0], *calm]


def _with_sky(
    clean: FloatArray, shift: FloatArray, sky: BoolArray | None, axis: DepthAxis
) -> tuple[FloatArray, BoolArray]:
    """Moves the sky label (h, w) along with pixels that changed sides, and lays them at its depth."""
    if sky is None or not sky.any():
        return clean, np.zeros(shift.shape, np.bool_)
    far = np.median(shift[sky], keepdims=True).astype(np.float32, copy=False)
    if axis.wide:
        now = np.where(clean != shift, far_as_sky(clean, far, axis), sky)
        flat = now & (clean != shift)
    else:  # the label is as coarse as the level before, the depth is not
        depth, sky_depth = (axis.focal_px + axis.relief_of(s).astype(np.float64) for s in (clean, far))
        share = depth / np.maximum(sky_depth, 1e-9)
        now, flat = share > LIKE_SKY, share > SAME_SKY
    return np.where(flat, far, clean).astype(np.float32, copy=False), np.asarray(now)


def _inner_sky(surface: Surface, seen: BoolArray) -> BoolArray:
    """Sky (h, w) of a hidden layer, away from the sky that is seen.

    A deeper level inherits that from the first, whole and soft; scraps of its own would be clouds with edges.
    """
    return np.asarray(surface.sky & ~dilated(seen, SKY_FRINGE_PX))


def _background(
    canvas: Canvas, axis: DepthAxis, gain: float, seed: int, check: Callable[[], None] | None
) -> tuple[list[Surface], list[BoolArray]]:
    """Returns the canvas and the layers behind it, each with the pixels that exist."""
    front = canvas.surface
    original = Original(front.image, axis.log_of(front.shift), canvas.inside, front.sky)
    allowed = np.ones(front.shift.shape, np.bool_)
    surfaces, masks = [front], [allowed]
    for k in range(NUM_LAYERS):
        rule = FIRST_RULE if k == 0 else DEEPER_RULE
        layer, mask = background_layer(
            surfaces[-1], original, allowed, axis, gain, seed + 10 * (k + 1), check, rule
        )
        if np.count_nonzero(mask) < MIN_LAYER_PIXELS:
            break
        surfaces.append(layer)
        masks.append(mask)
        allowed = dilated(mask, 2)
    return surfaces, masks


def _with_leftovers(
    canvas: Canvas,
    surfaces: list[Surface],
    masks: list[BoolArray],
    camera: Camera,
    angle_deg: float,
    seed: int,
    check: Callable[[], None] | None,
) -> tuple[list[Surface], list[BoolArray]]:
    """Adds a layer for what neighbours still miss."""
    axis, front = DepthAxis.of(camera), canvas.surface
    original = Original(front.image, axis.log_of(front.shift), canvas.inside, front.sky)
    last, mask = leftover_layer(
        surfaces, masks, original, _offset(canvas), camera, axis, angle_deg, seed + 90, check
    )
    return [*surfaces, last], [*masks, mask]


def _offset(canvas: Canvas) -> tuple[int, int]:
    """Returns the image pixel of the canvas origin."""
    return -canvas.pad_px[0], -canvas.pad_px[1]


def _layers(
    canvas: Canvas, surfaces: list[Surface], masks: list[BoolArray], axis: DepthAxis
) -> tuple[Layer, ...]:
    """Emits the pad and each background layer."""
    layers = list(_pad_layers(canvas, axis)) if not canvas.inside.all() else []
    for surface, mask in zip(surfaces[1:], masks[1:], strict=True):
        if mask.any():
            layers.append(_cropped(surface, mask, _offset(canvas), 1))
    return tuple(layers)


def _cropped(surface: Surface, mask: BoolArray, offset_px: tuple[int, int], stride: int) -> Layer:
    """Returns a layer cut to the pixels that exist."""
    rows, columns = np.nonzero(mask.any(axis=1))[0], np.nonzero(mask.any(axis=0))[0]
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    origin = (offset_px[0] + stride * int(columns[0]), offset_px[1] + stride * int(rows[0]))
    image, relief = np.ascontiguousarray(surface.image[part]), np.ascontiguousarray(surface.relief[part])
    return Layer(image, relief, np.ascontiguousarray(mask[part]), origin, stride)


def _pad_layers(canvas: Canvas, axis: DepthAxis) -> tuple[Layer, ...]:
    """Returns the pad: sharp beside the frame, at half the resolution farther out.

    The parts overlap by a pixel or two, the inner one behind the outer, so that no seam opens.
    """
    surface, offset = canvas.surface, _offset(canvas)
    height, width = (n // PAD_STRIDE for n in surface.shift.shape)
    ring = dilated(~canvas.inside, OVERLAP_PX)
    relief = np.where(canvas.inside, axis.behind(surface.relief, BEHIND), surface.relief)
    surface = replace(surface, relief=relief.astype(np.float32, copy=False))
    if surface.shift.shape != (height * PAD_STRIDE, width * PAD_STRIDE):
        return (_cropped(surface, ring, offset, 1),)
    near = dilated(canvas.inside, SHARP_PAD_PX)
    far = cv2.resize(near.astype(np.uint8), (width, height), interpolation=cv2.INTER_AREA) == 0
    near = dilated(~np.repeat(np.repeat(far, PAD_STRIDE, 0), PAD_STRIDE, 1), OVERLAP_PX)
    image = np.asarray(cv2.resize(surface.image, (width, height), interpolation=cv2.INTER_AREA), np.float32)
    pick = np.s_[::PAD_STRIDE, ::PAD_STRIDE]
    coarse = Surface(image, surface.shift[pick], surface.relief[pick], surface.sky[pick])
    return (_cropped(surface, near & ring, offset, 1), _cropped(coarse, np.asarray(far), offset, PAD_STRIDE))


def warm_up() -> None:
    """Compiles every kernel of this package on a tiny scene, so that the first real call is quick."""
    size = 96
    image = np.tile(np.linspace(0, 1, size, dtype=np.float32)[None, :, None], (size, 1, 3))
    relief = np.full((size, size), 60.0, np.float32)
    relief[30:60, 30:60] = -40.0
    camera = Camera.initial(size, size, 100.0)
    for view in (camera, camera.zoomed_to_region(0.5, 0.5, 8.0)):
        ViewSynthesizer().complete(np.ascontiguousarray(image), relief, None, view, outside=view is camera)
