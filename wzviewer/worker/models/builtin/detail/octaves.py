"""How the contrast of a texture is shared out among the three octaves that an enlargement by eight adds."""

from collections.abc import Callable

import numpy as np

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import widely_blurred

LIMIT = 3.0  # deviations: one black speck must not outshine a whole texture
OCTAVES = (0.52, 0.56, 0.6)
"""Relative RMS of the three unseen octaves, finest first: a photograph's, a little crisper."""
GRAIN_OCTAVES = (0.42, 0.58, 0.7)
"""The same for strands, of which the finest would alias into beads at the next level."""
FORMS = (0.42, 0.52, 0.74)
"""For what is invented wholly: forms rather than grain."""
CLUMPED = 0.5
"""Their evenness: here crowded, there calm, as nothing in nature is spread evenly."""
SPARSE = frozenset({"haze", "plankton"})
"""Few things and nothing between: evened, the nothing would be as loud as they are."""
BREATH = (0.03, 0.15, 0.98)
"""For what has no outline."""
SPECTRA = {
    **dict.fromkeys(("tissue", "cell", "cornea", "granule", "cytoplasm"), FORMS),
    **dict.fromkeys(("membrane", "molecule", "atom"), FORMS),
    **dict.fromkeys(("orbital", "nucleus", "froth", "lattice", "facet", "alloy", "granite", "cast"), FORMS),
    **dict.fromkeys(("droplet", "frost", "plankton", "caustic", "grit"), FORMS),
    **dict.fromkeys(("helix", "salt", "shell", "sea", "ice", "dipole", "strings"), FORMS),
    "air": BREATH,
    "haze": (0.3, 0.5, 0.8),
}


def evened(
    texture: FloatArray,
    octaves: tuple[float, ...] = OCTAVES,
    stride: int = 1,
    evenness: float = 1.0,
    blur: Callable[[FloatArray, float], FloatArray] = widely_blurred,
) -> FloatArray:
    """Returns the three unseen octaves in the given proportion, with about the same contrast everywhere.

    Args:
        texture: ``(H, W)`` in deviations.
        octaves: relative RMS of the octaves, finest first.
        stride: texture px per image px.
        evenness: 1 gives every place the same contrast, 0 leaves them as they are.
        blur: Gaussian blur of a plane by a deviation in px.
    """
    levels = [texture, *(blur(texture, sigma / stride) for sigma in (1.0, 2.0, 5.0))]
    total = np.zeros_like(texture)
    for finer, coarser, share in zip(levels[:-1], levels[1:], octaves, strict=True):
        band = finer - coarser
        total += band * np.clip(share / (band.std() + 1e-6), 0.3, 3.0)
    local = np.sqrt(np.maximum(blur(total * total, 24.0), 0)) + np.float32(0.05)
    return np.clip(total / local ** np.float32(evenness), -LIMIT, LIMIT).astype(np.float32)
