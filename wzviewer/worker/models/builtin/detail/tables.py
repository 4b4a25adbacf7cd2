"""Tables per name: what a description says of each label's material, for those names that are its own."""

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.amplitude import regional_sigma, woods
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.overlay import grain_rms


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
