"""The GLSL twins of core/opacity.py and core/anchor.py, run in a fragment pass into float targets."""

import shutil
from dataclasses import replace
from importlib.resources import as_file, files

import moderngl
import numpy as np
import pytest

from tests.core.builders import random_surfels
from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import weights
from wzviewer.core.scene import Level, Scene, coverage_for, modulation
from wzviewer.gl.blocks import BlockTexture
from wzviewer.gl.shader import load_program

PROBE = """
#include "opacity.glsl"
uniform sampler2D t_means;
uniform sampler2D t_logs;
uniform int u_slot;
layout(location = 0) out vec4 out_weight;
layout(location = 1) out vec4 out_px;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 u = texelFetch(t_means, at, 0).xyz;
    vec4 logs = texelFetch(t_logs, at, 0);
    AnchoredView view = view_at(0, u_slot);
    float D = depth_ratio(view.g, u);
    float render = log_scale(view.g, u, 1.0);
    out_weight = vec4(surfel_weight(u_slot, u, render, logs.x, logs.y), render, D, 0.0);
    out_px = vec4(anchor_px(view) + offset_px(view, u, D), 0.0, 0.0);
}
"""
SIZE = (40, 25)
NUM_POINTS = 1000


@pytest.fixture(scope="module")
def probe(gl_context, tmp_path_factory):
    folder = tmp_path_factory.mktemp("shaders") / "copy"
    with as_file(files("wzviewer").joinpath("shaders")) as package:
        shutil.copytree(package, folder)
    (folder / "probe.frag").write_text(PROBE)
    ctx = gl_context.ctx
    program = load_program(ctx, "present.vert", "probe.frag", root=folder)
    targets = [ctx.texture(SIZE, 4, dtype="f4") for _ in range(2)]
    inputs = [ctx.texture(SIZE, 4, dtype="f4") for _ in range(2)]
    array, framebuffer, blocks = ctx.vertex_array(program, []), ctx.framebuffer(targets), BlockTexture(ctx)

    def run(surfels, slot, view, covers):
        blocks.write({slot: view}, {slot: covers})
        logs = np.stack([np.log2(surfels.native_scales), surfels.coverage], 1)
        inputs[0].write(np.pad(surfels.means, ((0, 0), (0, 1))).astype("f4").tobytes())
        inputs[1].write(np.pad(logs, ((0, 0), (0, 2))).astype("f4").tobytes())
        for unit, texture in enumerate((blocks.texture, *inputs)):
            texture.use(unit)
        names = {"t_levels": 0, "t_means": 1, "t_logs": 2, "u_slot": slot}
        for name, value in names.items():
            program[name] = value
        ctx.enable_only(moderngl.NOTHING)
        framebuffer.use()
        array.render(moderngl.TRIANGLES, vertices=3)
        return [np.frombuffer(t.read(), np.float32).reshape(-1, 4) for t in targets]

    yield run
    blocks.release()
    for thing in (*targets, *inputs, framebuffer, array, program):
        thing.release()


def random_tree(seed, num_levels=7):
    """Overlapping siblings, children of children, factors 2 to 9, tilted cameras; 1000 points each."""
    rng = np.random.default_rng(seed)
    scene, root = Scene(), Camera.initial(64, 48)
    for i in range(num_levels):
        parent = None if i == 0 else int(rng.integers(0, i))
        camera = (
            root
            if parent is None
            else scene[parent].camera.zoomed_to_region(*rng.random(2), 2 + 7 * rng.random())
        )
        frame = LevelFrame.of_camera(camera, 1.0 + 0.1 * rng.random())
        surfels = random_surfels(NUM_POINTS, seed + i)
        native = np.exp2(rng.normal(size=NUM_POINTS) * 0.1)
        coverage = coverage_for(scene, parent, camera, frame, surfels.means)
        blank = np.zeros((48, 64, 3), np.uint8)
        surfels = surfels.with_(native_scales=native, coverage=coverage)
        scene.append(Level(i, parent, camera, frame, surfels, blank, blank[..., 0].astype(np.float32)))
    return scene


def test_weights_in_the_shader_equal_those_in_numpy(probe):
    worst, partial = 0.0, 0
    for seed in range(4):
        scene = random_tree(seed)
        rng = np.random.default_rng(100 + seed)
        for level in scene:
            camera = scene[int(rng.integers(len(scene)))].camera.zoomed(
                *(rng.random(2) * 50), 0.5 + 3 * rng.random()
            )
            covers = replace(modulation(scene, level.index), cell_px=int(rng.choice([1, 2, 4])))
            view, s = AnchoredView.expand(camera, level.frame), level.surfels
            expected = weights(s.means, s.native_scales, s.coverage, view, covers, compensated=True)
            out, _ = probe(s, level.index, view, covers)
            worst = max(worst, float(np.abs(out[:, 0] - expected).max()))
            partial += int(((expected > 0.01) & (expected < 0.99)).sum())
    assert partial > 2000  # the cases are not all 0 and 1
    assert worst < 1e-5  # measured 1.4e-6


def test_projection_in_the_shader_equals_numpy(probe):
    scene = random_tree(9)
    for level in scene:
        camera = level.camera.zoomed(20.0, 20.0, 1.7)
        view = AnchoredView.expand(camera, level.frame)
        out, px = probe(level.surfels, level.index, view, modulation(scene, level.index))
        expected = view.project(level.surfels.means)
        np.testing.assert_allclose(px[:, :2], expected, atol=3e-5)  # measured 8e-6 px
        np.testing.assert_allclose(out[:, 1], view.log_scale(level.surfels.means), atol=1e-5)  # measured 2e-7
        np.testing.assert_allclose(out[:, 2], view.depth_ratio(level.surfels.means), rtol=1e-6)
