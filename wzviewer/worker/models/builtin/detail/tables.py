"""Tables per name: what a description says of each label's material, for those names that are its own."""

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.amplitude import PROMPTED_FLOOR, regional_sigma, woods
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.materials import per_label
from wzviewer.worker.models.builtin.detail.overlay import grain_rms

FIRST_DEEP = 0.8
"""Of the deep contrast, at level 2: it still looks like the photograph, not like a micrograph."""


def regional_table(context: Context, names: tuple[str, ...], level: int) -> FloatArray:
    """Returns ``(n,)``: `regional_sigma` of the regions, 0 below the first zoom."""
    table = np.zeros(len(names), np.float32)
    if level <= 1 and _of_context(names, context):
        table[: len(context.regions)] = regional_sigma(context.regions, context.materials)
    return table


def grain_table(context: Context, names: tuple[str, ...], level: int) -> FloatArray:
    """Returns ``(n,)``: the photograph's noise, 0 below the first zoom."""
    table = np.zeros(len(names), np.float32)
    if level <= 1 and context.regions:
        known = grain_rms(context)
        table[:] = known.min()
        if _of_context(names, context):
            table[: len(known)] = known
    return table


def floor_table(names: tuple[str, ...], level: int, is_prompted: bool) -> FloatArray:
    """Returns ``(n,)``: the least contrast of each material as a share of the luminance."""
    table = per_label(names, "floor" if level <= 1 else "deep_floor")
    if level == 2:
        table = table * np.float32(FIRST_DEEP)
    return np.maximum(table, np.float32(PROMPTED_FLOOR)) if is_prompted else table


def wood_table(context: Context, names: tuple[str, ...]) -> FloatArray:
    """Returns ``(n,)``: 1 in `woods`."""
    table = np.zeros(len(names), np.float32)
    if _of_context(names, context):
        table[: len(context.regions)] = woods(context.regions, context.materials)
    return table


def tints_table(context: Context, names: tuple[str, ...]) -> FloatArray:
    """Returns ``(n, 2)``: a* and b* of the regions."""
    table = np.zeros((len(names), 2), np.float32)
    if _of_context(names, context):
        table[: len(context.regions)] = [(r.green_red, r.blue_yellow) for r in context.regions]
    return table


def _of_context(names: tuple[str, ...], context: Context) -> bool:
    return names[: len(context.materials)] == context.materials
