"""The compiled interpreter against closed forms."""

import numpy as np
import pytest
from numba import njit

from wzviewer.worker.models.builtin.objects import bodies, patterns, primitives
from wzviewer.worker.models.builtin.objects.nouns import BUILDERS
from wzviewer.worker.models.builtin.objects.pose import Pose
from wzviewer.worker.models.builtin.objects.rays import Scene
from wzviewer.worker.models.builtin.objects.render import render_mask

distance = njit(lambda P, i, x, y, z, T: primitives.primitive_distance(P, i, x, y, z, T, primitives.FAR))
field = njit(lambda P, ids, x, y, z, T: primitives.field(P, ids, 0, ids.shape[0], x, y, z, T, -1)[:2])
whole_field = njit(lambda P, ids, x, y, z, T: primitives.field(P, ids, 0, ids.shape[0], x, y, z, T, -1))
FACING = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])  # object z towards the viewer
CLOSE = Pose(FACING, 300.0, (48.0, 48.0, 0.0))


def pen():
    return bodies.Pen(np.random.default_rng(0))


def body_of(draw):
    p = pen()
    draw(p, p.material(patterns.PLAIN, (0.5, 0.5, 0.5)))
    return p.body()


def measure(body, points):
    return np.array([distance(body.primitives, 0, *map(float, p), body.outlines) for p in points])


@pytest.fixture
def points():
    return np.random.default_rng(3).uniform(-1.2, 1.2, (200, 3))


def test_sphere_distance_is_exact(points):
    body = body_of(lambda p, m: p.ellipsoid((0.1, -0.2, 0.3), (0.4, 0.4, 0.4), m))
    want = np.linalg.norm(points - [0.1, -0.2, 0.3], axis=1) - 0.4
    assert np.abs(measure(body, points) - want).max() < 1e-12


def test_ellipsoid_distance_is_exact_to_first_order_at_its_surface():
    radii = np.array([0.5, 0.3, 0.2])
    d = np.random.default_rng(5).normal(size=(200, 3))
    on = d / np.linalg.norm(d, axis=1, keepdims=True) * radii
    normal = on / radii**2
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    body = body_of(lambda p, m: p.ellipsoid((0, 0, 0), tuple(radii), m))
    assert np.abs(measure(body, on)).max() < 1e-12
    step = 0.004
    # Measured: .0001, the second order of the step.
    assert np.abs(measure(body, on + step * normal) - step).max() < 3e-4


def test_tubes_cones_boxes_and_cylinders_against_closed_forms(points):
    straight = ((-0.5, 0.0, 0.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
    x, y, z = points.T
    segment = np.sqrt(np.maximum(np.abs(x) - 0.5, 0) ** 2 + y**2 + z**2) - 0.1
    tube = body_of(lambda p, m: p.tube(straight, 0.1, 0.1, m))
    cone = body_of(lambda p, m: p.cone((-0.5, 0, 0), (0.5, 0, 0), 0.1, 0.1, m))
    assert np.abs(measure(tube, points) - segment).max() < 1e-9
    assert np.abs(measure(cone, points) - segment).max() < 1e-12
    q = np.abs(points) - [0.3, 0.2, 0.1]
    box = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(1), 0)
    assert (
        np.abs(measure(body_of(lambda p, m: p.box((0, 0, 0), (0.3, 0.2, 0.1), 0.0, m)), points) - box).max()
        < 1e-12
    )
    q = np.stack([np.hypot(x, y) - 0.3, np.abs(z) - 0.2], 1)
    cylinder = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(1), 0)
    got = measure(body_of(lambda p, m: p.cylinder((0, 0, 0), 0.3, 0.2, 0.0, m)), points)
    assert np.abs(got - cylinder).max() < 1e-12


def test_field_is_the_plain_minimum_over_groups(points):
    """Skipping by bounding spheres changes nothing: the twin evaluates everything."""
    body = BUILDERS["lego brick"](np.random.default_rng(1), bodies.Tint())
    P = body.primitives.copy()
    P[:, 2] = 0.0  # without blends the field is a minimum
    ids = np.arange(len(P))
    for p in points[:80] * 0.6:
        want = min(distance(P, i, *map(float, p), body.outlines) for i in ids)
        got, who = field(P, ids, *map(float, p), body.outlines)
        if want < 0.05:
            assert got == pytest.approx(want, abs=1e-9)
            assert distance(P, who, *map(float, p), body.outlines) == pytest.approx(want, abs=1e-9)
        else:
            assert got <= want + 1e-9  # far away a bound is enough


def test_what_is_said_of_the_other_groups_is_never_too_far(points):
    """A ray may go on that far without meeting another group."""
    body = BUILDERS["bee"](np.random.default_rng(1), bodies.Tint())
    P, ids = body.primitives, np.arange(len(body.primitives))
    for p in points[:40] * 0.5:
        _, who, others = whole_field(P, ids, *map(float, p), body.outlines)
        rest = ids[P[:, 29] != P[who, 29]]
        # Of what melts together the nearest part; `field` itself may say less, from bounding balls.
        assert others <= min(distance(P, i, *map(float, p), body.outlines) for i in rest) + 1e-9


@njit
def short_steps(P, ids, T, frame, rays, depth):
    """Marches the plainest way: every primitive, a third of the distance at a time."""
    for r in range(rays.shape[0]):
        t = -2.0
        while t < 2.0:
            p = frame[0] + rays[r, 0] * frame[1] + rays[r, 1] * frame[2] + t * frame[3]
            gap = field(P, ids, p[0], p[1], p[2], T)[0]
            if gap < 0.25 / 300:
                depth[r] = t
                break
            t += max(0.3 * gap, 0.2 / 300)


@pytest.mark.parametrize("name", ["bee", "flower", "starfish", "lego brick", "lizard"])
def test_common_starts_and_long_steps_miss_nothing(name):
    scene = Scene(BUILDERS[name](np.random.default_rng(2), bodies.Tint()), CLOSE, 96, 96)
    rays = scene.pixels()[::9] + 0.5
    want = np.full(len(rays), np.nan)
    P = scene.primitives
    short_steps(P, np.arange(len(P)), scene.body.outlines, scene.frame, rays, want)
    got = scene.march(rays)[0][:, 0]
    wrong = ~(np.abs(got - want) * 300 < 1.0) & ~(np.isnan(got) & np.isnan(want))
    assert np.isfinite(want).any()
    assert wrong.mean() < 0.006  # measured 0; .003 of the bee, single pixels beside its hairs


def test_marched_sphere_has_the_area_and_relief_of_a_sphere():
    body = body_of(lambda p, m: p.ellipsoid((0, 0, 0), (0.5, 0.5, 0.5), m))
    pose = Pose(FACING, 60.0, (50.0, 40.0, 7.0))
    mask, relief = render_mask(Scene(body, pose, 100, 80))
    assert mask.sum() == pytest.approx(np.pi * 30**2, rel=0.02)  # measured .6 %
    y, x = np.nonzero(mask)
    assert x.mean() + 0.5 == pytest.approx(50, abs=0.1)
    assert y.mean() + 0.5 == pytest.approx(40, abs=0.1)
    inner = np.hypot(x + 0.5 - 50, y + 0.5 - 40) < 26
    x, y = x[inner], y[inner]
    want = 7 - np.sqrt(900 - (x + 0.5 - 50) ** 2 - (y + 0.5 - 40) ** 2)
    assert np.abs(relief[y, x] - want).max() < 0.6  # measured .45: a hit is a quarter pixel off


def test_slanted_rays_shear_the_picture_and_nothing_else():
    """A point at relief d is seen d * slope further along, as in an off-axis crop."""
    body = body_of(lambda p, m: p.ellipsoid((0, 0, 1.0), (0.2, 0.2, 0.2), m))
    straight = render_mask(Scene(body, Pose(FACING, 40.0, (60.0, 40.0, 0.0)), 120, 80))[0]
    slanted = render_mask(Scene(body, Pose(FACING, 40.0, (60.0, 40.0, 0.0), (0.5, 0.0)), 120, 80))[0]
    # The ball's centre lies 40 px in front of the origin: at relief -40 it moves by +20 px.
    assert np.nonzero(slanted)[1].mean() - np.nonzero(straight)[1].mean() == pytest.approx(20, abs=0.3)


def test_hairs_thinner_than_a_pixel_become_coverage():
    body = body_of(lambda p, m: p.tube(((-0.5, 0, 0), (0, 0, 0), (0.5, 0, 0)), 0.001, 0.001, m))
    scene = Scene(body, Pose(FACING, 40.0, (30.0, 20.0, 0.0)), 60, 40)
    # .08 px wide, drawn 1 px wide: it covers that share.
    assert scene.opacity[0] == pytest.approx(0.08)


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_every_body_stands_on_its_ground(name):
    """Nothing is below the support, and the lowest point is on it; bounding spheres hold the surface."""
    body = BUILDERS[name](np.random.default_rng(2), bodies.Tint())
    below = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])  # seen from under the ground
    mask, relief = render_mask(Scene(body, Pose(below, 60.0, (60.0, 60.0, 0.0)), 120, 120))
    lowest = np.nanmin(relief) / 60
    assert mask.any()
    assert -0.025 < lowest < 0.0  # body lengths, sunk in a little; measured -.0165 to -.003


tight = njit(lambda P, i, x, y, z: primitives.tighter(P, i, x, y, z, -primitives.FAR))
near = njit(lambda P, ids, x, y, z, T, far: primitives.gap(P, ids, 0, ids.shape[0], x, y, z, T, -1, far))


def test_a_chord_is_never_farther_than_its_tube(points):
    body = BUILDERS["bee"](np.random.default_rng(1), bodies.Tint())
    P, T = body.primitives, body.outlines
    for i in np.flatnonzero(P[:, 0] == primitives.BEZIER)[::9]:
        for p in P[i, 30:33] + points * P[i, 33]:
            assert tight(P, i, *p) <= distance(P, i, *p, T) - P[i, 2] + 1e-9


def test_a_box_holds_its_loft(points):
    """Beyond its surface a loft's distance is a bound itself, so the surface is what counts."""
    body = BUILDERS["starfish"](np.random.default_rng(1), bodies.Tint())
    P, T, inside = body.primitives, body.outlines, 0
    for i in np.flatnonzero(P[:, 0] == primitives.LOFT):
        for p in P[i, 30:33] + points * 0.3 * P[i, 33]:
            if distance(P, i, *p, T) < 0:
                inside += 1
                assert tight(P, i, *p) <= -P[i, 2] + 1e-9
    assert inside > 50


@pytest.mark.parametrize("name", ["bee", "starfish"])
def test_a_gap_is_the_field_up_to_its_limit(name, points):
    body = BUILDERS[name](np.random.default_rng(1), bodies.Tint())
    P, T, ids = body.primitives, body.outlines, np.arange(len(body.primitives))
    for p in points:
        want = field(P, ids, *p, T)[0]
        assert near(P, ids, *p, T, primitives.FAR) == pytest.approx(want, abs=1e-12)
        # What melts into the next thing is cut by up to a sixth of the width it melts over, .08.
        assert near(P, ids, *p, T, 0.1) == pytest.approx(min(want, 0.1), abs=0.014)
