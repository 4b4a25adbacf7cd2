import pytest

from tests.gl.surfaces import hill_scene
from wzviewer.app.drawing import BACKGROUND, DIMMED, MOVING_UPLOAD_BYTES, UPLOAD_BYTES, SceneDrawing
from wzviewer.app.pacing import SPACING_PX
from wzviewer.core.scene import Scene

pytestmark = pytest.mark.gl


@pytest.fixture
def drawing(gl_context):
    made = SceneDrawing(gl_context)
    yield made
    made.close()


def spacings(drawing, monkeypatch):
    """Spacing of merged surfels of every picture that is really drawn."""
    found, draw = [], drawing._renderer.render_soon

    def spy(camera, settings):
        found.append(settings.spacing_px)
        return draw(camera, settings)

    monkeypatch.setattr(drawing._renderer, "render_soon", spy)
    return found


def test_surfels_are_merged_only_where_time_is_short(drawing, monkeypatch):
    scene = hill_scene(num_levels=1)
    drawing.sync(scene)
    found = spacings(drawing, monkeypatch)
    for fraction, is_moving in ((1.0, False), (1.0, True), (0.5, True)):
        drawing.draw(scene[0].camera, fraction, is_moving)
    assert found == [0.0, 0.0, SPACING_PX]


def test_a_picture_at_rest_is_drawn_once(drawing, monkeypatch):
    scene = hill_scene(num_levels=1)
    drawing.sync(scene)
    drawing._renderer.is_ready(None)
    drawing.sync(scene)
    found = spacings(drawing, monkeypatch)
    first = drawing.draw(scene[0].camera)
    assert drawing.draw(scene[0].camera) is first
    assert drawing.draw(scene[0].camera.zoomed(3.0, 4.0, 1.01)) is not first
    assert len(found) == 2


def test_the_card_is_timed_in_motion(drawing):
    scene = hill_scene(num_levels=1)
    drawing.sync(scene)
    for k in range(4):
        assert drawing.gpu_s == 0.0 if k < 2 else drawing.gpu_s > 0.0
        drawing.draw(scene[0].camera.zoomed(3.0, 4.0, 1.0 + 0.01 * k), 0.5, True)


def test_in_motion_levels_are_weighted_as_at_rest(drawing, monkeypatch):
    scene = hill_scene(num_levels=1)
    drawing.sync(scene)
    found, draw = [], drawing._renderer.render_soon

    def spy(camera, settings):
        found.append((camera.width, settings.finer))
        return draw(camera, settings)

    monkeypatch.setattr(drawing._renderer, "render_soon", spy)
    for fraction, is_moving in ((1.0, False), (0.5, True), (0.25, True)):
        drawing.draw(scene[0].camera, fraction, is_moving)
    assert [width * finer for width, finer in found] == [scene[0].camera.width] * 3
    assert found[0][1] == 1.0


def test_a_level_arrives_in_smaller_pieces_while_the_camera_moves(drawing, monkeypatch):
    scene = hill_scene(num_levels=1)
    drawing.sync(scene)
    budgets, sync = [], drawing._renderer.sync

    def spy(scene, budget_bytes, merged):
        budgets.append(budget_bytes)
        return sync(scene, budget_bytes, merged)

    monkeypatch.setattr(drawing._renderer, "sync", spy)
    for is_moving in (False, True):
        drawing.draw(scene[0].camera, 0.5, is_moving)
        drawing.sync(scene)
    assert budgets == [UPLOAD_BYTES, MOVING_UPLOAD_BYTES]


def test_gaps_of_a_photo_in_the_making_have_its_colour(drawing):
    made = hill_scene(num_levels=1)
    scene = Scene()
    scene.append(made[0])
    drawing.sync(scene)
    drawing.draw(scene[0].camera)
    mean = DIMMED * scene[0].image[::8, ::8].mean((0, 1)) / 255.0
    assert drawing.draw(scene[0].camera).settings.background[:3] == pytest.approx(tuple(mean), abs=1e-6)
    scene.commit(0)
    drawing.sync(scene)
    assert drawing.draw(scene[0].camera).settings.background == BACKGROUND
