"""Ten kinds of scene: fields, streets, rooms, close-ups, forests, mountains, tables, beaches, heaps, cities.

The constants are everyday sizes in metres; variety matters more than truth.
"""

import numpy as np
from depth_raytrace import BLOTCHES, BRICKS, CHECKER, PLAIN, PLANKS, ROAD, SHORE, STRIPES, WINDOWS
from depth_scenes import (
    EARTHS,
    FLOWERS,
    GREENS,
    PAINTS,
    SHAPES,
    STONES,
    WATERS,
    Scene,
    Sprite,
    fractal,
)
from depth_solids import BOX, CYLINDER, ELLIPSOID, PLANE, ROOM


def _hills(scene: Scene, span: float, tall: float, ridged: bool, near: float) -> None:
    """A height field that is low in front of the camera and rises to `tall` beyond `near`."""
    n = 160
    ground = fractal(scene.random, n, n, scene.uniform(2, 5), ridged=ridged) - 0.45
    distance = np.linspace(0, 2 * span, n, dtype=np.float32)[:, None]
    scene.relief = (ground * tall * np.clip((distance - near) / (0.8 * span), 0, 1)).astype(np.float32)
    scene.span = span
    scene.relief_material = scene.material(
        GREENS + STONES[:2] + EARTHS[:2], BLOTCHES, scene.log_uniform(2, 30)
    )


def _tree(scene: Scene, x: float, z: float, tall: float) -> None:
    trunk = scene.material([(0.25, 0.18, 0.12), (0.4, 0.35, 0.3), (0.1, 0.08, 0.07)])
    scene.add(CYLINDER, (x, 0.3 * tall, z), (0.025 * tall, 0.35 * tall, 0.025 * tall), trunk)
    crown, wide = scene.material(GREENS), scene.uniform(0.15, 0.35) * tall
    porous, grain = scene.uniform(0.2, 0.55), scene.uniform(6, 20) / tall
    for _ in range(int(scene.random.integers(1, 3))):
        at = (x + scene.random.normal() * 0.1 * tall, scene.uniform(0.5, 0.8) * tall, z)
        scene.add(ELLIPSOID, at, (wide, scene.uniform(0.2, 0.35) * tall, wide), crown, 0, porous, grain)


def _house(scene: Scene, x: float, z: float, wide: float, tall: float, yaw: float) -> None:
    pattern = int(scene.random.choice([WINDOWS, WINDOWS, BRICKS, PLANKS, PLAIN]))
    wall = scene.material(
        STONES + PAINTS + EARTHS, pattern, scene.uniform(1.2, 4) if pattern == WINDOWS else 0.3
    )
    deep = wide * scene.uniform(0.6, 1.5)
    scene.add(BOX, (x, tall / 2, z), (wide, tall / 2, deep), wall, yaw)
    roof = scene.material(EARTHS + STONES[:2])
    scene.add(BOX, (x, tall, z), (wide * 1.05, 0.06 * tall, deep * 1.05), roof, yaw)


def field_scene(scene: Scene) -> None:
    """Meadow, lawn or crop under a sky, with trees, flowers, animals, people."""
    scene.eye, scene.pitch_deg = (0, scene.log_uniform(0.5, 4), 0), float(scene.random.normal(3, 7))
    scene.ground(
        GREENS + EARTHS[2:4], int(scene.random.choice([PLAIN, BLOTCHES, ROAD])), scene.log_uniform(0.5, 4)
    )
    if scene.maybe(0.5):
        _hills(scene, 200, scene.uniform(10, 60), scene.maybe(0.3), 40)
    for _ in range(int(scene.random.integers(0, 12))):
        _tree(scene, *scene.spot(6, 120), scene.uniform(3, 12))
    for _ in range(int(scene.random.integers(0, 3))):
        _house(scene, *scene.spot(12, 80), scene.uniform(2, 6), scene.uniform(3, 8), scene.uniform(0, 3))
    tall = scene.log_uniform(0.2, 1.4)
    for _ in range(int(scene.random.integers(0, 130)) if scene.maybe(0.6) else 0):
        scene.stand("stem", *scene.spot(0.8, 15), tall * scene.uniform(0.4, 1), GREENS)
    for _ in range(int(scene.random.integers(0, 60)) if scene.maybe(0.5) else 0):
        scene.stand("flower", *scene.spot(0.8, 25), tall * scene.uniform(0.7, 1.2), FLOWERS)
    for _ in range(int(scene.random.integers(0, 4))):
        scene.stand(
            str(scene.random.choice(["person", "animal"])), *scene.spot(3, 40), 1.6, PAINTS + STONES + EARTHS
        )


def street_scene(scene: Scene) -> None:
    """A canyon of boxes with cars, people, trees and poles."""
    scene.eye, scene.pitch_deg = (
        (scene.uniform(-3, 3), scene.log_uniform(1.4, 9), 0),
        float(scene.random.normal(-1, 6)),
    )
    scene.ground(STONES, int(scene.random.choice([PLAIN, ROAD, BRICKS, CHECKER])), scene.log_uniform(0.4, 4))
    bend, gap, tall = scene.random.normal() * 0.25, scene.uniform(4, 12), scene.log_uniform(5, 30)
    for side in (-1, 1):
        z = scene.uniform(0, 10)
        while z < 120 and scene.maybe(0.97):
            deep = scene.uniform(4, 12)
            _house(scene, side * (gap + 5) + bend * z, z + deep, 5, tall * scene.uniform(0.6, 1.4), -bend)
            z += 2 * deep + (scene.uniform(0, 10) if scene.maybe(0.3) else 0)
    for _ in range(int(scene.random.integers(0, 6))):
        z = scene.log_uniform(5, 60)
        x, paint = scene.uniform(-gap, gap) + bend * z, scene.material(PAINTS + STONES)
        scene.add(BOX, (x, 0.5, z), (0.9, 0.45, 2.1), paint, scene.random.normal() * 0.1)
        scene.add(BOX, (x, 1.1, z), (0.75, 0.3, 1.1), scene.material(STONES[1:]), 0)
    for _ in range(int(scene.random.integers(0, 7))):
        scene.stand("person", *scene.spot(4, 40, 0.5), 1.7, PAINTS + STONES)
    for _ in range(int(scene.random.integers(0, 5))):
        z = scene.log_uniform(6, 60)
        _tree(scene, scene.random.choice([-1, 1]) * gap * 0.8 + bend * z, z, scene.uniform(4, 9))
    scene.haze = scene.log_uniform(60, 600) if scene.maybe(0.6) else 0


def room_scene(scene: Scene) -> None:
    """The inside of a box with furniture, pictures and a bright window."""
    half = (scene.uniform(1.5, 4), scene.uniform(1.1, 1.7), scene.uniform(1.5, 5))
    yaw = scene.uniform(-0.8, 0.8)
    wall = scene.material(
        STONES[2:4] + PAINTS[3:] + EARTHS[2:4], int(scene.random.choice([PLAIN, STRIPES, BRICKS])), 0.4
    )
    # the renderer takes the two rows after the wall's: floor (its normal points up), then ceiling
    scene.material(
        EARTHS + STONES, int(scene.random.choice([PLANKS, CHECKER, PLAIN])), scene.uniform(0.1, 0.6)
    )
    scene.material(STONES[2:4] + PAINTS[3:4], PLAIN, 1, 0.1)
    scene.add(ROOM, (0, half[1], 0), half, wall, yaw)
    scene.eye = (
        scene.uniform(-0.5, 0.5) * half[0],
        scene.uniform(0.9, 1.8),
        -scene.uniform(0.2, 0.8) * half[2],
    )
    scene.pitch_deg, scene.sky, scene.backdrop = float(scene.random.normal(8, 9)), False, 0.1
    scene.point_light = (scene.uniform(-1, 1), 2 * half[1] - 0.3, scene.uniform(-1, 1))
    c, s = np.cos(yaw), np.sin(yaw)
    for _ in range(int(scene.random.integers(3, 14))):
        wide, tall, deep = scene.uniform(0.15, 0.9), scene.uniform(0.1, 0.6), scene.uniform(0.15, 0.6)
        x, z = (scene.uniform(-1, 1) * (half[k] - 0.3) for k in (0, 2))
        if scene.maybe(0.6):  # against a wall
            x, z = (np.sign(x) * (half[0] - deep), z) if scene.maybe(0.5) else (x, half[2] - deep)
        at = (c * x + s * z, tall, -s * x + c * z)
        if np.hypot(at[0] - scene.eye[0], at[2] - scene.eye[2]) < 0.9:
            continue
        material = scene.material(EARTHS + STONES + PAINTS, int(scene.random.choice([PLAIN, PLANKS])), 0.3)
        scene.add(BOX, at, (wide, tall, deep), material, yaw if scene.maybe(0.7) else scene.uniform(0, 3))
        if scene.maybe(0.4):
            kind = int(scene.random.choice([ELLIPSOID, CYLINDER]))
            size = scene.uniform(0.08, 0.25)
            porous = 0.4 if scene.maybe(0.4) else 0.0
            top = (at[0], 2 * tall + size, at[2])
            scene.add(kind, top, (size, size, size), scene.material(PAINTS + GREENS), 0, porous, 12)
    for _ in range(int(scene.random.integers(0, 6))):
        along, high = scene.uniform(-0.8, 0.8), scene.uniform(1.2, 2.0)
        glow = 0.8 if scene.maybe(0.3) else 0.0
        picture = scene.material(PAINTS + STONES + EARTHS, PLAIN, 1, glow)
        board = (scene.uniform(0.2, 0.6), scene.uniform(0.2, 0.6), 0.04)
        if scene.maybe(0.5):
            x, z, turn = along * half[0], half[2], yaw
        else:
            x, z, turn = scene.random.choice([-1, 1]) * half[0], along * half[2], yaw + np.pi / 2
        scene.add(BOX, (c * x + s * z, high, -s * x + c * z), board, picture, turn)


def macro_scene(scene: Scene) -> None:
    """Flowers, leaves or things close to the lens before a blurred ground."""
    scene.sky, scene.backdrop = scene.maybe(0.15), scene.uniform(0.08, 0.4)
    scene.defocus = scene.uniform(0.6, 1.6) if scene.maybe(0.85) else 0.0
    scene.eye, scene.pitch_deg = (0, 3, 0), scene.uniform(-5, 30)
    if scene.maybe(0.4):
        scene.ground(GREENS + EARTHS)
    for layer in range(int(scene.random.integers(1, 4))):
        disparity = scene.uniform(0.3, 0.75) if layer else 1.0
        for _ in range(int(scene.random.integers(1, 8)) if layer else int(scene.random.integers(1, 3))):
            size = scene.log_uniform(0.12, 0.45) * scene.height * disparity
            u, v = scene.uniform(0, 1) * scene.width, scene.uniform(0.1, 1.05) * scene.height
            if layer == 0:
                u, v = scene.uniform(0.25, 0.75) * scene.width, scene.uniform(0.25, 0.8) * scene.height
            shape = str(scene.random.choice(["bloom", "bloom", "blob"]))
            _float(scene, shape, u, v, size, disparity * scene.uniform(0.9, 1.1), FLOWERS + GREENS + PAINTS)


def _float(scene: Scene, shape: str, u: float, v: float, size: float, disparity: float,
           palette: list[tuple[float, float, float]]) -> None:  # fmt: skip
    color, top, seed = scene.color(palette), scene.color(GREENS), int(scene.random.integers(1 << 30))
    sprite = Sprite(u, v, size, disparity, color, top, seed)
    scene.sprites.append(lambda canvas: SHAPES[shape](canvas, sprite))


def forest_scene(scene: Scene) -> None:
    """Trunks, crowns and bushes, with sky or a green wall behind."""
    scene.eye, scene.pitch_deg = (0, scene.uniform(1, 2.5), 0), float(scene.random.normal(0, 8))
    scene.sky, scene.backdrop = scene.maybe(0.6), 0.015
    scene.ground(
        GREENS + EARTHS, int(scene.random.choice([PLAIN, BLOTCHES, ROAD])), scene.log_uniform(0.3, 2)
    )
    tall = scene.uniform(6, 25)
    for _ in range(int(scene.random.integers(8, 34))):
        x, z = scene.spot(3, 60)
        if scene.maybe(0.5):
            _tree(scene, x, z, tall * scene.uniform(0.5, 1.2))
        else:
            radius = scene.log_uniform(0.06, 0.5)
            scene.add(CYLINDER, (x, tall, z), (radius, 2 * tall, radius), scene.material(EARTHS + STONES[:2]))
    for _ in range(int(scene.random.integers(0, 12))):
        x, z = scene.spot(2, 25)
        size = scene.uniform(0.3, 1.5)
        scene.add(
            ELLIPSOID, (x, 0.6 * size, z), (size, size, size), scene.material(GREENS), 0, 0.45, 6 / size
        )
    for _ in range(int(scene.random.integers(0, 60))):
        scene.stand("stem", *scene.spot(1, 10), 0.6, GREENS)


def mountain_scene(scene: Scene) -> None:
    """A ridge, maybe a lake, maybe a rock or trees close by."""
    span = scene.uniform(150, 600)
    _hills(scene, span, span * scene.uniform(0.2, 0.9), scene.maybe(0.7), scene.uniform(0, 0.1) * span)
    level = float(np.percentile(scene.relief, scene.uniform(2, 30)))
    scene.eye = (0, scene.log_uniform(2, 0.2 * span), 0)
    scene.pitch_deg = float(scene.random.normal(2, 6))
    if scene.maybe(0.5):
        scene.add(PLANE, (0, min(level, scene.eye[1] - 1), 0), (1, 1, 1), scene.material(WATERS + GREENS))
    for _ in range(int(scene.random.integers(0, 4))):
        x, z = scene.spot(3, 30)
        size, rock = scene.uniform(0.15, 0.5) * z, scene.material(STONES + GREENS)
        scene.add(
            ELLIPSOID,
            (x, scene.eye[1] - 0.35 * z - 0.5 * size, z),
            (size, size, size),
            rock,
            0,
            0.3,
            6 / size,
        )
    scene.haze = scene.log_uniform(span * 0.4, span * 6) if scene.maybe(0.7) else 0


def table_scene(scene: Scene) -> None:
    """Things on a table or floor seen from above."""
    scene.pitch_deg, scene.sky, scene.backdrop = scene.uniform(20, 80), False, scene.uniform(0.15, 0.4)
    height = scene.uniform(0.5, 1.5)
    reach = height / np.tan(np.radians(scene.pitch_deg))
    scene.eye = (0, height, -reach)
    top = scene.material(
        EARTHS + STONES + PAINTS, int(scene.random.choice([PLAIN, PLANKS, CHECKER, STRIPES])), 0.15
    )
    scene.add(
        BOX,
        (0, -0.03, 0),
        (scene.uniform(0.4, 2), 0.03, scene.uniform(0.4, 1.2)),
        top,
        scene.random.normal() * 0.3,
    )
    if scene.maybe(0.7):
        scene.add(PLANE, (0, -0.8, 0), (1, 1, 1), scene.material(EARTHS + STONES))
    for _ in range(int(scene.random.integers(2, 16))):
        x, z, size = scene.random.normal() * 0.35, scene.random.normal() * 0.3, scene.log_uniform(0.03, 0.16)
        kind, tall = int(scene.random.choice([ELLIPSOID, BOX, CYLINDER])), size * scene.uniform(0.3, 1.6)
        material = scene.material(PAINTS + EARTHS + GREENS + STONES, PLAIN, 0.05)
        scene.add(
            kind,
            (x, tall * 0.95, z),
            (size, tall, size * scene.uniform(0.6, 1.2)),
            material,
            scene.uniform(0, 3),
        )
    scene.defocus = scene.uniform(0.3, 1) if scene.maybe(0.3) else 0


def beach_scene(scene: Scene) -> None:
    """Sand or ice, water to the horizon, islands, few people."""
    scene.eye, scene.pitch_deg = (0, scene.log_uniform(1.2, 8), 0), float(scene.random.normal(2, 6))
    shore = scene.log_uniform(1, 8)
    scene.ground([EARTHS[2], EARTHS[3], STONES[3]], SHORE if scene.maybe(0.8) else PLAIN, shore)
    scene.materials[-1][6:9] = [float(v) for v in scene.color(WATERS)]
    for _ in range(int(scene.random.integers(0, 4))):
        x, z = scene.spot(60, 400)
        wide = scene.uniform(0.1, 0.6) * z
        scene.add(
            ELLIPSOID,
            (x, 0, z),
            (wide, wide * scene.uniform(0.1, 0.5), wide),
            scene.material(GREENS + STONES),
        )
    for _ in range(int(scene.random.integers(0, 4))):
        x, z = scene.spot(3, 25)
        size = scene.uniform(0.2, 1.5)
        scene.add(
            ELLIPSOID, (x, 0.2 * size, z), (size, 0.7 * size, size), scene.material(STONES), 0, 0.25, 4 / size
        )
    for _ in range(int(scene.random.integers(0, 6))):
        scene.stand("person", *scene.spot(4, 40), 1.7, PAINTS + STONES)
    scene.haze = scene.log_uniform(100, 1500) if scene.maybe(0.5) else 0


def objects_scene(scene: Scene) -> None:
    """A heap of random solids, outdoors, before a wall, or in the blur."""
    scene.eye, scene.pitch_deg = (0, scene.log_uniform(0.4, 3), 0), scene.uniform(-8, 25)
    scene.sky, scene.backdrop = scene.maybe(0.4), 0.05
    if scene.maybe(0.85):
        scene.ground(
            GREENS + EARTHS + STONES + PAINTS, int(scene.random.choice([PLAIN, CHECKER, PLANKS])), 0.7
        )
    if not scene.sky or scene.maybe(0.3):
        z = scene.uniform(4, 25)
        pattern = int(scene.random.choice([PLAIN, BRICKS, WINDOWS, STRIPES]))
        wall = scene.material(STONES + PAINTS + EARTHS, pattern, scene.uniform(0.3, 2))
        scene.add(
            BOX,
            (scene.uniform(-3, 3), 0, z + 3),
            (20, scene.log_uniform(2, 14), 3),
            wall,
            scene.random.normal() * 0.3,
        )
    for _ in range(int(scene.random.integers(2, 14))):
        x, z = scene.spot(1.2, 14, 0.6)
        size = scene.uniform(0.08, 0.3) * z
        kind, tall = int(scene.random.choice([ELLIPSOID, BOX, CYLINDER])), size * scene.uniform(0.4, 2)
        porous = scene.uniform(0.2, 0.5) if scene.maybe(0.3) else 0.0
        material = scene.material(PAINTS + GREENS + STONES + EARTHS, PLAIN, 0.3)
        scene.add(
            kind, (x, tall * 0.95, z), (size, tall, size), material, scene.uniform(0, 3), porous, 5 / size
        )
    scene.defocus = scene.uniform(0.2, 1) if scene.maybe(0.3) else 0


def city_scene(scene: Scene) -> None:
    """A block of houses from a roof or a hill."""
    height = scene.log_uniform(8, 80)
    scene.eye, scene.pitch_deg = (0, height, 0), scene.uniform(-2, 25)
    scene.ground(STONES + GREENS, int(scene.random.choice([CHECKER, BLOTCHES, PLAIN])), 12)
    for _ in range(int(scene.random.integers(15, 55))):
        x, z = scene.spot(height * 0.8, height * 15)
        _house(scene, x, z, scene.uniform(4, 10), scene.log_uniform(4, height), scene.random.normal() * 0.3)
    if scene.maybe(0.4):
        _hills(scene, 800, scene.uniform(40, 250), True, 300)
    scene.haze = scene.log_uniform(height * 6, height * 40) if scene.maybe(0.6) else 0
