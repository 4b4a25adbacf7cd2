"""The built-in ImageEditor (Sec. 3.2): objects from the prompt into I', with exact relief and mask.

``parse`` refuses at once what it does not know; ``apply`` inserts; ``continue_into`` marches the same
objects again where a deeper level looks at them, so that the zoom shows finer structure.
"""

from dataclasses import replace

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.core.vocabulary import Vocabulary
from wzviewer.worker.models.builtin.objects import cutout, grammar
from wzviewer.worker.models.builtin.objects.deeper import march_again
from wzviewer.worker.models.builtin.objects.dew import redrawn
from wzviewer.worker.models.builtin.objects.grammar import Change, Edit, Request
from wzviewer.worker.models.builtin.objects.inserting import Check, insert
from wzviewer.worker.models.builtin.objects.lighting import Light
from wzviewer.worker.models.builtin.objects.placed import EditResult, Placement, dew_of, unchanged
from wzviewer.worker.models.builtin.objects.placement import Support
from wzviewer.worker.models.builtin.objects.places import Spot, View, cover_of, spots
from wzviewer.worker.models.builtin.objects.sizes import metres_at, share_of
from wzviewer.worker.models.builtin.objects.weather import changed_by, dew_on
from wzviewer.worker.models.builtin.objects.words import SMALL

__all__ = ["Edit", "EditResult", "Light", "ObjectEditor", "Placement", "Request", "Support"]


class ObjectEditor:
    """Inserts objects named by a prompt; needs no weights."""

    @staticmethod
    def parse(prompt: str) -> Edit:
        """Parses a prompt; see `grammar.parse`.

        Raises:
            PromptError: at once, for what it does not know.
        """
        return grammar.parse(prompt)

    @staticmethod
    def insertion(pixels: ByteArray, name: str) -> Edit:
        """Returns the edit that puts a cut-out in.

        Raises:
            PromptError: when it is malformed, or nothing of it is opaque.
        """
        return Edit(name, (Request("image", pixels=cutout.prepared(pixels, name)),))

    @staticmethod
    def vocabulary() -> Vocabulary:
        """Returns the words that `parse` knows."""
        return grammar.vocabulary()

    def warm_up(self) -> None:
        """Compiles the kernels (under a minute, once a machine; later read from disk in a second)."""
        image = np.full((24, 32, 3), 0.5, np.float32)
        support = Support(np.zeros((24, 32), np.float32), 1024.0)
        self.apply(grammar.parse("a ladybug"), image, support, 0)

    def apply(
        self,
        edit: Edit,
        image: FloatArray,
        geometry: Support,
        seed: int,
        check: Check = None,
        light: Light | None = None,
        ground: FloatArray | None = None,
        *,
        older: FloatArray | None = None,
        apart: bool = True,
    ) -> EditResult:
        """Inserts the objects of an edit, one after the other, then changes the whole picture.

        Args:
            edit: from `parse`.
            image: (h, w, 3) float32 sRGB 0..1, I'.
            geometry: the support's relief, focal length and rays.
            seed: of shapes, poses and grain; the same seed gives the same bytes.
            check: called several times a second; what it raises stops the work.
            light: the photograph's light; read from `image` if None.
            ground: (h, w, 3) what is behind the objects that `image` shows already; None if it shows none.
            older: (h, w) float32, coverage by those objects; None if it shows none.
            apart: whether to take the objects apart into `EditResult.parts`.

        Raises:
            whatever `check` raises.
        """
        result = replace(unchanged(image, ground), older=older)
        h, w = image.shape[0], image.shape[1]
        view = View.of(image, geometry)
        told: list[dict[str, object]] = []
        number = 0
        for request in edit.objects:
            where, found = _spots(request, view, geometry, (h, w), seed)
            if request.place:
                told.append({"object": request.name, "place": " ".join(request.place), "found": found})
            for centre, width in where:
                if check is not None:
                    check()
                result = insert(
                    request,
                    result,
                    geometry,
                    centre,
                    width,
                    (seed * 1009 + 31 * number) & 0x7FFFFFFF,
                    light,
                    check,
                    cover_of(request.place, view, (h, w)) if request.submerged else None,
                    apart=apart,
                )
                number += 1
        if edit.changes:
            if check is not None:
                check()
            relief = np.where(result.object_mask, result.object_relief, geometry.relief)
            for k, change in enumerate(edit.changes):
                result = _weathered(result, change, relief, seed + 13 * k)
        return replace(result, places=tuple(told))

    def preview(
        self,
        edit: Edit,
        image: FloatArray,
        geometry: Support,
        seed: int,
        check: Check = None,
        light: Light | None = None,
    ) -> EditResult:
        """Does `apply` at a third of the resolution; the result has the full size, softer."""
        h, w = image.shape[:2]
        small = (max(w // 3, 16), max(h // 3, 16))
        factor = small[0] / w
        relief = cv2.resize(geometry.relief, small, interpolation=cv2.INTER_NEAREST) * np.float32(factor)
        sky = geometry.sky
        if sky is not None:
            sky = cv2.resize(sky.astype(np.uint8), small, interpolation=cv2.INTER_NEAREST) > 0
        metres = geometry.metres_per_px
        metres = None if metres is None else metres / np.float32(factor)
        support = Support(relief, geometry.focal_px * factor, geometry.ray_x, geometry.ray_y, sky, metres)
        thumb = cv2.resize(image, small, interpolation=cv2.INTER_AREA)
        return _enlarged(self.apply(edit, thumb, support, seed, check, light, apart=False), thumb, image)

    def continue_into(
        self,
        placements: tuple[Placement, ...],
        mapping: tuple[float, float, float],
        image: FloatArray,
        geometry: Support,
        seed: int,
        check: Check = None,
        parent_factor: float = 8.0,
        ground: FloatArray | None = None,
    ) -> EditResult | None:
        """Marches an ancestor's objects again where this deeper image looks at them.

        Args:
            placements: of the ancestor level.
            mapping: (x0, y0, factor): pixel p of the ancestor is (p - (x0, y0)) * factor here.
            image: (h, w, 3) this level's picture, which shows the ancestor's objects enlarged.
            geometry: this level's support, registered to the ancestor's rendered depth.
            seed: of the grain.
            check: as in `apply`.
            parent_factor: how much finer this image is than its own parent's.
            ground: as in `apply`.

        Returns:
            the picture with the objects finer; None if none is in view.
        """
        result, again = unchanged(image, ground), False
        for k, placed in enumerate(placements):
            if placed.name == "dew":
                drops = np.asarray(placed.drops, np.float64).reshape(-1, 5)
                picture = redrawn(result.image, drops, placed.light.direction, mapping, parent_factor)
                result, again = (result, again) if picture is None else (replace(result, image=picture), True)
            if placed.name in ("image", "dew"):
                continue
            finer = march_again(placed, mapping, result, geometry, seed + k, check, parent_factor)
            result = finer if finer is not None else result
        return result if again or result.object_mask.any() else None


def _weathered(result: EditResult, change: Change, relief: FloatArray, seed: int) -> EditResult:
    """Applies one change; of dew the drops are kept, to be drawn again at deeper levels."""
    image = changed_by(change, result.image, relief, seed)
    ground = None if result.ground is None else changed_by(change, result.ground, relief, seed)
    moved = image - result.image
    parts = tuple(part.shifted(moved) for part in result.parts)
    flanks = tuple(flank.shifted(moved) for flank in result.flanks)
    kept = result.placements
    if change.name == "dew":
        dew = dew_on(result.image, relief, change.amount, seed)
        kept = (*kept, dew_of(dew.drops, dew.light))
    return replace(result, image=image, placements=kept, ground=ground, parts=parts, flanks=flanks)


def _spots(
    request: Request, view: View, geometry: Support, shape: tuple[int, int], seed: int
) -> tuple[list[Spot], bool]:
    """Returns (centre px, width px) of each copy, and whether the place of the prompt was found."""
    h, w = shape
    centre = (w * (0.5 + request.offset[0]), h * (0.5 + request.offset[1]))
    usual = request.size * w * request.count**-0.5

    def natural(x: float, y: float) -> float:
        metres = metres_at(geometry.metres_per_px, shape, x, y)
        return min(share_of(request.name, request.size, metres, shape) * w, usual)

    width = natural(*centre)
    if request.count == 1 and request.hovers and not request.place:
        return [(centre, width)], False
    fits = (request.name in SMALL and not request.sized) or request.submerged
    found, known = spots(
        request.place,
        request.relation,
        centre,
        width,
        view,
        shape,
        count=request.count,
        usual_px=usual if fits else None,
        seed=seed,
    )
    if fits and known:  # a flower or a leaf says how large an insect is
        return found, known
    return [(at, min(body * natural(*at) / width, usual)) for at, body in found], known


def _enlarged(small: EditResult, thumb: FloatArray, image: FloatArray) -> EditResult:
    """Brings a third-size result to full size: the image keeps its own detail where nothing changed."""
    size = (image.shape[1], image.shape[0])
    factor = np.float32(image.shape[1] / thumb.shape[1])
    change = cv2.resize(small.image - thumb, size, interpolation=cv2.INTER_LINEAR)
    alpha = cv2.resize(small.alpha, size, interpolation=cv2.INTER_LINEAR)
    inside = cv2.resize(small.image, size, interpolation=cv2.INTER_CUBIC)
    picture = alpha[..., None] * inside + (1 - alpha[..., None]) * (image + change)
    relief = cv2.resize(small.object_relief, size, interpolation=cv2.INTER_NEAREST) * factor
    mask = np.isfinite(relief)
    shadow = cv2.resize(small.shadow, size, interpolation=cv2.INTER_LINEAR)
    picture = np.clip(picture, 0, 1).astype(np.float32)
    return EditResult(picture, relief, mask, alpha, shadow, small.placements, small.places)
