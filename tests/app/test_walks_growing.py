"""Walks through growing a scene: a frame, the queue, variants, names, a picture that is put in."""

import numpy as np

from tests.app.fakes import checker
from tests.app.test_walks import CTRL, SHIFT, K, near, photo, walk  # noqa: F401 - fixtures
from wzviewer.app.naming import name_in
from wzviewer.app.variants import group_of
from wzviewer.core.files import load_scene
from wzviewer.core.photos import encode_png


def test_a_frame_a_queue_and_a_picture_that_is_put_in(walk, photo, tmp_path):  # noqa: F811 - fixtures
    walk.drop(photo)
    walk.wait_until(lambda state: state.job is None and state.scene.is_committed(0))
    walk.press(K.x)  # auto detail off
    walk.app.services.client.is_held = True
    for at, words in ((300.0, "a bird"), (440.0, "a key")):
        walk.press(K.r)
        walk.drag((at, 200.0), (at + 80.0, 250.0))
        walk.wait()
        walk.type(words)
        walk.shoot()
        walk.press(K.enter)
    assert walk.state.job.prompt == "a bird"
    assert [goal.prompt for goal in walk.state.queue.goals] == ["a key"]
    robin = tmp_path / "robin.png"
    robin.write_bytes(encode_png(np.dstack([checker(60, 60), np.full((60, 60), 255, np.uint8)])))
    walk.drop(robin)
    walk.shoot()
    walk.click("Put it in")
    assert [goal.prompt for goal in walk.state.queue.goals] == ["a key", "robin"]
    walk.click("a key")  # its chip takes it out
    assert [goal.prompt for goal in walk.state.queue.goals] == ["robin"]
    walk.app.services.client.is_held = False
    walk.wait_until(lambda state: state.job is None and not state.queue.goals and state.goal is None)
    assert [level.prompt for level in walk.state.scene] == ["", "a bird", "robin"]
    (sent,) = walk.app.services.client.cutouts
    assert sent.shape == (60, 60, 4)


def test_variants_names_and_the_way_back(walk, photo, tmp_path):  # noqa: F811 - fixtures
    near(walk, photo)
    walk.press(K.slash)
    walk.type("a bird")
    walk.press(K.enter)
    walk.wait_until(lambda state: state.num_finished == 2)
    walk.press(K.n)
    walk.wait_until(lambda state: state.num_finished == 3)
    assert group_of(walk.state.scene, 1) == (1, 2)
    assert walk.state.scene.visible() == [0, 2]
    walk.shoot()
    walk.click("variant1")
    assert walk.state.scene.visible() == [0, 1]
    walk.click("Keep")
    assert walk.state.variants is None

    walk.press(K.f2)
    walk.wait()
    walk.type("robin")
    walk.press(K.enter)
    assert name_in(walk.state.scene, 1) == "robin"
    walk.press(K.delete, CTRL)
    assert walk.state.scene.visible() == [0]
    walk.click("Undo")  # of the notice
    assert walk.state.scene.visible() == [0, 1]
    walk.press(K.u)
    walk.shoot()
    walk.click("step1")
    assert walk.state.scene.visible() == [0, 1]
    assert name_in(walk.state.scene, 1) == "a bird"
    walk.click("step0")
    assert walk.state.scene.visible() == [0]
    walk.press(K.escape)
    for _ in range(4):
        walk.press(K.z, CTRL, SHIFT)
    assert name_in(walk.state.scene, 1) == "robin"

    walk.app.state.scene.save(tmp_path / "s.wz")
    again = load_scene(tmp_path / "s.wz")
    assert (again.visible(), name_in(again, 1)) == ([0, 1], "robin")
    assert group_of(again, 1) == (1, 2)
