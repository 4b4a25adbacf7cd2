import os

from wzviewer.kernels.freshness import drop_stale


def test_only_what_is_older_than_a_source_is_dropped(tmp_path):
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    for name, age_s in (("old.nbi", 100), ("old.1.nbc", 100), ("new.nbi", 0), ("old.pyc", 100)):
        (cache / name).write_bytes(b"")
        os.utime(cache / name, (1e9 - age_s, 1e9 - age_s))
    for name, age_s in (("kernel.py", 500), ("callee.py", 50)):
        (tmp_path / name).write_text("", "utf-8")
        os.utime(tmp_path / name, (1e9 - age_s, 1e9 - age_s))
    assert drop_stale(tmp_path) == 2
    assert sorted(p.name for p in cache.iterdir()) == ["new.nbi", "old.pyc"]
    assert drop_stale(tmp_path) == 0


def test_a_package_without_a_cache_is_left_alone(tmp_path):
    assert drop_stale(tmp_path) == 0
