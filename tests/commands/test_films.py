"""Films: every frame at its time, whole or not at all; their paths out and in again; transparency."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from tests.core.builders import small_scene
from wzviewer.cli import main
from wzviewer.commands import cameras, films
from wzviewer.commands.films import gif_size, why_not, write_film
from wzviewer.commands.progress import Progress
from wzviewer.core.camera import Camera
from wzviewer.core.files import save_scene
from wzviewer.core.path_files import PathFile, path_record, read_path_file
from wzviewer.errors import OutputError

SILENT = Progress(silent=True)


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "scene.wz"
    save_scene(small_scene(3), path)
    return path


def frames_of(path):
    """All frames (n, h, w, 3) of a film, and its length in s."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24"]
    done = subprocess.run([*command, "-"], capture_output=True, check=True)
    told = done.stderr.decode()
    width, height = map(int, re.search(r"Video: .*?, (\d+)x(\d+)", told).groups())
    minutes, seconds = re.search(r"Duration: 00:(\d+):([\d.]+)", told).groups()
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)
    return frames, 60 * int(minutes) + float(seconds)


def clips(count, width=64, height=48):
    """Frames of one colour each, at first very different ones."""
    colors = np.random.default_rng(0).integers(30, 225, (count, 3))
    return [np.full((height, width, 3), color, np.uint8) for color in colors]


@pytest.mark.parametrize(("suffix", "fps"), [(".mp4", 24.0), (".gif", 20.0), (".gif", 12.5)])
def test_every_frame_is_there_once_and_in_time(tmp_path, suffix, fps):
    wanted = clips(25)
    path = tmp_path / f"a{suffix}"
    write_film(path, iter(wanted), fps, len(wanted), SILENT)
    found, duration_s = frames_of(path)
    assert len(found) == 25
    assert duration_s == pytest.approx(25 / fps, abs=0.011)  # a GIF counts in hundredths
    error = np.abs(found.astype(int).mean((1, 2)) - np.stack(wanted).mean((1, 2))).max()
    assert error < 4.0  # measured 2.8 (chroma of the mp4) and 0 (GIF)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_the_same_frames_give_the_same_bytes(tmp_path, suffix):
    noise = np.random.default_rng(1).integers(0, 255, (6, 48, 64, 3), dtype=np.uint8)
    for name in "ab":
        write_film(tmp_path / f"{name}{suffix}", iter(noise), 20, 6, SILENT)
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_a_gif_has_a_palette_for_every_frame(tmp_path):
    """256 colours of one frame alone: a ramp of them comes back nearly as it was."""
    ramps = []
    for channel in range(3):
        ramp = np.zeros((64, 256, 3), np.uint8)
        ramp[..., channel] = np.arange(256)
        ramps.append(ramp)
    write_film(tmp_path / "a.gif", iter(ramps), 10, 3, SILENT)
    found, _ = frames_of(tmp_path / "a.gif")
    error = np.abs(found.astype(int) - np.stack(ramps)).mean()
    assert error < 0.1  # measured 0.017; one palette for the three: 0.29


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_a_fault_on_the_way_leaves_the_older_film(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"precious")

    def broken():
        yield from clips(12)
        raise MemoryError

    with pytest.raises(MemoryError):
        write_film(path, broken(), 24, 20, SILENT)
    assert path.read_bytes() == b"precious"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    with pytest.raises(OutputError):
        write_film(tmp_path / "no" / f"a{suffix}", iter(clips(2)), 24, 2, SILENT)


def test_gifs_are_limited_and_say_how():
    assert not why_not(".mp4", 7680, 4320, 10_000, 60.0)
    assert not why_not(".gif", 640, 424, 180, 20.0)
    assert "too large" in why_not(".gif", 1920, 1080, 180, 20.0)
    assert "at most 50" in why_not(".GIF", 64, 64, 10, 60.0)
    assert gif_size(1088, 720) == (640, 424)
    assert gif_size(300, 600) == (300, 600)


def test_zoom_films_last_as_long_as_is_asked_for():
    scene = small_scene(3)
    natural = cameras.zoom_path(scene, 2)
    assert len(natural) == round(24 * (3 * 0.8 + 2 * 2.0))  # three rests, two legs
    for fps, seconds in ((20.0, 6.0), (60.0, 2.5)):
        path = cameras.zoom_path(scene, 2, fps, seconds)
        assert len(path) == round(fps * seconds)
        assert path[0].key == scene[0].camera.key
        assert path[-1].key == scene[2].camera.key


def test_a_swing_has_its_angle_and_is_closed():
    camera = Camera.initial(64, 48)
    pivot = np.array([0.1, 0.0, 1.0])
    path = cameras.swing(camera, pivot, 25.0, 10.0, 4.0)
    turns = [np.degrees(np.arctan2(c.rotation[0, 2], c.rotation[0, 0])) for c in path]
    assert len(path) == 40
    assert max(map(abs, turns)) == pytest.approx(25.0, abs=1e-6)
    assert turns[0] == 0.0
    assert abs(turns[-1]) < 5.0  # one step before the start


def test_frames_of_a_file_are_taken_as_they_are_or_resampled():
    frames = [Camera.initial(64, 48).zoomed(32.0, 24.0, 1.0 + i) for i in range(10)]
    found = PathFile(frames, fps=10.0)
    assert cameras.film_frames_of(found, 10.0) == frames
    assert cameras.film_frames_of(found, 20.0) == [f for f in frames for _ in range(2)]
    assert cameras.film_frames_of(found, 10.0, 0.5) == frames[::2]


@pytest.mark.gl
def test_a_path_goes_out_and_comes_in_again(capsys, tmp_path, scene_file):
    out, path = tmp_path / "a.gif", tmp_path / "p.json"
    words = ["render", str(scene_file), "-o", str(out), "--seconds", "0.5", "--size", "64x48"]
    assert main([*words, "--path-out", str(path)]) == 0
    found = read_path_file(path)
    assert len(found.frames) == len(frames_of(out)[0]) == 10
    assert found.fps == 20.0
    assert json.loads(path.read_text())["render_width"] == 64
    again = tmp_path / "b.gif"
    assert main(["render", str(scene_file), "-o", str(again), "--path", str(path)]) == 0
    assert again.read_bytes() == out.read_bytes()


@pytest.mark.gl
def test_a_transparent_picture_over_the_background_is_the_opaque_one(capsys, tmp_path, scene_file):
    import cv2

    words = ["render", str(scene_file), "--level", "0", "--magnify", ".6", "--size", "96x64"]
    assert main([*words, "-o", str(tmp_path / "a.png")]) == 0
    assert main([*words, "-o", str(tmp_path / "b.png"), "--transparent"]) == 0
    opaque = cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED).astype(float)
    clear = cv2.imread(str(tmp_path / "b.png"), cv2.IMREAD_UNCHANGED).astype(float)
    assert clear.shape == (64, 96, 4)
    assert (clear[..., 3] == 0).any()
    assert (clear[..., 3] > 128).any()
    over_black = clear[..., :3] * clear[..., 3:] / 255.0
    assert np.abs(over_black - opaque).max() <= 1.6  # measured 1: rounded twice


@pytest.mark.gl
def test_a_film_that_is_told_to_end_leaves_nothing(tmp_path, scene_file):
    camera = Camera.initial(64, 48)
    frames = [camera.zoomed(32.0, 24.0, 1.0 + i / 9000) for i in range(9000)]
    (tmp_path / "p.json").write_text(json.dumps(path_record(PathFile().keys, frames, 24.0)))
    out = tmp_path / "out"
    out.mkdir()
    words = ["render", str(scene_file), "-o", str(out / "a.gif"), "--path", str(tmp_path / "p.json")]
    command = [sys.executable, "-m", "wzviewer", *words, "--fps", "20"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ)
    assert process.stderr is not None
    for line in process.stderr:
        if "frame 10" in line:
            break
    process.send_signal(signal.SIGTERM)
    rest = process.stderr.read()
    process.stderr.close()
    assert process.wait(20) == 130, rest
    assert "interrupted" in rest
    time.sleep(0.1)
    assert list(out.iterdir()) == []


def test_the_encoder_keeps_the_suffix_of_its_part():
    assert set(films.SUFFIXES) == {".mp4", ".gif"}
