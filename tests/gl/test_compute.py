"""The GPU's order against the CPU's: the same numbers, bit for bit."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.gl.surfaces import flat_scene, orbited
from wzviewer.commands.bench_scenes import chain_scene
from wzviewer.core import reference
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.constants import WEIGHT_MIN
from wzviewer.core.reference import Focus
from wzviewer.core.scene import Scene, modulation
from wzviewer.errors import ContextError
from wzviewer.gl.blocks import BlockTexture
from wzviewer.gl.compute import (
    BINDINGS,
    RADIX,
    RECORD_BYTES,
    THREADS,
    TILE,
    ComputeOrder,
    SurfelCull,
    slice_table,
    windows,
)
from wzviewer.gl.order import Run, order_runs
from wzviewer.gl.pages import PAGE_SURFELS
from wzviewer.gl.records import INT16_STEPS, RECORD_ATTRIBUTES, RECORD_DTYPE, RECORD_FORMAT, pack, unpack
from wzviewer.gl.shader import ShaderError, load_compute, load_program
from wzviewer.gl.surfel_buffer import SurfelBuffer
from wzviewer.gl.visible import Choice, LevelState, SurfelSet, select

CAMERA = Camera.initial(1088, 720)
FRAME = LevelFrame.of_camera(CAMERA, 1.0)
VIEW = AnchoredView.expand(CAMERA, FRAME)
FOCUS = Focus(VIEW.depth, FRAME.unit)
LEVEL: Any = SimpleNamespace(frame=FRAME, camera=CAMERA, index=0)


@pytest.fixture(scope="module")
def sorter(gl_context):
    if not ComputeOrder.is_supported(gl_context.ctx):
        pytest.skip(f"{gl_context.renderer_name} has no compute shaders")
    made = ComputeOrder(gl_context.ctx)
    yield made
    made.release()


def uploaded(ctx, means):
    records = np.zeros(max(len(means), 1), RECORD_DTYPE)
    records["mean"][: len(means)] = means
    return ctx.buffer(records.tobytes())


def run_over(means, first=0, stop=None, view=VIEW):
    source: Any = SimpleNamespace(columns=np.ascontiguousarray(means.T))
    return Run(source, slice(first, len(means) if stop is None else stop), view, LEVEL, first)


def assert_same(sorter, runs, focus, records, cull=None):
    made = sorter.order(runs, focus, records, cull)
    np.testing.assert_array_equal(made.read(), order_runs(runs, focus)[::-1])
    assert made.count() <= made.capacity
    return made


@pytest.mark.parametrize("n", [0, 1, 255, 256, 257, TILE - 1, TILE, TILE + 1, 100_003])
def test_random_depths_of_any_number(sorter, n):
    means = np.random.default_rng(n).normal(0.0, 300.0, (n, 3)).astype(np.float32)
    assert_same(sorter, [run_over(means)], FOCUS, uploaded(sorter.ctx, means))


@pytest.mark.parametrize("steps", [1, 2, 40])
def test_ties_go_by_place(sorter, steps):
    means = np.zeros((20_000, 3), np.float32)
    means[:, 2] = np.random.default_rng(1).integers(-steps, steps, len(means)) / 2
    made = assert_same(sorter, [run_over(means)], FOCUS, uploaded(sorter.ctx, means))
    depth = means[made.read(), 2]
    assert len(np.unique(depth)) == 2 * steps
    assert (np.diff(depth) <= 0).all()  # farthest first, before and behind the focus


def test_depths_around_zero_and_of_every_size(sorter):
    rng = np.random.default_rng(2)
    means = np.zeros((9000, 3), np.float32)
    means[:, 2] = rng.choice([-1.0, 1.0], 9000) * 2.0 ** rng.uniform(-40, 100, 9000)
    means[::7, 2] = -1e-9  # rounds to -0, which is no nearer than +0
    means[::11, 2] = 0.0
    assert_same(sorter, [run_over(means)], FOCUS, uploaded(sorter.ctx, means))


def test_products_are_rounded_before_they_are_added(sorter):
    """Depths within a step of one another differ in their last bit when a multiply-add is fused."""
    rng = np.random.default_rng(3)
    turned = AnchoredView(VIEW.rows, VIEW.depth, np.array([0.6123, -0.4071, 0.6782]))
    means = rng.normal(0.0, 5000.0, (50_000, 3)).astype(np.float32)
    run = run_over(means, view=turned)
    assert_same(sorter, [run], FOCUS, uploaded(sorter.ctx, means))
    row = slice_table([run], FOCUS)[0]
    k = row["depth_row"].astype(np.float64)
    fused = (means.astype(np.float64) @ k[:3] + k[3]).astype(np.float32)
    once = np.argsort(np.rint(fused * np.float32(2.0**14)), kind="stable")
    assert (once != order_runs([run], FOCUS)).any()  # so this test would see it


def test_runs_with_gaps_and_of_other_views(sorter):
    means = np.random.default_rng(4).normal(0.0, 30.0, (40_000, 3)).astype(np.float32).round()
    behind = AnchoredView(VIEW.rows, VIEW.depth + 3.0 * FRAME.unit, -VIEW.z_axis)
    runs = [
        run_over(means, 0, 5000),
        run_over(means, 5001, 5001),  # empty
        run_over(means, 7000, 23_001, behind),
        run_over(means, 23_003, 23_004),
        run_over(means, 5000, 5001),  # records need not ascend
        run_over(means, 30_000, 40_000),
    ]
    assert_same(sorter, runs, FOCUS, uploaded(sorter.ctx, means))


def test_nothing_is_left_of_a_larger_frame(sorter):
    means = np.random.default_rng(5).normal(0.0, 300.0, (30_000, 3)).astype(np.float32)
    records = uploaded(sorter.ctx, means)
    for n in (30_000, 500, 0, 3000):
        assert_same(sorter, [run_over(means, 0, n)] if n else [], FOCUS, records)


def test_the_same_frame_twice_is_the_same_and_keeps_its_buffers(sorter):
    means = np.random.default_rng(6).integers(-9, 9, (30_000, 3)).astype(np.float32)
    records = uploaded(sorter.ctx, means)
    first = sorter.order([run_over(means)], FOCUS, records)
    held, order = sorter.num_bytes, first.read()
    second = sorter.order([run_over(means)], FOCUS, records)
    assert second.index is first.index
    assert sorter.num_bytes == held
    np.testing.assert_array_equal(second.read(), order)


# ----------------------------------------------------------------- scenes


@dataclass
class Shown:
    """A scene on the GPU."""

    ctx: Any
    scene: Scene

    def __post_init__(self):
        self.buffer, self.blocks = SurfelBuffer(self.ctx), BlockTexture(self.ctx)
        for level in self.scene:
            self.buffer.stage((level.index, 0), level.surfels, level.index)
        self.buffer.upload()
        self.states = {level.index: self.state(level) for level in self.scene}

    def state(self, level):
        name = (level.index, 0)
        bounds, records = self.buffer.bounds(name), self.buffer.first_records(name)
        exact = SurfelSet(level.surfels, bounds, records, PAGE_SURFELS)
        return LevelState.of(level, (exact,), modulation(self.scene, level.index))

    @property
    def records(self):
        return self.buffer.buffer

    def select(self, camera, **choice):
        return select(self.states, camera, Choice(**choice))

    def cull(self, camera, modulated=True):
        views = {i: AnchoredView.expand(camera, s.level.frame) for i, s in self.states.items()}
        self.blocks.write(views, {i: s.modulation for i, s in self.states.items()})
        return SurfelCull(self.blocks.texture, (camera.width, camera.height), modulated)

    def release(self):
        self.buffer.release()
        self.blocks.release()


def chain(num_levels):
    image = np.random.default_rng(7).integers(0, 256, (64, 96, 3), dtype=np.uint8)
    return chain_scene(num_levels, image, relief_px=6.0)


@pytest.fixture(scope="module")
def short(sorter):
    made = Shown(sorter.ctx, chain(3))
    yield made
    made.release()


@pytest.mark.parametrize("culling", [True, False])
def test_a_zoom_of_eight_to_the_twelfth(sorter, culling):
    shown = Shown(sorter.ctx, chain(13))
    for index, angle in ((0, 0.0), (12, 0.0), (12, 8.0)):
        level = shown.scene[index]
        camera = orbited(level.camera, level.frame.origin, angle)
        chosen = shown.select(camera, culling=culling)
        made = assert_same(sorter, chosen.runs, chosen.focus, shown.records)
        assert made.count() == made.capacity
        assert made.count() >= (96 * 64 if culling else 13 * 96 * 64)
    shown.release()


def test_a_surfel_buffer_larger_than_a_block_goes_in_windows(sorter):
    shown = Shown(sorter.ctx, flat_scene(160, 120, num_levels=3))  # 6 pages of 16384 records
    camera = orbited(shown.scene[0].camera, shown.scene[0].frame.origin, 5.0)
    chosen = shown.select(camera, culling=False)
    block = 1 << 19
    table, parts = windows(
        slice_table(chosen.runs, chosen.focus), shown.records.size // RECORD_BYTES, block // RECORD_BYTES
    )
    assert len(parts) > 4
    assert sum(part.num_slices for part in parts) == len(table)
    small = ComputeOrder(sorter.ctx, block)
    assert small.fits(chosen.runs, shown.records)
    assert_same(small, chosen.runs, chosen.focus, shown.records)
    small.release()
    shown.release()


def test_what_does_not_fit_is_said(sorter):
    means = np.zeros((3 * TILE, 3), np.float32)
    records = uploaded(sorter.ctx, means)
    assert ComputeOrder(sorter.ctx, 2 * TILE * RECORD_BYTES).fits([run_over(means)], records)
    assert not ComputeOrder(sorter.ctx, TILE * RECORD_BYTES).fits([run_over(means)], records)
    tiny = ComputeOrder(sorter.ctx, 8 * TILE)
    assert not tiny.fits([run_over(means)], records)  # keys of three tiles
    with pytest.raises(ContextError, match="CPU"):
        tiny.order([run_over(means)], FOCUS, records)


def test_contexts_without_compute_are_recognised():
    assert not ComputeOrder.is_supported(SimpleNamespace(version_code=330))
    assert not ComputeOrder.is_supported(SimpleNamespace(version_code=420))
    assert ComputeOrder.is_supported(SimpleNamespace(version_code=430))


def test_what_the_shaders_take_for_granted():
    assert TILE == THREADS // 32 * RADIX  # the masks of two stripes become the sorted tile
    assert THREADS == RADIX
    assert len(BINDINGS) <= 8  # promised by OpenGL 4.3
    shared_words = 2 * TILE + 3 * RADIX + 4 * THREADS
    assert 4 * shared_words <= 32768  # promised by OpenGL 4.3


# ----------------------------------------------------------------- cull


def seen_by_numpy(scene, chosen, margin, weight_floor, modulated=True):
    """Mask over the surfels of a selection, by the reference's own projection."""
    camera, masks = chosen.camera, []
    for run in chosen.runs:
        part = unpack(pack(scene[run.level.index].surfels.take(run.piece), 0))
        w = np.ones(len(part))
        if modulated:
            w = reference.level_weights(scene, run.level.index, part, camera)
        feet = reference.footprints(part, run.frame, camera, w, chosen.focus)
        slack = margin * (1.0 + np.abs(feet.centers_px) + feet.extents_px)
        low, high = feet.centers_px - feet.extents_px - slack, feet.centers_px + feet.extents_px + slack
        inside = ((high > 0) & (low < (camera.width, camera.height))).all(1)
        masks.append(inside & (w >= weight_floor) & (feet.depths > 0))
    return np.concatenate(masks)


def cull_views(scene):
    yield scene[0].camera
    yield scene[0].camera.zoomed(30.0, 20.0, 2.83)  # between two levels
    yield orbited(scene[1].camera, scene[1].frame.origin, 25.0)
    aside = orbited(scene[0].camera, scene[0].frame.origin, 70.0)
    for distance in (0.9, 1.1):  # the surface is partly behind the camera; then its anchor is, too
        yield moved(aside, distance)


def moved(camera, distance):
    """A camera further along its own axis, world units."""
    pose = camera.camera_from_world.copy()
    pose[2, 3] -= distance
    return Camera(pose, camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)


def test_what_is_too_small_to_be_drawn_is_not_sorted(sorter, short):
    picture = Picture(sorter.ctx, short, False)
    camera = orbited(short.scene[0].camera.zoomed(30.0, 20.0, 0.5), short.scene[0].frame.origin, 50.0)
    chosen = short.select(camera, culling=False)
    cull, counts = short.cull(camera), []
    for least in (0.0, 0.5, 1.0):  # px^2; sigma .275 px and the low-pass make 0.6 where it is not tilted
        order = sorter.order(chosen.runs, chosen.focus, short.records, replace(cull, contribution_min=least))
        whole = sorter.ctx.buffer(order_runs(chosen.runs, chosen.focus)[::-1].tobytes())
        expected = picture.draw(camera, whole, contribution_min=least)
        counts.append(order.count())
        color = picture.draw(camera, order.index, order.indirect, least)
        np.testing.assert_array_equal(color, expected)
    assert counts[0] > 2 * counts[1] > 4 * counts[2] > 0  # measured 6144, 2764, 875


@pytest.mark.parametrize("modulated", [True, False])
def test_a_culled_order_is_the_order_of_what_is_seen(sorter, short, modulated):
    shares = []
    for camera in cull_views(short.scene):
        chosen = short.select(camera, culling=False, modulated=modulated)
        made = sorter.order(chosen.runs, chosen.focus, short.records, short.cull(camera, modulated))
        order, whole = made.read(), order_runs(chosen.runs, chosen.focus)
        records = np.concatenate([run.records() for run in chosen.runs])
        kept = np.isin(records, order)
        surely = seen_by_numpy(short.scene, chosen, -1e-5, 1.05 * WEIGHT_MIN, modulated)
        perhaps = seen_by_numpy(short.scene, chosen, 2e-4, 0.75 * WEIGHT_MIN, modulated)
        assert not (surely & ~kept).any()
        assert not (kept & ~perhaps).any()
        assert (perhaps & ~surely).mean() < 0.01  # so the two lines above mean something
        np.testing.assert_array_equal(order, whole[np.isin(whole, records[kept])][::-1])
        shares.append(kept.mean())
    assert min(shares) < 0.1  # measured 0.04; 0.3 to 0.7 where nothing is behind the camera


def test_a_view_of_nothing_draws_nothing(sorter, short):
    near = short.scene[0].camera.zoomed(48.0, 32.0, 100.0)
    away = Camera(near.camera_from_world, near.fx, near.fy, near.cx + 1e6, near.cy, near.width, near.height)
    chosen = short.select(away, culling=False)
    made = sorter.order(chosen.runs, chosen.focus, short.records, short.cull(away))
    assert made.count() == 0
    assert len(made.read()) == 0
    assert made.capacity == 3 * 96 * 64


class Picture:
    """Draws an element index with the renderer's shaders and blending."""

    def __init__(self, ctx, shown, quads):
        macros = {"QUADS": quads, "INT16_STEPS": INT16_STEPS, "POINT_SLACK_PX": 0.05}
        geometry = "surfel.geom" if quads else None
        self.ctx, self.shown, self.guard = ctx, shown, 0 if quads else 64
        self.program = load_program(ctx, "surfel.vert", "surfel.frag", geometry, macros)

    def draw(self, camera, index, indirect=None, contribution_min=0.0):
        content = [(self.shown.records, RECORD_FORMAT, *RECORD_ATTRIBUTES)]
        array = self.ctx.vertex_array(self.program, content, index, 4, skip_errors=True)
        size, guard = (camera.width, camera.height), self.guard
        texture = self.ctx.texture(size, 4, dtype="f4")
        target = self.ctx.framebuffer([texture])
        self.shown.blocks.texture.use(0)
        values = {"u_size_px": size, "u_guard_px": float(guard), "t_levels": 0}
        values["u_contribution_min"] = contribution_min
        for name, value in values.items():
            self.program[name] = value
        target.clear(0.0, 0.0, 0.0, 0.0)
        target.viewport = (-guard, -guard, size[0] + 2 * guard, size[1] + 2 * guard)
        target.use()
        self.ctx.enable_only(moderngl.BLEND | moderngl.PROGRAM_POINT_SIZE)
        self.ctx.blend_func = (moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)
        if indirect is None:
            array.render(moderngl.POINTS)
        else:
            array.render_indirect(indirect, moderngl.POINTS, 1)
        self.ctx.enable_only(moderngl.NOTHING)
        pixels = np.frombuffer(texture.read(), np.float32)
        for thing in (array, target, texture):
            thing.release()
        return pixels.reshape(camera.height, camera.width, 4)


@pytest.mark.parametrize("quads", [False, True])
def test_the_picture_is_the_same(sorter, short, quads):
    ctx, picture, counts = sorter.ctx, Picture(sorter.ctx, short, quads), []
    for camera in cull_views(short.scene):
        chosen = short.select(camera, culling=False)
        cull = short.cull(camera)
        index = ctx.buffer(order_runs(chosen.runs, chosen.focus)[::-1].tobytes())
        expected = picture.draw(camera, index)
        assert expected[..., 3].max() > 0.5
        for how in (None, cull):
            order = sorter.order(chosen.runs, chosen.focus, short.records, how)
            np.testing.assert_array_equal(picture.draw(camera, order.index, order.indirect), expected)
            counts.append(order.count())
    assert counts[-1] < counts[-2] / 10  # the cull did drop some


# ----------------------------------------------------------------- shaders


def test_a_mistake_is_named_by_file_and_line(sorter, tmp_path):
    (tmp_path / "bad.comp").write_text("layout(local_size_x = 1) in;\nvoid main() { nonsense(); }\n")
    with pytest.raises(ShaderError, match=r"bad\.comp:2: error.*nonsense"):
        load_compute(sorter.ctx, "bad.comp", root=tmp_path)


def test_released_buffers_are_made_again(gl_context, sorter):
    made = ComputeOrder(gl_context.ctx)
    means = np.random.default_rng(8).normal(0.0, 3.0, (300, 3)).astype(np.float32)
    records = uploaded(gl_context.ctx, means)
    assert_same(made, [run_over(means)], FOCUS, records)
    assert made.num_bytes > 0
    made.release()
    assert made.num_bytes == 0
    assert_same(made, [run_over(means)], FOCUS, records)
    made.release()


def test_a_draw_of_points_reads_the_command(sorter):
    """The buffer starts with count, instances, first index, base vertex, base instance."""
    means = np.random.default_rng(9).normal(0.0, 3.0, (300, 3)).astype(np.float32)
    made = sorter.order([run_over(means)], FOCUS, uploaded(sorter.ctx, means))
    assert np.frombuffer(made.indirect.read(20), np.uint32).tolist() == [300, 1, 0, 0, 0]
    assert made.index.size >= 4 * 300
    assert isinstance(made.index, moderngl.Buffer)
