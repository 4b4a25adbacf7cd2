from dataclasses import replace

import numpy as np

from tests.gl.surfaces import flat_scene, hill_scene, orbited
from wzviewer.core import reference
from wzviewer.core.anchor import AnchoredView
from wzviewer.core.scene import modulation
from wzviewer.gl.cull import (
    ChunkBounds,
    chunk_radii_px,
    clipped,
    in_frustum,
    may_cover,
    unmodulated,
    view_slabs,
    weightless,
)

CHUNK = 37  # small, and no divisor of anything


def cameras(scene):
    for level in scene:
        for angle in (0.0, 8.0, -20.0):
            turned = orbited(level.camera, level.frame.origin, angle)
            for magnify in (0.2, 1.0, 2.5, 9.0):
                yield turned.zoomed(5.0, 20.0, magnify)


def test_nothing_that_is_seen_is_culled():
    scene = hill_scene(24, 16, 3)
    culled = 0
    for camera in cameras(scene):
        for level in scene:
            bounds = ChunkBounds.of_surfels(level.surfels, CHUNK)
            view = AnchoredView.expand(camera, level.frame)
            keep = in_frustum(bounds, view, (camera.width, camera.height))
            slabs = view_slabs(bounds, view, (camera.width, camera.height))
            part, covers = clipped(bounds, slabs), modulation(scene, level.index)
            empty = weightless(part, view, covers) | weightless(slabs, view, covers)
            parts = reference.footprints(
                level.surfels,
                level.frame,
                camera,
                reference.level_weights(scene, level.index, level.surfels, camera),
                reference.Focus(1.0, 1.0),
            )
            chunk = np.arange(len(parts)) // CHUNK
            size = (camera.width, camera.height)
            reach = parts.centers_px + parts.extents_px
            seen = (reach > 0).all(1) & (parts.centers_px - parts.extents_px < size).all(1)
            assert not (seen & ~keep[chunk]).any()
            assert parts.weights[seen & empty[chunk]].max(initial=0.0) < 1e-9
            radius = chunk_radii_px(part, view)
            assert (parts.extents_px.max(1)[seen] <= radius[chunk][seen] * (1 + 1e-6)).all()
            culled += int((~keep | empty).sum())
    assert culled > 500  # the tests above would hold for a cull that keeps everything


def test_levels_far_above_and_below_are_skipped_whole():
    scene = flat_scene(num_levels=4)

    def skipped(index, camera):
        bounds = ChunkBounds.of_surfels(scene[index].surfels, 1)
        view = AnchoredView.expand(camera, scene[index].frame)
        return weightless(bounds, view, modulation(scene, index))

    finer = scene[2].camera.zoomed(32.0, 24.0, 1.01)
    # The child covers 8 x 6 pixels of the root; its feather of 1.1 of them spares all but the outermost.
    assert skipped(0, finer).sum() == 6 * 4
    assert not skipped(3, finer).all()  # level 3 begins to show
    coarser = scene[2].camera.zoomed(32.0, 24.0, 0.99)
    assert skipped(3, coarser).all()


def test_weight_one_is_certain_where_nothing_fades():
    scene = flat_scene(96, 72, num_levels=2)
    root, child = scene[0].camera, scene[1].camera
    cases = (
        (root, 0, 1.0),  # at its own scale, the child not yet there
        (root.zoomed(48, 36, 1.5), 0, 0.5),  # the child takes its share, but only where it is
        (child, 1, 0.05),  # its border is feathered: measured 0.08, the middle of an image as small as this
        (child.zoomed(48, 36, 0.7), 1, 0.0),  # it has not faded in
    )
    for camera, index, at_least in cases:
        level = scene[index]
        bounds = ChunkBounds.of_surfels(level.surfels, CHUNK)
        view = AnchoredView.expand(camera, level.frame)
        own_row = AnchoredView.expand(level.camera, level.frame).rows[2]
        sure = unmodulated(bounds, view, modulation(scene, index), own_row)
        assert at_least <= sure.mean() <= (at_least or 0.0) + 0.5
        w = reference.level_weights(scene, index, level.surfels, camera)
        chunk = np.arange(len(w)) // CHUNK
        np.testing.assert_allclose(w[sure[chunk]], 1.0, atol=1e-6)  # measured 2e-7: native scales are f32


def test_a_cover_that_may_act_is_kept():
    scene = hill_scene(24, 16, 3)
    idle = 0
    for camera in cameras(scene):
        for level in scene:
            covers = modulation(scene, level.index).covers
            bounds = ChunkBounds.of_surfels(level.surfels, CHUNK)
            view = AnchoredView.expand(camera, level.frame)
            render = view.log_scale(level.surfels.means)
            chunk = np.arange(len(render)) // CHUNK
            for cover in covers:
                acting = may_cover(bounds, view, cover)
                share = cover.share(level.surfels.means, render)
                in_front = view.in_front(level.surfels.means) > 0
                assert share[~acting[chunk] & in_front].max(initial=0.0) < 1e-6
                idle += int((~acting).sum())
    assert idle > 100


def test_what_is_behind_the_camera_is_culled():
    scene = flat_scene(num_levels=1)
    level = scene[0]
    pose = level.camera.camera_from_world.copy()
    pose[:3, :3] = np.diag([-1.0, 1.0, -1.0])  # looks away
    away = replace(level.camera, camera_from_world=pose)
    bounds = ChunkBounds.of_surfels(level.surfels, 64)
    view = AnchoredView.expand(away, level.frame)
    assert not in_frustum(bounds, view, (64, 48)).any()
