import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.core.builders import small_scene
from wzviewer.cli import VERBS, build_parser, main
from wzviewer.core.files import save_scene
from wzviewer.core.photos import encode_png


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    rng = np.random.default_rng(0)
    path.write_bytes(encode_png(rng.integers(0, 255, (64, 96, 3), dtype=np.uint8)))
    return path


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "scene.wz"
    save_scene(small_scene(3), path)
    return path


def run(capsys, *words):
    try:
        status = main([str(w) for w in words])
    except SystemExit as end:
        status = end.code
    return status, capsys.readouterr()


def assert_refused(outcome):
    status, streams = outcome
    assert status == 2
    assert streams.out == ""
    assert streams.err.startswith("error: ")
    assert streams.err.count("\n") == 1


BAD_GENERATE = {
    "no image": [],
    "missing image": ["none.jpg"],
    "zoom outside": ["photo.png", "--zoom", "1.2,.5"],
    "zoom negative": ["photo.png", "--zoom=-.1,.5"],
    "zoom no number": ["photo.png", "--zoom", "a,b"],
    "zoom nan": ["photo.png", "--zoom", "nan,.5"],
    "zoom one number": ["photo.png", "--zoom", ".5"],
    "factor out of range": ["photo.png", "--zoom", ".5,.5,1000"],
    "prompt without zoom": ["photo.png", "--prompt", "a ladybug"],
    "unknown prompt": ["photo.png", "--zoom", ".5,.5", "--prompt", "a zeppelin made of soup"],
    "negative seed": ["photo.png", "--seed", "-1"],
    "bad size": ["photo.png", "--size", "big"],
    "missing script": ["photo.png", "--script", "none.toml"],
    "unknown synthesizer": ["photo.png", "--synthesizer", "magic"],
    "unknown option": ["photo.png", "--colour"],
}


@pytest.mark.parametrize("words", BAD_GENERATE.values(), ids=BAD_GENERATE.keys())
def test_bad_generate_is_one_line_and_status_2(capsys, tmp_path, monkeypatch, photo, words):
    monkeypatch.chdir(tmp_path)
    assert_refused(run(capsys, "generate", *words, "-o", tmp_path / "out.wz"))
    assert not (tmp_path / "out.wz").exists()


@pytest.mark.parametrize("name", ["text.jpg", "zero.png", "cut.png", "folder"])
def test_bad_photos_are_one_line_and_status_2(capsys, tmp_path, photo, name):
    path = tmp_path / name
    if name == "folder":
        path.mkdir()
    else:
        path.write_bytes({"text.jpg": b"hello", "zero.png": b"", "cut.png": photo.read_bytes()[:300]}[name])
    for verb in (["generate", path, "-o", tmp_path / "out.wz"], ["open", path], [path]):
        assert_refused(run(capsys, *verb))


def test_an_output_that_cannot_be_written_is_refused_before_any_work(capsys, tmp_path, photo):
    assert_refused(run(capsys, "generate", photo, "-o", tmp_path / "nowhere" / "out.wz"))
    assert_refused(run(capsys, "generate", photo, "-o", tmp_path))


def test_an_older_file_survives_a_refusal(capsys, tmp_path, photo):
    older = tmp_path / "out.wz"
    older.write_bytes(b"precious")
    assert_refused(run(capsys, "generate", photo, "--zoom", "2,2", "-o", older))
    assert older.read_bytes() == b"precious"


@pytest.mark.parametrize(
    "words",
    [
        ["--level", "7"],
        ["--level", "-1"],
        ["--magnify", "0"],
        ["--orbit", "720"],
        ["--size", "0x0"],
        ["--path", "none.json", "-o", "x.mp4"],
        ["--path", "orbit", "--orbit", "720", "-o", "x.mp4"],
        ["--fps", "0", "-o", "x.mp4"],
        ["--fps", "60", "-o", "x.gif"],
        ["--seconds", "nan", "-o", "x.mp4"],
        ["--size", "4000x4000", "-o", "x.gif"],
        ["--transparent", "-o", "x.mp4"],
        ["--path-out", "p.json"],
        ["--path-out", "nowhere/p.json", "-o", "x.mp4"],
    ],
)
def test_bad_render_is_one_line_and_status_2(capsys, tmp_path, monkeypatch, scene_file, words):
    monkeypatch.chdir(tmp_path)
    output = [] if "-o" in words else ["-o", "x.png"]
    assert_refused(run(capsys, "render", scene_file, *words, *output))


def test_render_refuses_other_suffixes_and_damaged_scenes(capsys, tmp_path, scene_file):
    assert_refused(run(capsys, "render", scene_file, "-o", tmp_path / "x.bmp"))
    scene_file.write_bytes(scene_file.read_bytes()[:2000])
    assert_refused(run(capsys, "render", scene_file, "-o", tmp_path / "x.png"))
    assert_refused(run(capsys, "info", scene_file))
    assert_refused(run(capsys, "open", scene_file))


def test_info_json_has_the_contracts_fields(capsys, scene_file):
    status, streams = run(capsys, "info", scene_file, "--json")
    record = json.loads(streams.out)
    assert status == 0
    assert set(record) == {"version", "surfels", "levels"}
    keys = {"index", "parent", "prompt", "surfels", "focal_px", "magnification", "image", "stages"}
    assert keys <= set(record["levels"][1])
    assert record["levels"][2]["magnification"] == pytest.approx(64.0)
    assert record["surfels"] == sum(level["surfels"] for level in record["levels"])


def test_info_prints_a_table(capsys, scene_file):
    status, streams = run(capsys, "info", scene_file)
    assert status == 0
    assert "ladybug" in streams.out


@pytest.mark.gl
def test_render_writes_picture_depth_and_film(capsys, tmp_path, scene_file):
    words = ["--level", "1", "--size", "96x64", "--depth", tmp_path / "d.npy"]
    status, _ = run(capsys, "render", scene_file, *words, "-o", tmp_path / "x.png")
    assert status == 0
    assert (tmp_path / "x.png").stat().st_size > 100
    depth = np.load(tmp_path / "d.npy", allow_pickle=False)
    assert depth.shape == (64, 96)
    path = tmp_path / "path.json"
    from wzviewer.core.camera import Camera
    from wzviewer.core.records import camera_to_json

    path.write_text(json.dumps({"frames": [camera_to_json(Camera.initial(64, 48))] * 5}))
    status, _ = run(capsys, "render", scene_file, "--path", path, "-o", tmp_path / "x.mp4")
    assert status == 0
    assert (tmp_path / "x.mp4").stat().st_size > 500


def test_help_and_version_are_quick_and_light():
    code = "import sys; from wzviewer.cli import main; main(['--version'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("wzviewer ")


def test_an_interrupt_ends_with_130(capsys, monkeypatch, scene_file):
    def interrupt(options):
        raise KeyboardInterrupt

    monkeypatch.setattr("wzviewer.commands.info.run", interrupt)
    assert run(capsys, "info", scene_file)[0] == 130


def test_a_script_says_the_same_as_the_command_line(tmp_path, photo):
    from wzviewer.cli import build_parser
    from wzviewer.commands.generate import plan_of

    script = tmp_path / "s.toml"
    zooms = (
        '[[zoom]]\nat = [0.5, 0.6]\nprompt = "a ladybug"\n[[zoom]]\nat = [0.5, 0.5]\nfactor = 4\nparent = 0\n'
    )
    script.write_text(f'image = "{photo.name}"\nseed = 3\n{zooms}')
    parser = build_parser()
    by_script = plan_of(parser.parse_args(["generate", "--script", str(script), "-o", "x.wz"]))
    assert by_script.image == Path(photo)
    assert by_script.zooms[0].prompt == "a ladybug"
    assert (by_script.zooms[1].factor, by_script.zooms[1].parent) == (4.0, 0)
    words = [
        "generate",
        str(photo),
        "--zoom",
        ".5,.6",
        "--prompt",
        "a ladybug",
        "--zoom",
        ".5,.5,4",
        "-o",
        "x.wz",
    ]
    by_words = plan_of(parser.parse_args([*words, "--seed", "3"]))
    assert by_words.zooms[0] == by_script.zooms[0]
    assert by_words.seed == 3


def test_models_list_says_what_can_be_asked_for_and_what_a_model_would_add(capsys):
    status, streams = run(capsys, "models", "list")
    assert status == 0
    for word in ("ladybug", "conch shell", "turquoise", "moss", "snow", "A downloaded model would add"):
        assert word in streams.out
    assert max(len(line) for line in streams.out.splitlines()) <= 100


def test_every_option_says_what_it_does():
    verbs = next(a for a in build_parser()._actions if a.dest == "verb")
    assert set(verbs.choices) == set(VERBS)
    pairs = [(name, action) for name, verb in verbs.choices.items() for action in verb._actions]
    assert [(name, action.dest) for name, action in pairs if not action.help] == []
    assert all(verb.description for verb in verbs.choices.values())


def test_view_is_understood_as_open(capsys):
    assert main(["view", "no-such.jpg"]) == 2
    assert capsys.readouterr().err.startswith("error: no-such.jpg: no such file")
