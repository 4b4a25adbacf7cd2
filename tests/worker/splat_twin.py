"""An independent rasteriser in float64: every surfel over the whole image, straight from the formulas.

It shares nothing with the package but the camera and the frozen constants.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import convolve1d

ALPHA_CUT, ALPHA_MAX, LOW_PASS_PX2, STOP = 1 / 255, 0.99, 0.02, 1e-4


@dataclass
class Splats:
    means: np.ndarray
    quats: np.ndarray
    log_scales: np.ndarray
    x: np.ndarray
    colors: np.ndarray

    @property
    def opacities(self):
        return np.clip(0.51 * np.tanh(self.x) + 0.5, 1e-4, 0.995)


def axes_of(q):
    w, x, y, z = q / np.linalg.norm(q)
    first = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    second = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    return first, second


def footprint(mean, quat, scales, camera, frame):
    """Centre px, screen covariance and camera depth of one surfel."""
    world_from_local = frame.unit * frame.axes.T
    p = camera.rotation @ (frame.origin + world_from_local @ mean - camera.position)
    J = np.array(
        [
            [camera.fx / p[2], 0, -camera.fx * p[0] / p[2] ** 2],
            [0, camera.fy / p[2], -camera.fy * p[1] / p[2] ** 2],
        ]
    )
    W = J @ camera.rotation @ world_from_local
    t1, t2 = axes_of(quat)
    U = W @ np.stack([scales[0] * t1, scales[1] * t2], 1)
    centre = np.array([camera.fx * p[0] / p[2] + camera.cx, camera.fy * p[1] / p[2] + camera.cy])
    return centre, U @ U.T + LOW_PASS_PX2 * np.eye(2), p[2]


def alphas_of(splats, i, camera, frame):
    scales = np.exp(splats.log_scales[i])
    centre, cov, depth = footprint(splats.means[i], splats.quats[i], scales, camera, frame)
    x, y = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    d = np.stack([x - centre[0], y - centre[1]], -1)
    power = np.einsum("hwi,ij,hwj->hw", d, np.linalg.inv(cov), d)
    alpha = np.minimum(splats.opacities[i] * np.exp(-0.5 * power), ALPHA_MAX)
    return np.where((alpha >= ALPHA_CUT) & (depth > 0), alpha, 0.0), depth


def composite(layers, shape, background, stop=STOP):
    """Layers are (depth, alpha (h, w), color), blended nearest first (stable)."""
    image, through = np.zeros((*shape, 3)), np.ones(shape)
    median = np.full(shape, np.nan)
    for depth, alpha, color in sorted(layers, key=lambda layer: layer[0]):
        a = np.where(through >= stop, alpha, 0.0)
        image += (through * a)[..., None] * color
        after = through * (1 - a)
        median = np.where((through > 0.5) & (after <= 0.5), depth, median)
        through = after
    return image + through[..., None] * np.asarray(background), through, median


def render(splats, camera, frame, background=(0, 0, 0), weights=None, blend="transmittance"):
    layers = []
    for i in range(len(splats.means)):
        alpha, depth = alphas_of(splats, i, camera, frame)
        w = 1.0 if weights is None else weights[i]
        alpha = alpha * w if blend == "linear" else 1 - (1 - alpha) ** w
        layers.append((depth, alpha, splats.colors[i]))
    return composite(layers, (camera.height, camera.width), background)


def blurred(a):
    g = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    g /= g.sum()
    return convolve1d(convolve1d(a, g, axis=0, mode="constant"), g, axis=1, mode="constant")


def loss(image, target):
    """0.8 L1 + 0.2 (1 - SSIM), channel by channel."""
    mu, nu = blurred(image), blurred(target)
    var, war = blurred(image**2) - mu**2, blurred(target**2) - nu**2
    cov = blurred(image * target) - mu * nu
    ssim = (2 * mu * nu + 1e-4) * (2 * cov + 9e-4) / ((mu**2 + nu**2 + 1e-4) * (var + war + 9e-4))
    return 0.8 * np.abs(image - target).mean() + 0.2 * (1 - ssim.mean())
