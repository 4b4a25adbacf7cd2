"""The public face: describes a picture, and makes the picture of a region of it eight times closer."""

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from wzviewer.core.types import ByteArray, FloatArray
from wzviewer.errors import WorkerError
from wzviewer.worker.models.builtin.detail.amplitude import (
    NATURAL,
    glossy,
    hems,
    sigma_map,
)
from wzviewer.worker.models.builtin.detail.consistency import (
    REQUIRED_DB,
    brought_near,
    consistency_db,
    projected,
)
from wzviewer.worker.models.builtin.detail.contours import CUT, supposed, with_steeper
from wzviewer.worker.models.builtin.detail.crisp import BaseUpscaler, NetworkBase
from wzviewer.worker.models.builtin.detail.describe import Context, cropped_labels, described, inherited
from wzviewer.worker.models.builtin.detail.flow import GRAINS
from wzviewer.worker.models.builtin.detail.library import TileLibrary
from wzviewer.worker.models.builtin.detail.materials import material_of_words, per_label
from wzviewer.worker.models.builtin.detail.measures import (
    enlarged,
    luma,
    orientation,
    ramp,
    resized,
    stretched,
)
from wzviewer.worker.models.builtin.detail.overlay import film_grain, multiplied, roughened, with_detail
from wzviewer.worker.models.builtin.detail.quiet import without_noise
from wzviewer.worker.models.builtin.detail.seams import (
    bare,
    faded_border,
    most_in_light,
    unevenness,
    with_seams,
    without_leaves_on_grass,
    without_strands_on_gloss,
)
from wzviewer.worker.models.builtin.detail.strokes import in_strokes
from wzviewer.worker.models.builtin.detail.strokes import warm_up as warm_up_strokes
from wzviewer.worker.models.builtin.detail.tables import (
    floor_table,
    grain_table,
    regional_table,
    tints_table,
    wood_table,
)
from wzviewer.worker.models.builtin.detail.texture import (
    Layout,
    coarse_forms,
    layout,
    painted_texture,
    shares_by_name,
    shrunk,
)

Fractions = tuple[float, float, float, float]
"""``(x0, y0, x1, y1)`` of a region, as fractions of its image."""

TINT_REACHES = dict.fromkeys(NATURAL, 12.0) | dict.fromkeys(("petal", "floret"), 35.0)
"""In CIELAB; the leaves of one tree differ by less, a petal's tip from its base by nearly as much."""
LEAST_DB = 42.0  # between a photograph with its noise and the new image, which has its own
STROKED = 0.75
"""Less texture lies on what strokes already draw."""
COLOURED = frozenset({"foliage", "straw", "venation", "petal", "floret"})


@dataclass(frozen=True)
class Detail:
    """The picture of a region, closer.

    Attributes:
        image: ``(H, W, 3)`` f32 in 0..1.
        relief_texture: ``(H, W)`` f32, the invented detail as height, in luminance: + is raised.
        labels: ``(H, W)`` u8, index into `names`.
        names: material name per label, as it is seen in this image.
        consistency_db: PSNR of the image, shrunk by area, against the observation.
    """

    image: FloatArray
    relief_texture: FloatArray
    labels: ByteArray
    names: tuple[str, ...]
    consistency_db: float


@dataclass(frozen=True)
class _Job:
    observation: FloatArray  # (h, w, 3) grey levels, without the photograph's noise
    noisy: FloatArray  # the same as it was given
    width: int
    height: int
    doublings: int
    labels: ByteArray  # (h, w)
    names: tuple[str, ...]
    level: int
    prompted: bool
    regional_sigma: FloatArray  # per name
    wood: FloatArray  # per name, 1 or 0
    tints: FloatArray  # (names, 2): a* and b* of the regions
    grain_rms: FloatArray  # per name, in grey levels
    seeds: tuple[int, ...]
    stride: int
    check: Callable[[], None]

    @property
    def work_size(self) -> tuple[int, int]:
        """Width and height that a whole number of doublings reaches."""
        height, width = self.observation.shape[:2]
        return width << self.doublings, height << self.doublings


class DetailSynthesizer:
    """The built-in `SuperResolver` and `SceneDescriber`: its one small network is packaged; deterministic.

    Args:
        seed: of everything random in it.
        base: makes the crisp picture that detail is added to; a network can take the place of the filter.
        library: source of material tiles.
    """

    def __init__(
        self, seed: int = 0, base: BaseUpscaler | None = None, library: TileLibrary | None = None
    ) -> None:
        self._seed = seed
        self._base = base or NetworkBase()
        self._library = library or TileLibrary()

    def warm_up(self) -> None:
        """Compiles the kernels and makes the tiles, so that the first level is as fast as the others."""
        ramp_image = np.tile(np.linspace(0, 1, 32, dtype=np.float32)[None, :, None], (24, 1, 3))
        context = self.describe(ramp_image, None)
        for word in ("fibre", "foliage", "venation", "rock", "plaster"):
            self.upscale(ramp_image, 64, 48, context, (0, 0, 1, 1), 1, 0, material=word)
        warm_up_strokes()

    def describe(
        self, image: FloatArray, parent: Context | None = None, detail: Detail | None = None
    ) -> Context:
        """Returns what is in an image: a label map, a material per label, statistics and words.

        Args:
            image: ``(h, w, 3)`` in 0..1.
            parent: context of the level that the image lies inside; None for a photograph.
            detail: what made the image, if `upscale` did; its labels are then inherited pixel by pixel.
        """
        if parent is not None and detail is not None:
            return inherited(image, parent, detail.labels, detail.names)
        return described(image, parent)

    def preview(
        self,
        observation: FloatArray,
        width: int,
        height: int,
        context: Context,
        region: Fractions,
        seed: int,
        level: int,
        material: str | None = None,
    ) -> FloatArray:
        """Returns a quick ``(height, width, 3)`` picture in 0..1; arguments as of `upscale`."""
        half_width, half_height = (
            max(width // 2, observation.shape[1]),
            max(height // 2, observation.shape[0]),
        )
        job = self._job(observation, half_width, half_height, context, region, level, seed, material, None)
        small, _, _ = self._made(replace(job, stride=2))
        small = brought_near(projected(small, job.observation), job.noisy, LEAST_DB)
        image = enlarged(small, width, height)
        return np.clip(image, 0, 255) * np.float32(1 / 255)

    def upscale(
        self,
        observation: FloatArray,
        width: int,
        height: int,
        context: Context,
        region: Fractions,
        level: int,
        seed: int,
        material: str | None = None,
        check: Callable[[], None] | None = None,
    ) -> Detail:
        """Returns the observation enlarged, with crisp contours and the detail of its materials.

        Args:
            observation: ``(h, w, 3)`` in 0..1, what is known: the area-downsampled coarse picture.
            width: of the result in px; at least that of the observation.
            height: of the result in px.
            context: of the parent's image.
            region: of the parent's image that the observation shows.
            level: of the new image; 1 is the first zoom.
            seed: of this level.
            material: words that name a material for the whole region; words that name none change nothing.
            check: called between the steps; whatever it raises ends the work.

        Raises:
            ValueError: the observation is not ``(h, w, 3)`` or the result would be smaller than it.
            WorkerError: the result contradicts the observation at a whole factor, which cannot be.
        """
        job = self._job(observation, width, height, context, region, level, seed, material, check)
        image, relief, labels = self._made(job)
        image = brought_near(projected(image, job.observation), job.noisy, LEAST_DB)
        db = _promised(consistency_db(image, job.noisy), job)
        return Detail(image * np.float32(1 / 255), relief * np.float32(1 / 255), labels, job.names, db)

    def _job(
        self,
        observation: FloatArray,
        width: int,
        height: int,
        context: Context,
        region: Fractions,
        level: int,
        seed: int,
        material: str | None,
        check: Callable[[], None] | None,
    ) -> _Job:
        if observation.ndim != 3 or observation.shape[2] != 3:
            raise ValueError(f"the observation is {observation.shape}, not (h, w, 3)")
        rows, columns = observation.shape[:2]
        if width < columns or height < rows:
            raise ValueError(
                f"the result, {width}x{height}, is smaller than the observation, {columns}x{rows}"
            )
        grey = np.ascontiguousarray(np.clip(np.nan_to_num(observation), 0, 1), np.float32) * np.float32(255)
        labels = cropped_labels(context, region, columns, rows)
        names, prompted = context.materials, material_of_words(material) if material else None
        if prompted is not None:
            labels, names = np.zeros_like(labels), (prompted.name,)
        elif level <= 1:
            labels, names = without_strands_on_gloss(grey, labels, names)
            labels, names = without_leaves_on_grass(grey, labels, names)
        else:
            labels, names = with_seams(grey, labels, names)
        place = [round(1e6 * value) & 0xFFFFFFFF for value in region]
        seeds = (self._seed & 0xFFFFFFFF, seed & 0xFFFFFFFF, level & 0xFFFFFFFF, *place)
        if level > 1:  # or every photograph had the same atoms in its middle
            seeds = (*seeds, zlib.crc32(np.round(grey).astype(np.uint8).tobytes()))
        return _Job(
            observation=grey if level > 1 else without_noise(grey, labels, names, context),
            noisy=grey,
            width=width,
            height=height,
            doublings=doublings_for(max(width / columns, height / rows)),
            labels=labels,
            names=names,
            level=level,
            prompted=prompted is not None,
            regional_sigma=regional_table(context, names, level),
            wood=wood_table(context, names),
            tints=tints_table(context, names),
            grain_rms=grain_table(context, names, level),
            seeds=seeds,
            stride=1,
            check=check or (lambda: None),
        )

    def _made(self, job: _Job) -> tuple[FloatArray, FloatArray, ByteArray]:
        """Returns image and relief in grey levels, and labels, at the job's size but not yet projected."""
        seen, is_deep = job.observation, job.level > 1
        known = supposed(seen, job.labels, job.names) if is_deep else seen
        base = self._base(known, job.doublings, job.level)
        job.check()
        place = layout(job.labels, base)
        cut = np.array([name in CUT for name in job.names], np.float32)
        if not is_deep and cut[list(place.shares)].any():
            base = with_steeper(base, seen, _spread(place, cut))
        texture = painted_texture(place, job.names, seen, self._library, job.seeds, job.stride, is_deep)
        job.check()
        base = roughened(base, texture, _roughness(job, place))
        coarse = shrunk(place, seen.shape[1], seen.shape[0])
        forms = self._forms(job, coarse)
        detail = texture * self._sigma(job, place, coarse, forms)
        if is_deep and not job.prompted:
            painting = in_strokes(base, seen, shares_by_name(coarse, job.names), job.seeds)
            base, detail = painting.image, detail * (1 - STROKED * painting.cover)
        if is_deep:
            detail = multiplied(detail, luma(base))
        image = with_detail(base, detail, job.observation, job.level, _light_share(job, place), forms)
        if job.grain_rms.any():
            grain = film_grain(luma(image), job.seeds) * _spread_or_one(place, job.grain_rms)
            image += grain[..., None]
        job.check()
        size = (job.width, job.height)
        labels = cv2.resize(place.labels, size, interpolation=cv2.INTER_NEAREST)
        return resized(image, *size), resized(detail, *size), labels

    def _forms(self, job: _Job, coarse: Layout) -> FloatArray | None:
        """Returns the forms, in deviations, of what has none of its own; a photograph has them."""
        if job.level <= 1:
            return None
        return coarse_forms(coarse, job.names, job.observation, self._library, job.seeds) * bare(
            luma(job.observation)
        )

    def _sigma(self, job: _Job, place: Layout, coarse: Layout, forms: FloatArray | None) -> FloatArray:
        height, width = job.observation.shape[:2]
        floors = floor_table(job.names, job.level, job.prompted)
        gains = per_label(job.names, "gain")
        micros, ceilings = (per_label(job.names, name) for name in ("micro", "ceiling"))
        tables = (gains, floors, micros, ceilings, job.regional_sigma, job.wood)
        gain, floor, micro, ceiling, regional, wood = (_spread(coarse, table) for table in tables)
        plane, truthful = luma(job.observation), job.level <= 1 and not job.prompted
        sharp_gain = _spread(place, gains) / np.maximum(stretched(gain, *job.work_size), 1e-3)
        sigma = sigma_map(plane, gain, floor, micro, ceiling, regional, wood, truthful)
        if truthful:  # no strands over an eye or nose
            strands = np.array([name in GRAINS for name in job.names], np.float32)
            if strands[list(coarse.shares)].any():
                sigma *= 1 - _spread(coarse, strands) * glossy(plane)
            sigma *= self._belonging(job, coarse)
        elif job.level > 1:
            uneven = unevenness(plane, job.seeds, forms) * faded_border(width, height)
            sigma = np.minimum(sigma * uneven, most_in_light(job.observation))
        return stretched(sigma, *job.work_size) * np.clip(sharp_gain, 0.3, 1.5)

    @staticmethod
    def _belonging(job: _Job, coarse: Layout) -> FloatArray:
        """How far what grew has the colour of its region: no leaves on the white petal beside them.

        In the shade colours say little; there all of the region belongs to it.
        """
        grew, natural = (
            np.array([name in known for name in job.names], np.float32) for known in (TINT_REACHES, NATURAL)
        )
        if not grew[list(coarse.shares)].any():
            return np.ones(coarse.labels.shape, np.float32)
        lab = cv2.cvtColor(job.observation * np.float32(1 / 255), cv2.COLOR_RGB2LAB)
        mean = [_spread(coarse, table) for table in job.tints.T]
        away = np.square(lab[..., 1] - mean[0]) + np.square(lab[..., 2] - mean[1])
        away *= ramp(lab[..., 0], 45, 15)
        reaches = np.array([TINT_REACHES.get(name, 100.0) for name in job.names], np.float32)
        own = 1 - _spread(coarse, grew) * (1 - np.exp(-away / np.square(_spread(coarse, reaches))))
        return own * (1 - hems(_spread(coarse, natural), luma(job.observation)))


def _light_share(job: _Job, place: Layout) -> FloatArray | float:
    """What grows has its own colour also where it is lightest."""
    shares = np.array([0.9 if name in COLOURED else 0.5 for name in job.names], np.float32)
    return _spread_or_one(place, shares) if job.level <= 1 else 0.5


def _promised(db: float, job: _Job) -> float:
    """Returns the consistency, which only a broken factor may leave below the promise: see `projected`."""
    rows, columns = job.observation.shape[:2]
    if db < REQUIRED_DB and job.width % columns == 0 and job.height % rows == 0:
        raise WorkerError("new detail", f"it contradicts what was there: {db:.1f} dB")
    return db


def doublings_for(factor: float) -> int:
    """Returns how many doublings to work with; up to a fifth more is left to plain resampling.

    Example:
        >>> [doublings_for(factor) for factor in (1.5, 2, 4, 8, 9, 12, 16)]
        [1, 1, 2, 3, 3, 4, 4]
    """
    return max(1, math.ceil(math.log2(max(factor, 1.0) / 1.2)))


def _roughness(job: _Job, place: Layout) -> FloatArray:
    """Straight outlines stay straight: coherent edges are displaced the least.

    Deeper nothing is straight but the grid of coarser pixels: every contour takes part in the texture.
    """
    factor = np.float32(job.work_size[0] / job.observation.shape[1] / 8)
    own = _spread(place, per_label(job.names, "roughness_px")) * factor
    if job.level > 2 and not job.prompted:
        return own
    plane = luma(job.observation)
    field = orientation(plane, 1.0, 2.0)
    straight = ramp(field.coherence, 0.35, 0.3) * ramp(field.strength, 1.0, 3.0)
    straight = cv2.dilate(straight, np.ones((3, 3), np.uint8))
    return own * (1 - np.float32(0.95) * stretched(straight, *job.work_size))


def _spread(place: Layout, values: FloatArray) -> FloatArray:
    total = np.zeros(place.labels.shape, np.float32)
    for label, share in place.shares.items():
        total += values[label] * share
    return total


def _spread_or_one(place: Layout, values: FloatArray) -> FloatArray | float:
    """Returns the values spread, or the one value that all labels of the place have, which takes no time."""
    found = values[list(place.shares)]
    return float(found[0]) if np.ptp(found) == 0 else _spread(place, values)
