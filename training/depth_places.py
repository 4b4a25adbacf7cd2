"""Places full of things that stand: villages, halls, gardens, and flowers against the sky."""

import numpy as np
from depth_kinds import _float, _hills, _house, _tree
from depth_raytrace import BLOTCHES, BRICKS, CHECKER, PLAIN, PLANKS, ROAD, STRIPES, WINDOWS
from depth_scenes import EARTHS, FLOWERS, GREENS, PAINTS, STONES, WATERS, Scene
from depth_solids import BOX, CONE, CYLINDER, ELLIPSOID, GABLE, PLANE, PYRAMID, ROOM

WHITES = [(0.97, 0.97, 0.95), (0.9, 0.9, 0.92), (0.98, 0.95, 0.85)]


def _cottage(scene: Scene, x: float, z: float, wide: float, tall: float, yaw: float) -> None:
    """Walls under a gabled, hipped or round roof, maybe with a chimney."""
    pattern = int(scene.random.choice([WINDOWS, BRICKS, PLANKS, PLAIN, BLOTCHES]))
    wall = scene.material(
        STONES + EARTHS + PAINTS, pattern, scene.uniform(1.0, 2.5) if pattern == WINDOWS else 0.4
    )
    deep, roof = wide * scene.uniform(0.7, 1.6), scene.material(EARTHS + STONES + PAINTS[:1], PLAIN, 0.3)
    rise = wide * scene.uniform(0.2, 0.7)
    if scene.maybe(0.15):
        scene.add(CYLINDER, (x, tall / 2, z), (wide, tall / 2, wide), wall)
        kind = CONE if scene.maybe(0.6) else ELLIPSOID
        scene.add(kind, (x, tall + (rise if kind == CONE else 0), z), (1.15 * wide, rise, 1.15 * wide), roof)
        return
    scene.add(BOX, (x, tall / 2, z), (wide, tall / 2, deep), wall, yaw)
    kind = GABLE if scene.maybe(0.7) else PYRAMID
    scene.add(kind, (x, tall + rise, z), (1.15 * wide, rise, 1.12 * deep), roof, yaw)
    if scene.maybe(0.3):
        scene.add(
            BOX, (x + 0.4 * wide, tall + 1.5 * rise, z), (0.12 * wide, 0.6 * rise, 0.12 * wide), wall, yaw
        )


def _walls(scene: Scene, near: float, far: float, count: int) -> None:
    """Low walls, fences and hedges."""
    for _ in range(count):
        x, z = scene.spot(near, far)
        long, yaw = scene.log_uniform(1, 10), scene.uniform(0, 3.1)
        tall = scene.uniform(0.4, 1.6)
        hedge = scene.maybe(0.4)
        material = scene.material(GREENS if hedge else STONES + EARTHS, PLAIN if hedge else BRICKS, 0.3)
        porous = 0.3 if hedge else 0.0
        scene.add(BOX, (x, tall / 2, z), (long, tall / 2, scene.uniform(0.1, 0.4)), material, yaw, porous, 5)


def _crowd(scene: Scene, near: float, far: float, count: int) -> None:
    """People, animals, shrubs and posts on the ground."""
    shapes = ["robed", "person", "robed", "animal", "shrub", "shrub", "pole"]
    sizes = {"animal": 1.2, "pole": 4.0, "shrub": 2.0}
    for _ in range(count):
        shape = str(scene.random.choice(shapes))
        palette = GREENS if shape == "shrub" else PAINTS + STONES + EARTHS
        tall = sizes.get(shape, 1.7) * scene.uniform(0.7, 1.3)
        scene.stand(shape, *scene.spot(near, far), tall, palette)


def _hang(scene: Scene) -> None:
    """A near branch that comes in from above or from a side."""
    u = scene.uniform(0, scene.width)
    v = 0.0 if scene.maybe(0.7) else scene.uniform(0, 0.6) * scene.height
    if v > 0:
        u = 0.0 if scene.maybe(0.5) else float(scene.width)
    disparity = 1 / scene.log_uniform(1.2, 8)
    _float(scene, "branch", u, v, scene.uniform(0.2, 0.6) * scene.height, disparity, GREENS)


def village_scene(scene: Scene) -> None:
    """Many cottages with walls, people and trees, seen from a little above."""
    height = scene.log_uniform(1.6, 16)
    scene.eye = (0, height, 0)
    scene.pitch_deg = float(np.clip(np.degrees(np.arctan(height / 30)) + scene.random.normal(0, 6), -6, 32))
    pattern = int(scene.random.choice([PLAIN, BLOTCHES, ROAD, BRICKS]))
    scene.ground(EARTHS + GREENS + STONES, pattern, scene.log_uniform(0.4, 4))
    near, yaw = max(1.6 * height, 7), scene.uniform(0, 3.1)
    for _ in range(int(scene.random.integers(4, 26))):
        turn = yaw + float(scene.random.choice([0, np.pi / 2])) + scene.random.normal() * 0.15
        _cottage(scene, *scene.spot(near, 110), scene.uniform(1.8, 5), scene.uniform(2, 5), turn)
    for _ in range(int(scene.random.integers(0, 8))):
        _tree(scene, *scene.spot(near, 120), scene.uniform(3, 11))
    _walls(scene, 0.8 * near, 40, int(scene.random.integers(0, 6)))
    _crowd(scene, 0.6 * near, 45, int(scene.random.integers(0, 26)))
    for _ in range(int(scene.random.integers(0, 4))):
        x, z = scene.spot(60, 160)
        tall = scene.uniform(8, 25)
        if scene.maybe(0.5):
            _house(scene, x, z, scene.uniform(2, 6), tall, scene.uniform(0, 3))
        else:
            scene.add(CONE, (x, tall, z), (0.3 * tall, tall, 0.3 * tall), scene.material(STONES + EARTHS))
    if scene.maybe(0.3):
        _hills(scene, 300, scene.uniform(15, 90), scene.maybe(0.5), 80)
    if scene.maybe(0.25):
        _hang(scene)
    scene.haze = scene.log_uniform(60, 600) if scene.maybe(0.6) else 0


def hall_scene(scene: Scene) -> None:
    """A large room with columns, stairs, balustrades, doors and hanging lamps."""
    half = (scene.uniform(3, 10), scene.uniform(1.8, 4), scene.uniform(4, 12))
    yaw = scene.uniform(-0.5, 0.5)
    wall = scene.material(
        STONES[2:4] + PAINTS[3:] + EARTHS[2:4], int(scene.random.choice([PLAIN, PLAIN, BRICKS])), 0.5
    )
    scene.material(
        EARTHS + STONES, int(scene.random.choice([PLANKS, CHECKER, PLAIN])), scene.uniform(0.2, 0.8)
    )
    scene.material(STONES[2:4] + PAINTS[3:4], PLAIN, 1, 0.1)
    scene.add(ROOM, (0, half[1], 0), half, wall, yaw)
    scene.eye = (
        scene.uniform(-0.4, 0.4) * half[0],
        scene.uniform(1.2, 1.1 * half[1]),
        -scene.uniform(0.5, 0.9) * half[2],
    )
    scene.pitch_deg, scene.sky, scene.backdrop = float(scene.random.normal(5, 8)), False, 0.05
    scene.point_light = (scene.uniform(-1, 1), 2 * half[1] - 0.4, scene.uniform(-2, 2))
    c, s = np.cos(yaw), np.sin(yaw)

    def put(kind: int, x: float, y: float, z: float, size: tuple[float, float, float], material: int) -> None:
        at = (c * x + s * z, y, -s * x + c * z)
        if np.hypot(at[0] - scene.eye[0], at[2] - scene.eye[2]) > size[0] + 0.7:
            scene.add(kind, at, size, material, yaw)

    stone, wood = scene.material(STONES[2:4] + PAINTS[3:4]), scene.material(EARTHS + STONES + PAINTS)
    for row in range(int(scene.random.integers(0, 3))):
        x0, radius, gap = (
            scene.uniform(-0.8, 0.8) * half[0],
            scene.uniform(0.12, 0.4),
            scene.uniform(1.5, 3.5),
        )
        for k in range(int(scene.random.integers(2, 7))):
            at = (x0, -half[2] + gap * (k + 1)) if row else (-0.8 * half[0] + gap * k, x0 / half[0] * half[2])
            if abs(at[0]) < half[0] and abs(at[1]) < half[2]:
                put(CYLINDER, at[0], half[1], at[1], (radius, half[1], radius), stone)
    if scene.maybe(0.6):  # a flight of stairs with its rail
        x0, z0, wide = (
            scene.uniform(-0.7, 0.5) * half[0],
            scene.uniform(-0.2, 0.6) * half[2],
            scene.uniform(0.6, 2),
        )
        tread, rise = scene.uniform(0.25, 0.4), scene.uniform(0.14, 0.22)
        for k in range(int(scene.random.integers(4, 14))):
            put(BOX, x0 + k * tread, rise * (k + 1) / 2, z0, (tread / 2, rise * (k + 1) / 2, wide), stone)
            put(CYLINDER, x0 + k * tread, rise * (k + 1) + 0.45, z0 - wide, (0.03, 0.45, 0.03), wood)
    if scene.maybe(0.6):  # a balustrade
        z0, x0 = scene.uniform(-0.5, 0.8) * half[2], scene.uniform(-0.8, 0) * half[0]
        count, base = int(scene.random.integers(6, 24)), scene.uniform(0, 0.8)
        for k in range(count):
            put(CYLINDER, x0 + 0.25 * k, base + 0.45, z0, (0.035, 0.45, 0.035), wood)
        put(BOX, x0 + 0.125 * count, base + 0.93, z0, (0.13 * count, 0.04, 0.07), wood)
        put(BOX, x0 + 0.125 * count, base / 2, z0, (0.13 * count, base / 2 + 0.02, 0.1), stone)
    for _ in range(int(scene.random.integers(2, 9))):  # furniture
        size = (scene.uniform(0.2, 1), scene.uniform(0.2, 0.6), scene.uniform(0.2, 0.6))
        x, z = scene.uniform(-0.9, 0.9) * half[0], scene.uniform(-0.7, 0.95) * half[2]
        material = scene.material(EARTHS + STONES + PAINTS, int(scene.random.choice([PLAIN, PLANKS])), 0.3)
        put(BOX, x, size[1], z, size, material)
        if scene.maybe(0.4):  # a back rest
            put(BOX, x, 1.6 * size[1], z + size[2], (size[0], 1.6 * size[1], 0.1), material)
        if scene.maybe(0.4):
            put(ELLIPSOID, x, 2.3 * size[1], z, (0.2, 0.25, 0.2), scene.material(PAINTS + GREENS))
    for _ in range(int(scene.random.integers(0, 7))):  # doors, windows, pictures
        glow, tall = (0.8 if scene.maybe(0.3) else 0.0), scene.uniform(0.4, 1.2)
        panel = scene.material(
            PAINTS + STONES + EARTHS, int(scene.random.choice([PLAIN, PLANKS, STRIPES])), 0.4, glow
        )
        put(
            BOX,
            scene.uniform(-0.9, 0.9) * half[0],
            tall + scene.uniform(0, 1),
            half[2],
            (scene.uniform(0.3, 0.8), tall, 0.05),
            panel,
        )
    if scene.maybe(0.4):
        put(ELLIPSOID, scene.uniform(-0.5, 0.5) * half[0], 1.6 * half[1], scene.uniform(-0.2, 0.8) * half[2],
            (0.3, 0.25, 0.3), scene.material(PAINTS, PLAIN, 1, 0.7))  # fmt: skip
    for _ in range(int(scene.random.integers(0, 4))):
        scene.stand("person", *scene.spot(2.5, 12, 0.5), 1.7, PAINTS + STONES)


def bouquet_scene(scene: Scene) -> None:
    """One to a few large flowers near the lens: over a meadow, before the sky, or before a blur."""
    white = scene.maybe(0.35)
    palette = WHITES if white else FLOWERS + PAINTS
    outdoors = scene.maybe(0.6)
    scene.sky, scene.backdrop = outdoors, scene.uniform(0.05, 0.35)
    scene.eye, scene.pitch_deg = (0, scene.uniform(0.5, 1.6), 0), scene.uniform(-12, 12)
    if outdoors and scene.maybe(0.85):
        scene.ground(GREENS + EARTHS, int(scene.random.choice([PLAIN, BLOTCHES])), 0.5)
        if scene.maybe(0.5):
            _hills(scene, 200, scene.uniform(10, 60), scene.maybe(0.5), 40)
        for _ in range(int(scene.random.integers(0, 8))):
            _tree(scene, *scene.spot(12, 120), scene.uniform(3, 12))
        tall = scene.uniform(0.5, 1.3) * scene.eye[1]
        for _ in range(int(scene.random.integers(20, 160))):
            scene.stand("stem", *scene.spot(0.9, 12), tall * scene.uniform(0.4, 1), GREENS)
        for _ in range(int(scene.random.integers(0, 50))):
            scene.stand("flower", *scene.spot(1.2, 25), tall * scene.uniform(0.7, 1.2), palette)
        scene.haze = scene.log_uniform(60, 600) if scene.maybe(0.5) else 0
    elif scene.maybe(0.5):  # the same kind of flower behind, in the blur
        for _ in range(int(scene.random.integers(1, 7))):
            at = (scene.uniform(0, 1) * scene.width, scene.uniform(0, 1.1) * scene.height)
            _float(
                scene,
                "daisy",
                *at,
                scene.log_uniform(0.1, 0.35) * scene.height,
                scene.backdrop * scene.uniform(1.2, 2),
                palette,
            )
    for _ in range(int(scene.random.choice([1, 1, 1, 2, 3, 5]))):
        at = (scene.uniform(0.15, 0.85) * scene.width, scene.uniform(0.15, 0.8) * scene.height)
        size = scene.log_uniform(0.12, 0.5) * scene.height
        _float(scene, "daisy", *at, size, 1 / scene.log_uniform(0.45, 1.3), palette)
    if not outdoors or scene.maybe(0.4):
        scene.defocus = scene.uniform(0.4, 1.6)


def garden_scene(scene: Scene) -> None:
    """Shrubs, posts, walls, wheels and people at all distances, from eye height."""
    scene.eye, scene.pitch_deg = (0, scene.uniform(0.7, 3.5), 0), float(scene.random.normal(5, 8))
    scene.sky, scene.backdrop = scene.maybe(0.75), 0.02
    scene.ground(
        GREENS + EARTHS + STONES,
        int(scene.random.choice([PLAIN, BLOTCHES, ROAD, CHECKER])),
        scene.log_uniform(0.3, 3),
    )
    _walls(scene, 3, 30, int(scene.random.integers(0, 5)))
    for _ in range(int(scene.random.integers(0, 5))):
        _cottage(scene, *scene.spot(10, 60), scene.uniform(2, 5), scene.uniform(2, 6), scene.uniform(0, 3.1))
    _crowd(scene, 2, 40, int(scene.random.integers(3, 30)))
    for _ in range(int(scene.random.integers(0, 4)) if scene.maybe(0.4) else 0):
        scene.stand("wheel", *scene.spot(0.9, 6), scene.uniform(0.5, 1.1), STONES + PAINTS)
    for _ in range(int(scene.random.integers(0, 7))):
        x, z = scene.spot(4, 60)
        tall = scene.uniform(2, 14)
        scene.add(
            CONE,
            (x, tall / 2, z),
            (0.22 * tall, tall / 2, 0.22 * tall),
            scene.material(GREENS),
            0,
            0.25,
            20 / tall,
        )
    if scene.maybe(0.2):
        scene.add(PLANE, (0, 0.02, 0), (1, 1, 1), scene.material(WATERS))
    if scene.maybe(0.35):
        _hang(scene)
    scene.haze = scene.log_uniform(40, 500) if scene.maybe(0.5) else 0
