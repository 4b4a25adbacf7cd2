"""Settings: kept whole, and never a reason not to start."""

import json

import pytest

from wzviewer.app.settings import FONT_RANGE_PT, Settings, SettingsFile, read_settings


def test_settings_survive(tmp_path):
    file = SettingsFile(tmp_path / "folder" / "settings.json")
    assert file.load() == (Settings(), "")
    chosen = Settings("light", 19.0, True, False, "shaders", "authors", True)
    assert file.save(chosen) == ""
    assert file.load() == (chosen, "")
    assert [p.name for p in file.path.parent.iterdir()] == ["settings.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", "[" * 5000, "\x00"])
def test_a_damaged_file_gives_the_defaults_and_a_sentence(tmp_path, text):
    path = tmp_path / "settings.json"
    path.write_text(text)
    settings, complaint = SettingsFile(path).load()
    assert settings == Settings()
    assert "defaults" in complaint


def test_every_wrong_value_is_the_default_and_named():
    record = {"theme": "pink", "font_pt": 400, "reduced_motion": "yes", "auto_detail": 1, "rasterizer": None}
    record |= {"keymap": 3, "hint_seen": "no"}
    assert read_settings(record) == (Settings(), tuple(record))
    assert read_settings({"font_pt": True})[1] == ("font_pt",)
    assert read_settings({"font_pt": FONT_RANGE_PT[1], "later": 3})[0].font_pt == FONT_RANGE_PT[1]


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    file = SettingsFile(tmp_path / "file" / "settings.json")
    assert "could not be kept" in file.save(Settings())


def test_a_sentence_names_what_was_reset(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(json.dumps({"theme": "pink"}))
    assert SettingsFile(path).load() == (Settings(), "Settings reset to the default: theme.")
