"""The crisp base: contours of the enlarged picture, sharp and without halos; no new texture.

A compact network of our own (`network`) draws it.  It learnt from procedural pictures to a loss that has no
place for invention, so it makes contours exact where they are certain and leaves interiors smooth: texture is
the business of the materials.

Anything else that is a `BaseUpscaler` can take its place.
"""

from collections.abc import Callable
from importlib import resources

import cv2
import numpy as np
import torch
from safetensors.torch import load

from wzviewer.core.types import FloatArray
from wzviewer.worker.models.builtin.detail.measures import blurred
from wzviewer.worker.models.builtin.detail.network import STEP_CHANNELS, DetailNetwork

BaseUpscaler = Callable[[FloatArray, int, int], FloatArray]
"""``base(image, doublings, level)``: grey levels ``(h, w, 3)`` in, each side 2^doublings times longer out."""
MOST_DOUBLINGS = len(STEP_CHANNELS)
WORN_LEVELS = 2  # the first zoom still shows the softness of the photograph, and the second enlarges it
STEEPNESS, PHOTOGRAPHED_STEEPNESS = np.float32(1.0), np.float32(0.6)
"""Beyond the photograph, and in it, where a little of the lens's softness is kept."""
THIN_GAIN = np.float32(0.8)
BORDER_PX = 6
"""The picture is mirrored at its borders this far, or the network would see grey beyond them."""


class NetworkBase:
    """The built-in base; reads its weights, which come inside the package, on first use."""

    def __init__(self) -> None:
        self._network: DetailNetwork | None = None

    def __call__(self, image: FloatArray, doublings: int, level: int = 1) -> FloatArray:
        """Returns the image enlarged by ``2**doublings`` with crisp contours.

        Args:
            image: ``(h, w, 3)`` float32 grey levels.
            doublings: number of x2 steps; above 3 the network is applied to its own result.
            level: of the new image; the first enlarge a photograph, worn by optics and compression.
        """
        while doublings > MOST_DOUBLINGS:
            first = (doublings - 1) % MOST_DOUBLINGS + 1
            image, doublings, level = self._enlarged(image, first, level), doublings - first, 2
        return self._enlarged(image, doublings, level) if doublings else image

    def _enlarged(self, image: FloatArray, doublings: int, level: int) -> FloatArray:
        if self._network is None:
            self._network = loaded_network()
        pad, grow = BORDER_PX, 1 << doublings
        padded = cv2.copyMakeBorder(image, pad, pad, pad, pad, cv2.BORDER_REFLECT_101)
        picture = torch.from_numpy(np.ascontiguousarray(padded.transpose(2, 0, 1)[None])) / 255
        worn = torch.tensor([1.0 if level <= WORN_LEVELS else 0.0])
        with torch.inference_mode():
            made = self._network(picture, worn, doublings)[-1][0]
        inner = made[:, grow * pad : -grow * pad, grow * pad : -grow * pad]
        large = held(np.ascontiguousarray((inner * 255).permute(1, 2, 0).numpy()), image)
        return held(steeper(large, grow, STEEPNESS if level > 1 else PHOTOGRAPHED_STEEPNESS), image)


def steeper(large: FloatArray, grow: int, steepness: np.float32 = STEEPNESS) -> FloatArray:
    """Returns contours half a coarse pixel wide: what was invented has no softness of a lens to keep."""
    return large + steepness * (large - blurred(large, 0.5 * grow))


def held(large: FloatArray, image: FloatArray) -> FloatArray:
    """Returns the enlargement between the extremes of each coarse pixel's neighbourhood: no halos.

    The next level would make a halo eight times wider.  Only what is thinner than three pixels, which the
    morphological top hat finds, may be brighter or darker than it was seen: its pixels were shared.
    """
    box, size = np.ones((3, 3), np.uint8), (large.shape[1], large.shape[0])
    opened, closed = (cv2.morphologyEx(image, how, box) for how in (cv2.MORPH_OPEN, cv2.MORPH_CLOSE))
    highest = cv2.dilate(image + THIN_GAIN * (image - opened), box)
    lowest = cv2.erode(image - THIN_GAIN * (closed - image), box)
    bounds = [cv2.resize(plane, size, interpolation=cv2.INTER_NEAREST) for plane in (lowest, highest)]
    return np.clip(large, *bounds)


def loaded_network() -> DetailNetwork:
    """Returns the trained network in float32, for inference."""
    network = DetailNetwork()
    file = resources.files("wzviewer.worker.models.builtin.weights").joinpath("detail.safetensors")
    network.load_state_dict(load(file.read_bytes()))
    return network.float().eval()
