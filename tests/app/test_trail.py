"""Back and forward through places, and the crumbs."""

from dataclasses import replace

from tests.app.fakes import fake_services, make_scene, state_with
from wzviewer.app import commands as cmd
from wzviewer.app.apply import apply
from wzviewer.app.panels.breadcrumb import fitting, name_of
from wzviewer.app.trail import can_go_back, can_go_forward, note_place
from wzviewer.app.viewing import advance
from wzviewer.core.marks import Mark


def rested(state):
    """Lets a flight end, and the view rest there."""
    while state.view.is_moving:
        state = advance(replace(state, now_s=state.now_s + 0.1), 0.1)
    view = replace(state.view, focused=state.view.camera)
    return note_place(replace(state, view=view, now_s=state.now_s + 1.0))


def test_back_and_forward_through_levels():
    services = fake_services()
    state = rested(state_with(make_scene(3)))
    cameras = [state.view.camera]
    for index in (1, 2):
        state = rested(apply(services, state, [cmd.GoToLevel(index)]))
        cameras.append(state.view.camera)
    for camera in (cameras[1], cameras[0]):
        assert can_go_back(state)
        state = rested(apply(services, state, [cmd.GoBack()]))
        assert state.view.camera.key == camera.key
    assert not can_go_back(state)
    state = rested(apply(services, state, [cmd.GoForward()]))
    assert state.view.camera.key == cameras[1].key
    assert can_go_forward(state)


def test_another_way_from_the_middle_forgets_what_was_ahead():
    services = fake_services()
    state = rested(state_with(make_scene(3)))
    state = rested(apply(services, state, [cmd.GoToLevel(2)]))
    state = rested(apply(services, state, [cmd.GoBack()]))
    state = rested(apply(services, state, [cmd.GoToLevel(1)]))
    assert not can_go_forward(state)
    assert len(state.trail.places) == 2


def test_a_place_a_little_displaced_is_the_same_place():
    state = rested(state_with(make_scene(1)))
    view = state.view
    for factor, count in ((1.1, 1), (1.6, 2)):
        camera = view.camera.zoomed(320.0, 210.0, factor)
        moved = rested(state.with_view(replace(view, camera=camera)))
        assert len(moved.trail.places) == count


def test_back_from_the_way_goes_to_where_it_began():
    services = fake_services()
    state = rested(state_with(make_scene(2)))
    home = state.view.camera
    state = apply(services, state, [cmd.GoToLevel(1), cmd.GoBack()])
    assert rested(state).view.camera.key == home.key


def test_a_window_of_another_size_keeps_the_places():
    services = fake_services()
    state = rested(state_with(make_scene(2)))
    state = rested(apply(services, state, [cmd.GoToLevel(1)]))
    state = apply(services, state, [cmd.Resize(900, 600), cmd.GoBack()])
    assert state.view.flight.end.width == 900


class Points:
    @staticmethod
    def pt(points):
        return points


def test_as_many_crumbs_as_there_is_room_for():
    path, widths = [0, 1, 2, 3], [100.0] * 4
    assert fitting(path, widths, 1000.0, Points)[0] == path
    assert fitting(path, widths, 350.0, Points)[0] == [0, 2, 3]
    assert fitting(path, widths, 250.0, Points)[0] == [0, 3]
    assert fitting(path, widths, 150.0, Points)[0] == [3]
    assert fitting([0], widths[:1], 50.0, Points) == ([0], 100.0)
    width = fitting(path, widths, 1000.0, Points)[1]
    assert width == 4 * 100.0 + 3 * 15.0


def test_crumbs_are_called_by_their_thing():
    assert [name_of(make_scene(2), i) for i in range(2)] == ["photo", "thing 1"]
    scene = make_scene(2)
    scene.set_mark(1, Mark(name="a Blue morpho"))
    assert name_of(scene, 1) == "blue morpho"
