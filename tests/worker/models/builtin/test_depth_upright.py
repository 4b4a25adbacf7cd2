import numpy as np

from wzviewer.worker.models.builtin.depth.upright import slope_shares, stand_up, unpressed

H, W = 240, 360
HOUSES = ((60, 120, 110, 170), (200, 260, 150, 210))  # left, right, top, foot


def village(share=0.45):
    """Ground whose disparity falls to the horizon at a quarter height; houses that keep a share of it."""
    y = np.arange(H, dtype=np.float32)[:, None]
    ground = np.repeat(np.clip((y - H / 4) / (0.75 * H), 0.02, None), W, 1).astype(np.float32)
    sky = np.repeat(y < H / 4, W, 1)
    labels = np.ones((H, W), np.int32)
    labels[sky] = 0
    hedged, truth = ground.copy(), ground.copy()
    for k, (left, right, top, foot) in enumerate(HOUSES):
        inside = (slice(top, foot), slice(left, right))
        base = ground[foot, left]
        hedged[inside] = base - share * (base - ground[inside])
        truth[inside] = base
        labels[inside] = k + 2
    return hedged, truth, sky, labels


def test_houses_that_lean_halfway_stand_up_and_the_ground_stays():
    hedged, truth, sky, labels = village()
    up = stand_up(hedged, sky, labels)
    for left, right, top, foot in HOUSES:
        inside = (slice(top + 4, foot - 4), slice(left + 4, right - 4))
        before = np.abs(hedged - truth)[inside].mean()
        assert np.abs(up - truth)[inside].mean() < 0.25 * before  # measured: 0.12
    lawn = (labels == 1) & (np.arange(H)[:, None] > 70)
    assert np.abs(up - truth)[lawn].mean() < 0.001  # measured: 0.0002


def test_what_lies_and_what_already_stands_is_left_alone():
    for share in (1.0, 0.0):
        hedged, _, sky, labels = village(share)
        assert np.abs(stand_up(hedged, sky, labels) - hedged).max() < 0.02  # measured: 0.008


def test_a_lake_is_not_raised():
    hedged, _, sky, labels = village(1.0)
    lake = (slice(180, 200), slice(40, 300))
    hedged[lake] = 0.62 - 0.3 * (0.62 - hedged[lake])
    labels[lake] = 9
    assert (
        np.abs(stand_up(hedged, sky, labels) - hedged).max() < 0.01
    )  # measured: 4e-6; it would rise by 0.04


def test_no_ground_no_change():
    wall = np.full((H, W), 0.7, np.float32)
    labels = np.zeros((H, W), np.int32)
    nothing = np.zeros((H, W), bool)
    assert slope_shares(wall, nothing, labels) is None
    assert np.array_equal(stand_up(wall, nothing, labels), wall)
    assert np.array_equal(stand_up(wall, ~nothing, labels), wall)


def test_a_slim_thing_needs_less_of_a_hint_and_a_path_none_at_all():
    for share, stands in ((0.85, True), (1.0, False)):
        hedged, _, sky, labels = village(1.0)
        person = (slice(140, 200), slice(300, 318))
        base = hedged[200, 300]
        truth = np.full((60, 18), base, np.float32)
        hedged[person] = base - share * (base - hedged[person])
        labels[person] = 9
        error = np.abs(stand_up(hedged, sky, labels)[person] - truth)[6:-6, 4:-4].mean()
        before = np.abs(hedged[person] - truth)[6:-6, 4:-4].mean()
        assert error < 0.35 * before if stands else error > 0.9 * before  # measured: 0.14 and 1.0


def test_the_networks_opinion_decides_what_the_slope_leaves_open():
    hedged, truth, sky, labels = village(0.8)
    left, right, top, foot = HOUSES[1]
    inside = (slice(top + 4, foot - 4), slice(left + 4, right - 4))
    before = np.abs(hedged - truth)[inside].mean()
    errors = []
    for opinion in (0.95, 0.05):
        stands = np.full((H, W), 0.05, np.float32)
        stands[top:foot, left:right] = opinion
        errors.append(np.abs(stand_up(hedged, sky, labels, stands) - truth)[inside].mean() / before)
    assert errors[0] < 0.3  # measured: 0.10
    assert errors[1] > 0.8  # measured: 1.0


def checked(pressed=4, house_pressed=1):
    """A floor whose pattern is pressed flat by the view, and walls whose pattern is not."""
    y, x = np.mgrid[:H, :W]
    labels = village()[3]
    squeeze = np.where(labels >= 2, house_pressed, pressed)
    light = np.where((x // 8 + y * squeeze // 8) % 2, 170, 90).astype(np.uint8)
    return np.repeat(light[..., None], 3, 2), labels


def test_texture_that_is_not_pressed_flat_stands():
    image, labels = checked()
    evidence = unpressed(image, labels)
    assert evidence[labels >= 2].min() > 0.12  # measured: 0.149
    assert evidence[labels == 1].max() < 0.01  # measured: 0
    lawn, _ = checked(pressed=1)  # blades that stand: then nothing is told by it
    assert unpressed(lawn, labels).max() < 0.05  # measured: 0


def test_a_wall_that_the_slope_takes_for_ground_stands_by_its_texture():
    hedged, truth, sky, labels = village(0.85)
    image, _ = checked()
    left, right, top, foot = HOUSES[1]
    inside = (slice(top + 4, foot - 4), slice(left + 4, right - 4))
    before = np.abs(hedged - truth)[inside].mean()
    assert np.abs(stand_up(hedged, sky, labels, None, image) - truth)[inside].mean() < 0.3 * before  # 0.10
    assert np.abs(stand_up(hedged, sky, labels) - truth)[inside].mean() > 0.9 * before  # measured: 1.0
