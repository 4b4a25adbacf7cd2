"""The comparison with other viewers: its scenes, and what it does without the viewers.  No network."""

import importlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from wzviewer.core.anchor import AnchoredView

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
PEERS = ["playcanvas", "gaussiansplats3d", "spark", "f3d"]


@pytest.fixture
def scenes(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("scenes")


@pytest.fixture
def peers(scenes):
    return importlib.import_module("peers")


@pytest.fixture
def plan(peers, tmp_path):
    return peers.Plan(tmp_path, runs=2, frames=3, warm=1, chromium=None)


@pytest.fixture
def few(scenes):
    return scenes.SceneSpec("few", 500, 10.0, seed=3)


def read_ply(path):
    data = path.read_bytes()
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    names = [line.split()[2] for line in lines if line.startswith("property float ")]
    rows = np.frombuffer(body, "<f4").reshape(count, len(names))
    return {name: rows[:, i] for i, name in enumerate(names)}


@pytest.mark.parametrize("num_rest", [0, 45])
def test_ply_holds_the_splats(scenes, few, tmp_path, num_rest):
    splats = scenes.make_splats(few)
    scenes.write_ply(tmp_path / "few.ply", splats, num_rest)
    read = read_ply(tmp_path / "few.ply")
    assert len(read) == 17 + num_rest
    assert all(not read[f"f_rest_{i}"].any() for i in range(num_rest))
    columns = lambda *names: np.stack([read[n] for n in names], 1)  # noqa: E731
    assert np.array_equal(columns("x", "y", "z"), splats.means)
    assert np.array_equal(columns("rot_0", "rot_1", "rot_2", "rot_3"), splats.quats)
    sigmas = np.exp(columns("scale_0", "scale_1", "scale_2"))
    colors = 0.5 + scenes.SH_BAND_0 * columns("f_dc_0", "f_dc_1", "f_dc_2")
    opacities = 1 / (1 + np.exp(-read["opacity"]))
    assert np.abs(sigmas / splats.scales - 1).max() < 2e-6  # measured 3.6e-7
    assert np.abs(colors - splats.colors).max() < 1e-6  # measured 6e-8
    assert np.abs(opacities - 0.6).max() < 1e-6  # measured 0


def test_splat_file_holds_the_splats(scenes, few, tmp_path):
    splats = scenes.make_splats(few)
    scenes.write_splat(tmp_path / "few.splat", splats)
    data = (tmp_path / "few.splat").read_bytes()
    assert len(data) == 32 * len(splats)
    rows = np.frombuffer(data, np.uint8).reshape(-1, 32)
    floats = rows[:, :24].copy().view("<f4")
    assert np.array_equal(floats[:, :3], splats.means)
    assert np.array_equal(floats[:, 3:], splats.scales)
    assert np.abs(rows[:, 24:27] / 255 - splats.colors).max() <= 0.5 / 255 + 1e-6  # rounding
    assert (rows[:, 27] == 153).all()  # 0.6 of 255
    assert (rows[:, 28:] == [255, 128, 128, 128]).all()  # identity; 1 is cut to 127 / 128


def test_scenes_repeat_and_differ_by_seed(scenes, few):
    first, again = scenes.make_splats(few), scenes.make_splats(few)
    assert np.array_equal(first.means, again.means)
    assert np.array_equal(first.colors, again.colors)
    other = scenes.make_splats(scenes.SceneSpec("few", 500, 10.0, seed=4))
    assert not np.array_equal(first.means, other.means)


def test_two_scenes_of_like_overdraw(scenes):
    assert [(s.num_surfels, s.diameter_px) for s in scenes.SCENES.values()] == [
        (200_000, 10.0),
        (1_000_000, 5.0),
    ]


def test_written_scene_is_kept_until_the_recipe_changes(scenes, few, tmp_path):
    scenes.write_scene(tmp_path, few)
    ply = tmp_path / "few.ply"
    before = ply.stat().st_mtime_ns
    os.utime(ply, ns=(before - 10**9, before - 10**9))
    scenes.write_scene(tmp_path, few)
    assert ply.stat().st_mtime_ns == before - 10**9
    scenes.write_scene(tmp_path, scenes.SceneSpec("few", 400, 10.0))
    assert len(read_ply(ply)["x"]) == 400


def test_camera_orbits_the_middle_of_the_box(scenes):
    poses = scenes.orbit_poses()
    for pose in poses:
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.allclose(pose[:3, 3], [0, 0, scenes.DISTANCE])
    turns = np.degrees(np.arctan2(poses[:, 0, 2], poses[:, 0, 0]))
    assert np.allclose(np.diff(turns), scenes.STEP_DEG)
    assert np.allclose(turns[[0, -1]], [-12, 12])


def test_ours_is_the_same_scene(scenes, few, tmp_path):
    ours = importlib.import_module("ours")
    scenes.write_scene(tmp_path, few)
    cameras = ours.read_cameras(tmp_path)
    splats = scenes.make_splats(few)
    level = ours.make_scene(splats, cameras[len(cameras) // 2])[0]
    for camera in (cameras[0], cameras[-1]):
        seen = AnchoredView.expand(camera, level.frame).project(level.surfels.means)
        true = camera.project(splats.means.astype(np.float64))[:, :2]
        assert np.abs(seen - true).max() < 1e-3  # px; measured 1.2e-4
    assert np.allclose(level.surfels.scales, few.diameter_px / 6, rtol=1e-5)  # native px
    assert np.array_equal(level.surfels.colors, splats.colors)
    assert (level.surfels.opacities == np.float32(0.6)).all()


def run_peers(*arguments, **environment):
    command = [sys.executable, str(BENCHMARKS / "peers.py"), *arguments]
    env = os.environ | environment
    return subprocess.run(command, capture_output=True, text=True, env=env, timeout=60, check=False)


def test_help():
    done = run_peers("--help")
    assert done.returncode == 0
    assert all(name in done.stdout for name in ["ours", *PEERS])


def test_absent_peers_are_named_and_skipped(tmp_path):
    done = run_peers(
        "--json", "--work", str(tmp_path), "--scenes", "200k", "--only", *PEERS, PATH=str(tmp_path)
    )
    assert done.returncode == 0, done.stderr
    programs = json.loads(done.stdout)["programs"]
    assert list(programs) == PEERS
    for name, entry in programs.items():
        assert "not installed" in entry["absent"]
        assert "scenes" not in entry
        assert f"{name}: skipped" in done.stderr


def test_absent_npm_package_is_named(peers, plan, monkeypatch):
    monkeypatch.setattr(peers.shutil, "which", lambda name: f"/bin/{name}")
    spark = next(p for p in peers.PROGRAMS if p.name == "spark")
    assert "Chromium" in spark.missing(plan)
    found = peers.Plan(plan.work, 1, 1, 1, "/bin/chromium")
    assert "@sparkjsdev/spark" in spark.missing(found)


def script(peers, code):
    return peers.Program("script", "Script", lambda plan: None, lambda plan: [sys.executable, "-c", code])


def test_medians_and_picture_of_a_program(peers, plan, few):
    reference = peers.picture_path(plan, peers.PROGRAMS[0], few)
    reference.parent.mkdir()
    image = np.random.default_rng(0).integers(0, 256, (72, 128, 3), np.uint8)
    image[:, :64] //= 4
    cv2.imwrite(str(reference), image)
    code = """if True:
        import json, shutil, sys
        picture = sys.argv[sys.argv.index("--picture") + 1]
        shutil.copy(picture.replace("script", "ours"), picture)
        print("chatter")
        print(json.dumps({"version": "1", "renderer": "llvmpipe", "runs_ms": [[1, 2, 3], [4, 5, 100]]}))
    """
    result = peers.measure([script(peers, code)], [few], plan)["script"]["scenes"]["few"]
    assert result["median_ms"] == 3.5
    assert result["run_medians_ms"] == [2, 5]
    assert result["num_frames"] == 6
    assert result["picture_difference"] == 0
    assert result["void"] is None
    mirrored = peers.picture_path(plan, script(peers, ""), few)
    cv2.imwrite(str(mirrored), image[:, ::-1])
    assert peers.picture_difference(mirrored, reference) > peers.DIFFERENCE_MAX


def test_time_without_a_picture_or_on_other_gl_is_void(peers, plan, few):
    program = script(peers, "")
    record = {"renderer": "llvmpipe", "picture_difference": 0.0}
    assert peers.void_reason(record, program, has_picture=True) is None
    assert peers.void_reason(record, program, has_picture=False) == "no picture"
    assert "SwiftShader" in peers.void_reason(record | {"renderer": "SwiftShader"}, program, True)
    assert peers.void_reason(record | {"picture_difference": None}, program, True)
    assert peers.void_reason(record | {"picture_difference": 50.0}, program, True) == "another picture"


def test_failure_is_reported_and_the_rest_goes_on(peers, plan, few):
    program = script(peers, "raise SystemExit('it broke')")
    programs = peers.measure([program, program], [few], plan)
    result = programs["script"]["scenes"]["few"]
    assert result == {"error": "exit status 1: it broke"}
    report = {"scenes": {"few": {}}, "programs": programs}
    assert "failed" in peers.table(report)


def test_npm_versions_are_pinned_and_told(peers):
    manifest = json.loads((BENCHMARKS / "web" / "package.json").read_text())
    text = (BENCHMARKS / "README.md").read_text()
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", v) for v in manifest["dependencies"].values())
    for name in ("playcanvas", "@mkkellogg/gaussian-splats-3d", "@sparkjsdev/spark", "three"):
        assert manifest["dependencies"][name] in text
    for peer in PEERS[:3]:
        assert (BENCHMARKS / "web" / "pages" / f"{peer}.mjs").is_file()
