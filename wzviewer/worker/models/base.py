"""Protocols of the models behind the five stages; `builtin` implements them without weights.

::

    Synthesizer ──► depth   DepthEstimator    stage 0, 2
                    detail  SuperResolver     stage 1: describe S, preview, upscale I'
                    editor  ImageEditor       stage 1: parse U, apply it, continue objects at a finer scale
                    views   ViewSynthesizer   stage 4

An adapter for a downloaded model replaces one of them and keeps the rest.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from wzviewer.core.camera import Camera
from wzviewer.core.types import BoolArray, ByteArray, FloatArray
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.worker.models.builtin.depth.estimator import DepthReading
from wzviewer.worker.models.builtin.detail.describe import Context
from wzviewer.worker.models.builtin.detail.synthesizer import Detail
from wzviewer.worker.models.builtin.objects.editor import Edit, EditResult, Placement, Support
from wzviewer.worker.models.builtin.views.synthesizer import Completion

Check = Callable[[], None]
Region = tuple[float, float, float, float]


class DepthEstimator(Protocol):
    """Depth and sky of a single picture."""

    def read(self, image: FloatArray) -> DepthReading:
        """Returns disparity and sky of an image (h, w, 3) float32 in [0, 1]."""


class SuperResolver(Protocol):
    """Describes a picture (S) and makes a closer one of a region of it (I')."""

    def describe(self, image: FloatArray, parent: Context | None, detail: Detail | None) -> Context:
        """Returns S of an image."""

    def preview(
        self,
        observation: FloatArray,
        width: int,
        height: int,
        context: Context,
        region: Region,
        seed: int,
        level: int,
    ) -> FloatArray:
        """Returns a quick (height, width, 3) image."""

    def upscale(
        self,
        observation: FloatArray,
        width: int,
        height: int,
        context: Context,
        region: Region,
        level: int,
        seed: int,
        material: str | None = None,
        check: Check | None = None,
    ) -> Detail:
        """Returns the new-scale image; shrunk, it is the observation to within 40 dB."""


class ImageEditor(Protocol):
    """Changes an image as a prompt says."""

    def vocabulary(self) -> Vocabulary:
        """Returns the words of prompts that it knows; empty when it takes any."""

    def parse(self, prompt: str) -> Edit:
        """Understands a prompt, or raises `errors.PromptError` with the words that are known."""

    def insertion(self, cutout: ByteArray, name: str) -> Edit:
        """Returns the edit that puts a picture (h, w, 4) uint8 in; `errors.PromptError` if it is none."""

    def preview(
        self, edit: Edit, image: FloatArray, geometry: Support, seed: int, check: Check | None = None
    ) -> EditResult:
        """Does `apply` quickly and more softly, at the same places."""

    def apply(
        self,
        edit: Edit,
        image: FloatArray,
        geometry: Support,
        seed: int,
        check: Check | None = None,
        *,
        ground: FloatArray | None = None,
        older: FloatArray | None = None,
    ) -> EditResult:
        """Returns the edited image and the geometry of what is new in it.

        `ground` (h, w, 3) has no older objects; `older` (h, w) is what they cover of the image.
        """

    def continue_into(
        self,
        placements: tuple[Placement, ...],
        mapping: tuple[float, float, float],
        image: FloatArray,
        geometry: Support,
        seed: int,
        check: Check | None = None,
        parent_factor: float = 8.0,
        ground: FloatArray | None = None,
    ) -> EditResult | None:
        """Draws objects of a coarser level again, finer; None when none is in view."""


class ViewSynthesizer(Protocol):
    """Completes a picture with depth by what neighbouring cameras see."""

    def complete(
        self,
        image: FloatArray,
        relief: FloatArray,
        sky: BoolArray | None,
        camera: Camera,
        outside: bool,
        angle_deg: float = 12.0,
        seed: int | None = None,
        check: Check | None = None,
    ) -> Completion:
        """Returns the picture's relief with clean edges, and layers behind and beside it."""


@dataclass(frozen=True)
class Synthesizer:
    """The models of one run.

    Attributes:
        name: what provenance calls it.
        warm_up: loads and compiles everything in small steps, for as long as its argument says so.
    """

    name: str
    depth: DepthEstimator
    detail: SuperResolver
    editor: ImageEditor
    views: ViewSynthesizer
    warm_up: Callable[[Callable[[], bool]], None]
