"""Spread wings of birds: quills that fan out of the wrist, a row along the arm, coverts over both."""

import numpy as np

from wzviewer.core.types import DoubleArray
from wzviewer.worker.models.builtin.objects.bodies import Pen, Vector, shaded, vector
from wzviewer.worker.models.builtin.objects.patterns import FUR

_PRIMARIES, _SECONDARIES, _COVERTS = 9, 7, 8
_LIFT_DEG, _PITCH_DEG = 24.0, 22.0  # of the wing above level, of its front edge


def spread_wing(pen: Pen, side: float, shoulder: Vector, wing: Vector, edge: Vector) -> None:
    """Adds one wing, open, raised a little; `side` is -1 or 1, the colours those of quills and coverts."""
    lift, pitch = np.radians(_LIFT_DEG + pen.rng.normal(0, 3)), np.radians(_PITCH_DEG)
    out = np.array([side * np.cos(lift), 0.0, np.sin(lift)])
    ahead = np.array([0.0, np.cos(pitch), np.sin(pitch)])
    up = np.cross(out, ahead) * side
    quill, covert = (
        pen.material(
            FUR, color, shaded(color, 0.5), rough=0.6, wrap=0.3, thin=0.3, wavelength=0.006, relief=0.05,
            free=(8.0, 0.22),
        )
        for color in (wing, edge)
    )  # fmt: skip
    root = np.asarray(shoulder)
    wrist = root + 0.25 * out + 0.075 * ahead
    for k in range(_PRIMARIES):
        angle = np.radians(10.0 + 8.5 * k)
        length = 0.32 + 0.055 * np.sin(np.pi * (k + 1.5) / _PRIMARIES)
        along = np.cos(angle) * out - np.sin(angle) * ahead
        _quill(pen, wrist - 0.0022 * k * up, along, up, float(length), 0.024, quill)
    for k in range(_SECONDARIES):
        angle = np.radians(84.0 + 1.5 * k)
        start = wrist + (root - wrist) * (k + 0.3) / _SECONDARIES
        along = np.cos(angle) * out - np.sin(angle) * ahead
        _quill(pen, start - 0.0022 * (k + 5) * up, along, up, 0.245 - 0.004 * k, 0.034, quill)
    for k in range(_COVERTS):
        share = k / (_COVERTS - 1)
        angle = np.radians(22.0 + 66.0 * min(2.2 * share, 1.0))
        start = wrist + (root - wrist) * max(1.35 * share - 0.35, 0.0) + 0.010 * up
        along = np.cos(angle) * out - np.sin(angle) * ahead
        _quill(pen, start, along, up, 0.135, 0.038, covert)
    group = pen.group()
    middle = root + 0.06 * out + 0.05 * ahead
    pen.cone(vector(root), vector(wrist), 0.036, 0.022, covert, group=group, blend=0.03)
    pen.cone(vector(middle), vector(wrist + 0.07 * out), 0.030, 0.010, covert, group=group, blend=0.03)


def _quill(
    pen: Pen,
    root: DoubleArray,
    along: DoubleArray,
    up: DoubleArray,
    length: float,
    width: float,
    material: int,
) -> None:
    """Adds one feather: a thin blade with a round tip, curving a little downwards."""
    across = np.cross(along, up)
    across /= np.linalg.norm(across)
    axes = np.stack([across, along, np.cross(across, along)])
    half = length / 2
    pen.loft(
        [(-half, 0.0, 0.4 * width, 0.010, 0.008), (0.3 * half, 0.012, 0.9 * width, 0.006, 0.005),
        (0.75 * half, 0.004, width, 0.004, 0.004), (0.95 * half, -0.006, 0.6 * width, 0.003, 0.003),
        (half, -0.008, 0.003, 0.002, 0.002)],
        material,
        centre=vector(root + half * along),
        axes=axes,
    )  # fmt: skip
