"""What an edit leaves behind: the picture, its objects' geometry, and how each can be marched again."""

from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from wzviewer.core.types import BoolArray, DoubleArray, FloatArray
from wzviewer.worker.models.builtin.objects.bodies import Tint
from wzviewer.worker.models.builtin.objects.lighting import Light
from wzviewer.worker.models.builtin.objects.parts import Flanks, Part
from wzviewer.worker.models.builtin.objects.placement import Plane
from wzviewer.worker.models.builtin.objects.pose import Pose

_COVERED, _SHEER = 0.5, 0.12  # least coverage of a pixel that is the body's, and of one in its sheets


@dataclass(frozen=True, eq=False)
class Placement:
    """One inserted object: enough to march it again at any deeper level.

    Attributes:
        name: a key of `nouns.BUILDERS`, or "image".
        seed: of its shape.
        tint: its colour words.
        pose: in the image it was inserted into.
        lift: what is added to its marched relief, a plane in that image.
        light: the photograph's light there.
        bounce: (r, g, b) linear light from the support.
        width_px: its picture's width there.
        water: (r, g, b) linear colour of the water that it is under; None in air.
        drops: of dew (name "dew"): (x, y, radius, flattening, turn) of each drop, px and radians.
        chroma: how much of its chroma it kept in that picture.
    """

    name: str
    seed: int
    tint: Tint
    pose: Pose
    lift: Plane
    light: Light
    bounce: tuple[float, float, float]
    width_px: float
    water: tuple[float, float, float] | None = None
    drops: tuple[tuple[float, ...], ...] = ()
    chroma: float = 1.0

    def to_dict(self) -> dict[str, object]:
        """Returns a JSON-able form."""
        pose, lift = self.pose, self.lift
        return {
            "name": self.name,
            "seed": self.seed,
            "tint": {
                "color": self.tint.color,
                "pattern": self.tint.pattern,
                "substance": self.tint.substance,
            },
            "pose": {
                "camera_from_object": pose.camera_from_object.tolist(),
                "size_px": pose.size_px,
                "position": list(pose.position),
                "ray": list(pose.ray),
            },
            "lift": [lift.x0, lift.y0, lift.at, lift.slope_x, lift.slope_y],
            "light": self.light.to_dict(),
            "bounce": list(self.bounce),
            "width_px": self.width_px,
            "water": self.water,
            "chroma": self.chroma,
            "drops": [[round(v, 4) for v in drop] for drop in self.drops],
        }

    @classmethod
    def from_dict(cls, data: dict[str, object]) -> "Placement":
        """Returns the placement that `to_dict` wrote."""
        pose, tint = data["pose"], data["tint"]
        assert isinstance(pose, dict)
        assert isinstance(tint, dict)
        color = tuple(tint["color"]) if tint["color"] is not None else None
        rotation = np.asarray(pose["camera_from_object"], np.float64)
        return cls(
            name=str(data["name"]),
            seed=int(data["seed"]),  # type: ignore[call-overload]
            tint=Tint(color, tint["pattern"], tint["substance"]),  # type: ignore[arg-type]
            pose=Pose(rotation, pose["size_px"], tuple(pose["position"]), tuple(pose["ray"])),
            # type: ignore[arg-type]
            lift=Plane(*data["lift"]),  # type: ignore[misc]
            light=Light.from_dict(data["light"]),  # type: ignore[arg-type]
            bounce=tuple(data["bounce"]),  # type: ignore[arg-type]
            width_px=float(data["width_px"]),  # type: ignore[arg-type]
            water=tuple(data["water"]) if data.get("water") else None,  # type: ignore[arg-type]
            chroma=float(data.get("chroma", 1.0)),  # type: ignore[arg-type]
            drops=tuple(tuple(drop) for drop in data.get("drops", ())),  # type: ignore[attr-defined]
        )


@dataclass(frozen=True, eq=False)
class EditResult:
    """A picture with objects in it.

    Attributes:
        image: (h, w, 3) float32 sRGB 0..1, the composite I.
        object_relief: (h, w) float32 native px, relative to the anchor of the support; nan outside.
        object_mask: (h, w) bool, where an object is in front.
        alpha: (h, w) float32 coverage by objects.
        shadow: (h, w) float32, share of its light that the support keeps; 1 is none lost.
        placements: one for each object, JSON-able by `to_dict`.
        places: for each place of the prompt {"object", "place", "found"}.
        ground: (h, w, 3) float32 sRGB, the picture in the objects' shadow and without them.
        parts: of all objects, farther ones of each first.
        flanks: what the view does not see of them.
        older: (h, w) float32, coverage by objects that the picture showed before; None for none.
    """

    image: FloatArray
    object_relief: FloatArray
    object_mask: BoolArray
    alpha: FloatArray
    shadow: FloatArray
    placements: tuple[Placement, ...] = field(default=())
    places: tuple[dict[str, object], ...] = field(default=())
    ground: FloatArray | None = None
    parts: tuple[Part, ...] = ()
    flanks: tuple[Flanks, ...] = ()
    older: FloatArray | None = None

    @property
    def others(self) -> FloatArray:
        """Coverage (h, w) by all objects, older ones too."""
        return self.alpha if self.older is None else np.maximum(self.alpha, self.older)

    @property
    def bare(self) -> FloatArray:
        """The ground; the picture itself where there are no objects."""
        return self.image if self.ground is None else self.ground


def held(alpha: FloatArray, relief: FloatArray) -> BoolArray:
    """Tells which pixels (h, w) lie at the depth of a body: the covered ones, and those of its sheer sheets.

    A wing that lets most light through moves as a whole; left at the depth of what is behind it, its
    tint would stay there like a ghost.  A soft outline and single hairs are no sheets.

    Args:
        alpha: (h, w) coverage by the body.
        relief: (h, w) float32, nan where no ray met it.
    """
    covered, window = alpha >= _COVERED, np.ones((5, 5), np.uint8)
    sheer = (alpha >= _SHEER) & ~covered
    wide = cv2.morphologyEx(sheer.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    sheets = cv2.dilate(wide, window) > 0
    return np.asarray((covered | (sheets & sheer)) & np.isfinite(relief))


def dew_of(drops: DoubleArray, light: Light) -> Placement:
    """Returns dew as something to draw again: it has places, sizes and a light, and no body."""
    still = Pose(np.eye(3), 1.0, (0.0, 0.0, 0.0))
    flat = Plane(0.0, 0.0, 0.0, 0.0, 0.0)
    kept = tuple(tuple(float(v) for v in drop) for drop in drops)
    return Placement("dew", 0, Tint(), still, flat, light, (0.0, 0.0, 0.0), 0.0, drops=kept)


def unchanged(image: FloatArray, ground: FloatArray | None = None) -> EditResult:
    """Returns a picture without new objects; `ground` is what is behind those it shows already."""
    shape = image.shape[:2]
    nothing = np.full(shape, np.nan, np.float32)
    return EditResult(
        image.astype(np.float32),
        nothing,
        np.zeros(shape, bool),
        np.zeros(shape, np.float32),
        np.ones(shape, np.float32),
        ground=ground,
    )


def merged(
    result: EditResult,
    picture: FloatArray,
    relief: FloatArray,
    mask: BoolArray,
    alpha: FloatArray,
    gain: FloatArray,
    placed: Placement,
    ground: FloatArray,
    dismantled: tuple[tuple[Part, ...], tuple[Flanks, ...]],
) -> EditResult:
    """Returns a result with one more object, in front of the others."""
    return EditResult(
        picture,
        np.where(mask, relief, result.object_relief).astype(np.float32),
        result.object_mask | mask,
        np.maximum(result.alpha, alpha),
        (result.shadow * gain).astype(np.float32),
        (*result.placements, placed),
        result.places,
        ground,
        (*result.parts, *dismantled[0]),
        (*result.flanks, *dismantled[1]),
        result.older,
    )


def shifted(placed: Placement, shift: float) -> Placement:
    """Returns a placement moved along the rays by native px."""
    lift = placed.lift
    moved = Plane(lift.x0, lift.y0, lift.at + shift, lift.slope_x, lift.slope_y)
    return replace(placed, lift=moved)
