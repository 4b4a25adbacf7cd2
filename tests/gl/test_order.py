import numpy as np

from tests.gl.surfaces import hill_scene, orbited
from wzviewer.core import reference
from wzviewer.core.anchor import AnchoredView
from wzviewer.core.reference import DEPTH_QUANTUM, Focus, depth_row
from wzviewer.core.scene import modulation
from wzviewer.gl.cull import ChunkBounds
from wzviewer.gl.order import Run, front_to_back, order_runs, relative_depths, sortable_bits
from wzviewer.gl.pages import PAGE_SURFELS
from wzviewer.gl.visible import Choice, LevelState, SurfelSet, select


def set_of(surfels, first_record):
    bounds = ChunkBounds.of_surfels(surfels, PAGE_SURFELS)
    return SurfelSet(surfels, bounds, np.array([first_record], np.int32), PAGE_SURFELS)


def states_of(scene):
    return {
        i: LevelState.of(scene[i], (set_of(scene[i].surfels, i * PAGE_SURFELS),), modulation(scene, i))
        for i in scene.visible()
    }


def test_bits_sort_like_the_numbers():
    values = np.float32([-np.inf, -3e38, -1.5, -1e-40, 0.0, 1e-40, 2.0, 3e38, np.inf])
    assert (np.diff(sortable_bits(values).astype(np.int64)) > 0).all()


def test_equal_depths_go_by_index():
    depth = np.float32([2.0, 1.0, 2.0, 1.0, -1.0])
    assert front_to_back(depth).tolist() == [4, 1, 3, 0, 2]


def test_minus_zero_is_no_nearer_than_zero():
    scene = hill_scene(8, 6, 1)
    view = AnchoredView.expand(scene[0].camera, scene[0].frame)
    columns = np.float32([[0, 0], [0, 0], [-1e-9, 0]])
    focus = Focus(view.depth, scene[0].frame.unit)
    assert not np.signbit(relative_depths(columns, depth_row(view, scene[0].frame, focus))).any()


def test_the_order_is_the_references_order_at_every_depth_of_zoom():
    scene = hill_scene(24, 16, num_levels=8)
    states = states_of(scene)
    for level, angle in ((0, 0.0), (1, 5.0), (4, -8.0), (7, 3.0)):
        camera = orbited(scene[level].camera, scene[level].frame.origin, angle)
        order = select(states, camera, Choice(culling=False)).ordered().records()
        exact = reference.scene_footprints(scene, camera, modulation=False)
        records = np.concatenate(
            [np.arange(len(s.sets[0].surfels)) + i * PAGE_SURFELS for i, s in states.items()]
        )
        back = np.array([reference.setback(level.camera) for level in scene])
        z = dict(zip(records.tolist(), exact.depths * (1 + back[exact.levels]), strict=True))
        unit = reference.focus_of(camera, [lv.frame for lv in scene]).unit
        along = np.array([z[r] for r in order.tolist()])
        assert len(order) == len(records)
        # One step is 2^-14 px of the focus; float32 itself has 2^-15 at 256 px.  Measured 8e-5 px.
        near = np.abs(along[1:] - along[np.abs(along).argmin()]) < 300 * unit
        assert -np.diff(along)[near].min(initial=0.0) < 4 * DEPTH_QUANTUM * unit
        limit = 4 * DEPTH_QUANTUM * unit + 1e-6 * along.max()
        assert -np.diff(along).min() < limit  # measured 1.5 steps


def test_a_frontal_plane_is_ordered_by_index():
    scene = hill_scene(8, 6, 1)
    surfels = scene[0].surfels
    flat = set_of(surfels.with_(means=np.zeros_like(surfels.means)), 100)
    camera = orbited(scene[0].camera, scene[0].frame.origin, 0.0)
    view = AnchoredView.expand(camera, scene[0].frame)
    focus = reference.focus_of(camera, [scene[0].frame])
    run = Run(flat, slice(0, 48), view, scene[0], 100)
    assert order_runs([run], focus).tolist() == list(range(100, 148))
