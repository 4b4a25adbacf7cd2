"""Inserting a cut-out: a card that stands on the ground, with a shadow of its outline."""

import numpy as np

from wzviewer.worker.models.builtin.objects import composite, cutout, placement
from wzviewer.worker.models.builtin.objects.grammar import Request
from wzviewer.worker.models.builtin.objects.ground import past_others
from wzviewer.worker.models.builtin.objects.lighting import Light, light_from_photo
from wzviewer.worker.models.builtin.objects.parts import Depths, Pane, parts_of
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, merged
from wzviewer.worker.models.builtin.objects.placement import Plane, Support
from wzviewer.worker.models.builtin.objects.pose import Pose


def insert_card(
    request: Request,
    result: EditResult,
    geometry: Support,
    centre: tuple[float, float],
    width_px: float,
    seed: int,
    light: Light | None,
) -> EditResult:
    """Returns the picture with a cut-out standing in it."""
    light = light or light_from_photo(result.image, centre, 0.5 * width_px)
    shape = (result.image.shape[0], result.image.shape[1])
    rgba = request.pixels if request.pixels is not None else cutout.load_cutout(request.path)
    layer, foot = cutout.card_layer(rgba, shape, centre, width_px, light.exposure)
    plane = placement.fit_plane(geometry, *centre, 0.6 * width_px)
    rows = np.nonzero((layer.alpha > 0.5).any(1))[0]
    height = float(np.ptp(rows) + 1) if len(rows) else 1.0
    ground = cutout.card_shadow(
        layer.alpha, foot, (float(light.direction[0]), float(light.direction[1])), height
    )
    gain = composite.shadow_gain(ground, light, layer.alpha)
    mask = (layer.alpha >= 0.5) & np.isfinite(layer.relief)
    base = cutout.card_lift(plane, foot, centre[0])
    relief, _ = placement.settle(
        layer.relief + np.float32(base), mask, np.fmin(geometry.relief, result.object_relief), width_px
    )
    finish = composite.Finish(0.35, composite.Finish.of(result.image).grain)
    under = composite.shadowed(result.image, gain, light)
    bare = under
    if result.ground is not None:
        bare = composite.shadowed(result.ground, past_others(gain, result.others), light)
    harmony = composite.harmony_of(result.image, layer)
    picture, alpha = composite.composite(under, layer, finish, seed, harmony)
    pose = Pose(np.eye(3), width_px, (*centre, base))
    placed = Placement("image", seed, request.tint, pose, plane, light, (0.2, 0.2, 0.2), width_px)
    flat = Depths(Plane(0.0, 0.0, base, 0.0, 0.0), 0.0, 1.0, np.zeros(shape, np.float32))
    depths = flat.in_contact(layer.relief, relief, 1.0)
    parts, _ = parts_of([Pane(picture, alpha, layer.relief)], under, depths)
    return merged(result, picture, relief, mask, alpha, gain, placed, bare, (parts, ()))
