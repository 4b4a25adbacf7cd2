"""Small scenes for the tests of the renderers: surfaces sampled on a camera's pixels, one surfel each."""

import numpy as np

from wzviewer.core.anchor import LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.scene import Level, Scene, coverage_for
from wzviewer.core.surfels import Surfels

SIGMA_PX, OPACITY = 0.55, 0.99


def pixel_rays(camera):
    y, x = np.mgrid[0 : camera.height, 0 : camera.width] + 0.5
    rays = [(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, np.ones(x.shape)]
    return np.stack(rays, -1).reshape(-1, 3)


def facing_quats(normals):
    """The shortest turns of the z axis to unit normals, wxyz."""
    half = normals + np.array([0.0, 0.0, 1.0])
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    return np.stack([half[:, 2], -half[:, 1], half[:, 0], np.zeros(len(half))], 1)


def surface(camera, frame, depth, image, opacity=OPACITY):
    """Surfels on a depth map (h, w) in world units, with the colours of an image (h, w, 3) uint8."""
    depth = np.broadcast_to(depth, (camera.height, camera.width)).astype(np.float64)
    slope_y, slope_x = np.gradient(depth)
    normals = np.stack([-slope_x, -slope_y, depth / camera.focal_px], -1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    z = depth.reshape(-1, 1)
    means = (pixel_rays(camera) * z - camera.to_camera(frame.origin)) / frame.unit
    native = (z / camera.focal_px / frame.unit)[:, 0]
    scales = SIGMA_PX * native[:, None] * np.stack([1.0 / normals[:, 2], np.ones(len(z))], 1)
    n = len(means)
    colors = image.reshape(-1, 3).astype(np.float32) / 255.0
    quats = facing_quats(normals)
    return Surfels(means, quats, scales, np.full(n, opacity), colors, native, np.ones(n))


def add_surface(scene, parent, camera, depth, image, opacity=OPACITY):
    """Appends a level of `surface`, anchored at its median depth."""
    frame = LevelFrame.of_camera(camera, float(np.median(depth)))
    surfels = surface(camera, frame, depth, image, opacity)
    surfels = surfels.with_(coverage=coverage_for(scene, parent, camera, frame, surfels.means))
    relief = np.zeros((camera.height, camera.width), np.float32)
    scene.append(Level(len(scene), parent, camera, frame, surfels, image, relief))
    return scene[len(scene) - 1]


def noise_image(camera, seed):
    rng = np.random.default_rng(seed)
    return rng.integers(0, 256, (camera.height, camera.width, 3), dtype=np.uint8)


def hills(camera, root):
    """A smooth depth over the pixels of the root camera, seen from a camera of the same pose."""
    rays = pixel_rays(camera)
    x, y = rays[:, 0] * root.fx + root.cx, rays[:, 1] * root.fy + root.cy
    depth = 1.0 + 0.2 * np.sin(x / 6.0) + 0.1 * np.cos(y / 4.0)
    return depth.reshape(camera.height, camera.width)


def hill_scene(width=40, height=28, num_levels=3, factor=8.0):
    """A chain of levels over the same hills, each with noise of its own."""
    scene, root = Scene(), Camera.initial(width, height)
    camera = root
    for i in range(num_levels):
        add_surface(scene, i - 1 if i else None, camera, hills(camera, root), noise_image(camera, i))
        camera = camera.zoomed_to_region(0.45, 0.55, factor)
    return scene


def flat_scene(width=64, height=48, num_levels=2, factor=8.0, color=255):
    """A chain of levels on one frontal plane, all of one colour."""
    scene, camera = Scene(), Camera.initial(width, height)
    for i in range(num_levels):
        image = np.full((height, width, 3), color, np.uint8)
        add_surface(scene, i - 1 if i else None, camera, 1.0, image)
        camera = camera.zoomed_to_region(0.5, 0.5, factor)
    return scene


def orbited(camera, target, angle_deg):
    """A camera turned about a world point, about its own y axis."""
    a = np.radians(angle_deg)
    turn = np.eye(4)
    turn[:3, :3] = [[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]]
    there, back = np.eye(4), np.eye(4)
    at = camera.to_camera(np.asarray(target))
    there[:3, 3], back[:3, 3] = -at, at
    pose = back @ turn @ there @ camera.camera_from_world
    return Camera(pose, camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)
