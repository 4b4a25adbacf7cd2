"""Where one is in the photo, and flights to a place in it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.layout import arrange
from wzviewer.app.locating import location
from wzviewer.app.panels.status import photo_width
from wzviewer.app.places import shows_photo
from wzviewer.app.viewing import advance
from wzviewer.core.navigation import orbited
from wzviewer.core.scene import Scene


def looking(state, x, y, factor):
    root = state.scene[0].camera
    camera = root.resized(state.view.camera.width, state.view.camera.height)
    near = root.zoomed_to_region(x, y, factor).resized(camera.width, camera.height)
    focus = near.unproject(near.width / 2, near.height / 2, 1.0)
    return replace(state, view=replace(state.view, camera=near, focus=focus, focused=near))


def test_the_frame_is_the_part_of_the_photo_that_is_seen():
    state = state_with(make_scene(1), 680, 450)  # the photo's aspect
    here = location(looking(state, 0.3, 0.6, 8.0))
    assert here.centre == pytest.approx((0.3, 0.6))
    assert (here.right - here.left, here.bottom - here.top) == pytest.approx((1 / 8, 1 / 8))
    deep = location(looking(state, 0.3, 0.6, 8.0**9))
    assert deep.centre == pytest.approx((0.3, 0.6), abs=1e-9)


def test_at_home_there_is_none():
    assert location(state_with(make_scene(1))) is None


def test_a_turned_view_has_a_place_too():
    state = looking(state_with(make_scene(1), 680, 450), 0.5, 0.5, 4.0)
    turned = orbited(state.view.camera, state.view.focus, 0.3, 0.1)
    here = location(replace(state, view=replace(state.view, camera=turned)))
    assert here.centre == pytest.approx((0.5, 0.5), abs=0.05)


def test_a_click_flies_there_and_no_closer_than_there_is_something():
    services = fake_services()
    state = looking(state_with(make_scene(1), 680, 450), 0.5, 0.5, 512.0)
    state = apply(services, state, [cmd.GoToPhoto(0.2, 0.8)])
    while state.view.flight is not None:
        state = advance(state, 0.1)
    here = location(state)
    assert here.centre == pytest.approx((0.2, 0.8), abs=0.01)
    assert here.right - here.left == pytest.approx(1 / 8, rel=0.1)


def test_the_inset_is_there_and_answers_a_click(screen):
    scene = make_scene(1)
    state = looking(state_with(scene, 1280, 800), 0.5, 0.5, 64.0)
    rect = arrange(1280, 800, 1.0).locator
    (go,) = screen.click(state, rect.right - 40, rect.bottom - 30)
    assert isinstance(go, cmd.GoToPhoto)
    assert np.allclose((go.x, go.y), (0.79, 0.75), atol=0.05)  # measured 0.797, 0.776
    hidden = apply(fake_services(), state, [cmd.Toggle("locator")])
    assert not any(
        isinstance(c, cmd.GoToPhoto) for c in screen.click(hidden, rect.right - 40, rect.bottom - 30)
    )


def test_the_photo_stays_sharp_while_its_scene_is_being_made():
    scene = Scene()
    level = make_scene(1)[0]
    state = replace(state_with(make_scene(1)), photo=level.image)
    assert not shows_photo(state)  # finished
    scene.append(level)
    state = replace(state, scene=scene)
    assert shows_photo(state)
    zoomed = replace(state, view=replace(state.view, camera=state.view.camera.zoomed(30.0, 20.0, 3.0)))
    assert shows_photo(zoomed)
    turned = orbited(state.view.camera, state.view.focus, 0.1, 0.0)
    assert not shows_photo(replace(state, view=replace(state.view, camera=turned)))


@pytest.mark.parametrize("depth", [0.5, 1.0, 3.0])
def test_the_scale_bar_is_the_share_of_the_photo_that_it_covers_on_the_screen(depth):
    state = state_with(make_scene(1))
    root = state.scene[0].camera
    focus = root.unproject(root.width / 2, root.height / 2, depth)
    width = photo_width(replace(state, view=replace(state.view, focus=focus)))
    assert width / root.pixel_scale(depth) == pytest.approx(root.width)
