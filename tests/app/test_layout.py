"""No two panels share a place, whatever the window."""

from dataclasses import replace
from itertools import combinations

import pytest

from tests.app.fakes import make_scene, state_with
from wzviewer.app.layout import MARGIN_PT, arrange
from wzviewer.app.panels.timeline import HEIGHT_PT
from wzviewer.app.panels.tree import with_unit
from wzviewer.app.panels.wording import count_text, left_text, magnification_text, share_text


@pytest.mark.parametrize("size", [(480, 360), (640, 480), (820, 560), (900, 600), (1280, 800), (3840, 2160)])
@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_panels_do_not_overlap(size, scale):
    if size[0] / scale < 480 or size[1] / scale < 360:
        pytest.skip("smaller than the smallest window")
    layout = arrange(*size, scale)
    standing = {
        k: getattr(layout, k)
        for k in ("toolbar", "breadcrumb", "tree", "prompt", "scale_bar", "status", "locator")
    }
    for (a, one), (b, other) in combinations(standing.items(), 2):
        assert not one.overlaps(other), (a, b)
    for rect in standing.values():
        assert rect.x >= 0
        assert rect.right <= size[0]
        assert rect.bottom <= size[1]
    assert layout.prompt.width >= 300 * scale or layout.prompt.width >= size[0] - 30 * scale
    assert not layout.tree.overlaps(layout.statistics)
    above = replace(layout.stack, y=layout.prompt.y - 200 * scale, height=190 * scale)
    assert not above.overlaps(layout.locator)
    assert layout.stack == layout.prompt or not above.overlaps(layout.tree)
    assert (layout.locator.width > 0) == (size[0] / scale > 708 and size[1] / scale >= 420)


@pytest.mark.parametrize("size", [(900, 600), (1280, 800), (3840, 2160)])
def test_nothing_stands_where_the_timeline_is(size):
    foot = HEIGHT_PT + MARGIN_PT
    layout = arrange(size[0], size[1] - foot, 1.0)
    for rect in (layout.tree, layout.prompt, layout.scale_bar, layout.status, layout.statistics):
        assert rect.bottom <= size[1] - foot


def test_magnifications_read_well():
    texts = {
        1.0: "×1.0",
        7.96: "×8.0",
        64: "×64",
        32768: "×32,768",
        2.1e6: "×2.1 million",
        8.0**12: "×68.7 billion",
    }
    for value, text in texts.items():
        assert magnification_text(value) == text


def test_counts_read_well():
    assert [count_text(n) for n in (512, 83_400, 999_600, 1_234_567)] == ["512", "83 k", "1.0 M", "1.2 M"]


def test_lengths_are_told_in_widths_of_the_photo():
    texts = {
        5.0: "5 × the photo",
        1.0: "as wide as the photo",
        0.5: "1/2 of the photo",
        0.05: "1/20 of the photo",
        2e-4: "1/5,000 of the photo",
        1e-6: "1/1 million of the photo",
        5e-10: "1/2 billion of the photo",
        2e-13: "1/5 trillion of the photo",
    }
    assert {k: share_text(k) for k in texts} == texts


def test_magnifications_are_shorter_where_there_is_little_room():
    for value, text in ((8.0, "×8.0"), (32768.0, "×32,768"), (262144.0, "×262 k"), (2.1e6, "×2.1 M")):
        assert magnification_text(value, is_short=True) == text
    assert magnification_text(6.9e10, is_short=True) == "×7e10"


@pytest.mark.parametrize(
    ("elapsed_s", "fraction", "text"),
    [
        (2.0, 0.5, ""),
        (60.0, 0.01, ""),
        (30.0, 0.5, "30 s left"),
        (31.0, 0.5, "35 s left"),
        (60.0, 0.2, "4 min left"),
        (9.0, 1.0, "5 s left"),
    ],
)
def test_what_takes_long_says_how_long_still(elapsed_s, fraction, text):
    assert left_text(elapsed_s, fraction) == text


@pytest.mark.parametrize(("room", "line"), [(200.0, "×24 · 799 k points"), (90.0, "×24 · 799 k")])
def test_a_row_of_the_tree_says_what_it_counts_where_there_is_room(screen, room, line):
    lines = []
    screen.frame(
        state_with(make_scene(1)), draw=lambda state, ui: lines.append(with_unit("×24 · 799 k", room)) or []
    )
    assert lines == [line]
