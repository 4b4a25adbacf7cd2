"""No two plates share a place on the screen, whatever is shown at once and however large the window is."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from imgui_bundle import imgui

from tests.app.fakes import make_scene, state_with
from tests.app.test_panels import goal, making
from wzviewer.app.layout import Rect, arrange
from wzviewer.app.panels.surface import Ui
from wzviewer.app.panels.timeline import foot_height
from wzviewer.app.prompting import with_vocabulary
from wzviewer.app.recents import RecentFile, Recents
from wzviewer.app.settings import Settings
from wzviewer.app.state import Film, Panels, View, empty_state
from wzviewer.app.theme import DARK, restyle
from wzviewer.app.wishes import Queue
from wzviewer.worker.models.builtin.objects import grammar

SIZES = ((900, 600, 1.0), (1024, 700, 1.0), (1280, 800, 1.0), (1280, 800, 1.375), (2560, 1440, 2.0))
PLATES = (
    *("toolbar", "breadcrumb", "tree", "prompt", "locator", "scale bar", "status", "look", "timeline"),
    *("progress", "refusal", "offers", "materials", "waiting", "variants", "hint", "film"),
    *("keep", "settings", "history", *(f"toast{number}" for number in range(4))),
)
FEW, MANY = 3, 9
EDGE = 1.0  # imgui rounds places and sizes to whole units
SEEN = Settings(hint_seen=True, auto_detail=False)


def busy(count=FEW, **panels):
    """A level in the making, three that wait, and variants of the last one."""
    scene = make_scene(count)
    wishes = Queue(tuple(goal(f"a thing with a long name {k}") for k in range(3)))
    state = replace(making(state_with(scene)), queue=wishes, variants=count - 1, settings=SEEN)
    return replace(with_vocabulary(state, grammar.vocabulary()), panels=Panels(**panels))


def told(state):
    """With three notices, one of them with its details shown."""
    state = state.with_toast("The level could not be made: no memory.", "error", "Traceback " * 90, "a bird")
    state = replace(state, toasts=(replace(state.toasts[-1], is_expanded=True),))
    return state.with_toast("Saved.", "done").with_toast("A notice that is so long that it takes two lines.")


def filmed(state):
    """With a film in the making, and the film's page of the Keep panel."""
    return replace(state, film=Film(Path("a/b.mp4"), 0.0, 0.4), plan=replace(state.plan, tab="film"))


SHOWN = {
    "busy": lambda: busy(),
    "many levels": lambda: busy(MANY),
    "notices": lambda: told(busy(MANY)),
    "statistics": lambda: busy(MANY, statistics=True),
    "statistics, notices": lambda: told(busy(statistics=True)),
    "keep": lambda: told(filmed(busy(keep=True))),
    "keep, statistics": lambda: told(filmed(busy(keep=True, statistics=True))),
    "settings": lambda: told(busy(settings=True)),
    "history": lambda: told(busy(MANY, history=True)),
    "materials": lambda: told(busy(MANY, materials=True)),
    "materials, statistics": lambda: busy(MANY, materials=True, statistics=True),
    "timeline": lambda: told(busy(MANY, timeline=True)),
    "timeline, keep": lambda: filmed(busy(timeline=True, keep=True)),
    "timeline, settings": lambda: busy(timeline=True, settings=True),
    "timeline, statistics": lambda: told(busy(timeline=True, statistics=True)),
    "hint": lambda: replace(told(busy()), settings=Settings()),
    "hint, keep": lambda: replace(told(filmed(busy(keep=True))), settings=Settings()),
    "refused": lambda: told(replace(state_with(make_scene(MANY)), refusal="No such thing. " * 20)),
}
EXPECTED = {  # what each of them is about, so that nothing is held of an empty screen
    "busy": {"tree", "progress", "waiting", "variants", "prompt", "toolbar"},
    "notices": {"tree", "toast0", "toast2"},
    "keep": {"keep", "film", "toast0"},
    "materials": {"materials", "progress"},
    "statistics": {"look", "tree"},
    "timeline": {"timeline"},
    "history": {"history"},
    "settings": {"settings"},
    "refused": {"refusal"},
}


def shown(screen, state, size, *names):
    """Draws some frames as the app does; returns the places of plates, or of those named, in the last one."""
    screen.width, screen.height, screen.scale = size
    restyle(screen.scale, DARK)
    foot = foot_height(state, screen.scale)
    window = Rect(0.0, 0.0, *size[:2])
    layout = replace(arrange(size[0], size[1] - foot, screen.scale), window=window)
    screen.ui = lambda: Ui(layout, screen.fonts, statistics={f"Number {k}": "1" for k in range(9)})
    for _ in range(4):
        screen.frame(state)
    windows = {name: imgui.internal.find_window_by_name(name) for name in names or PLATES}
    there = {name: window for name, window in windows.items() if window is not None and window.was_active}
    return {name: Rect(w.pos.x, w.pos.y, w.size.x, w.size.y) for name, w in there.items()}


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", SHOWN)
def test_no_plates_overlap(screen, name, size):
    places = shown(screen, SHOWN[name](), size)
    assert EXPECTED.get(name, {"prompt"}) <= set(places)
    for (a, one), (b, other) in combinations(places.items(), 2):
        smaller = Rect(one.x + EDGE, one.y + EDGE, one.width - 2 * EDGE, one.height - 2 * EDGE)
        assert not smaller.overlaps(other), (a, one, b, other)
    for a, rect in places.items():
        assert min(rect.x, rect.y) >= -EDGE, (a, rect)
        assert rect.right <= size[0] + EDGE, (a, rect)
        assert rect.bottom <= size[1] + EDGE, (a, rect)


@pytest.mark.parametrize("width", range(640, 1300, 60))
def test_the_breadcrumb_ends_inside_the_window(screen, width):
    scene = make_scene(MANY)
    view = View.at_home(scene[0].camera, width, 480)
    deep = replace(view, camera=scene[MANY - 1].camera.resized(width, 480))
    state = state_with(scene, width, 480).with_view(deep)
    there = shown(screen, state, (width, 480, 1.0), "breadcrumb")
    assert all(rect.right <= width + EDGE for rect in there.values())
    assert there or width < 760  # where it is left out; 700 is the last


@pytest.mark.parametrize("size", [(1280, 800, 1.0), (1280, 720, 1.0), (2560, 1440, 2.0)])
def test_notices_stand_beside_the_start_page(screen, size):
    files = tuple(RecentFile(Path(f"{k}.png"), 0.0, None) for k in range(8))
    state = told(replace(empty_state(*size[:2]), recents=Recents(files)))
    places = shown(screen, state, size, "start", "toast0")
    assert set(places) == {"start", "toast0"}
    assert not places["start"].overlaps(places["toast0"])


@pytest.mark.parametrize("keymap", ["wzviewer", "authors"])
@pytest.mark.parametrize("size", [(900, 600, 1.0), (1280, 800, 1.0), (2560, 1440, 2.0)])
def test_the_help_needs_no_scrolling(screen, size, keymap):
    state = replace(state_with(make_scene(1)), settings=Settings(keymap=keymap), panels=Panels(help=True))
    shown(screen, state, size)
    assert imgui.internal.find_window_by_name("help").scroll_max.y == 0


@pytest.mark.parametrize("size", SIZES)
def test_every_button_of_the_toolbar_is_inside(screen, size):
    shown(screen, state_with(make_scene(2)), size)
    bar = imgui.internal.find_window_by_name("toolbar")
    assert bar.content_size.x + 2 * bar.window_padding.x <= bar.size.x + EDGE
