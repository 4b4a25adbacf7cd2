"""What a run of the generator is asked to do; each default cites the paper or a measurement."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wzviewer.core.constants import ZOOM_FACTOR
from wzviewer.errors import InputError

MAX_SCRIPT_BYTES = 1 << 20
FACTOR_RANGE = (1.0, 64.0)  # above, a level would have to be invented whole
EXTENSION_FACTOR = 1.5  # a smaller one adds no detail: it continues the picture beyond its border
EXTENSION_REACH = 0.75  # of the image, beyond it: where the centre of an extension may be


@dataclass(frozen=True)
class Zoom:
    """One step of a zoom sequence: C_{i+1} relative to its parent's image, and U_{i+1}.

    Attributes:
        x: centre as a fraction of the parent's image width, [0, 1], to the right.
        y: centre as a fraction of the parent's image height, [0, 1], downwards.
        factor: magnification; the paper's is 8.  Below 1.5 the picture is extended, and the centre may
            lie outside of it.
        prompt: U, perhaps empty.
        parent: level to zoom into; None is the one made last.
    """

    x: float
    y: float
    factor: float = ZOOM_FACTOR
    prompt: str = ""
    parent: int | None = None

    def __post_init__(self) -> None:
        reach = EXTENSION_REACH if self.factor < EXTENSION_FACTOR else 0.0
        if not all(-reach <= at <= 1.0 + reach for at in (self.x, self.y)):
            why = "the centre must be fractions between 0 and 1 (an extension, factor 1: -0.75 to 1.75)"
            raise InputError(f"--zoom {self.x:g},{self.y:g}", why, "For example --zoom .5,.6")
        low, high = FACTOR_RANGE
        if not low <= self.factor <= high:
            what = f"--zoom {self.x:g},{self.y:g},{self.factor:g}"
            raise InputError(what, f"the factor must be between {low:g} and {high:g}", "The default is 8.")


@dataclass(frozen=True)
class Generation:
    """A whole scene: the photo and its zooms."""

    image: Path
    zooms: tuple[Zoom, ...] = field(default_factory=tuple)
    seed: int = 0
    synthesizer: str = "builtin"
    size: tuple[int, int] | None = None


def parse_zoom(text: str) -> Zoom:
    """Parses ``X,Y`` or ``X,Y,FACTOR``.

    Raises:
        InputError: when it is malformed or out of range.
    """
    try:
        values = [float(v) for v in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (2, 3) or any(v != v for v in values):
        raise InputError(f"--zoom {text}", "must be X,Y or X,Y,FACTOR", "For example --zoom .5,.6")
    x, y, factor = [*values, ZOOM_FACTOR][:3]
    return Zoom(x, y, factor)


def parse_size(text: str) -> tuple[int, int]:
    """Parses ``WxH``.

    Raises:
        InputError: when it is malformed or out of range.
    """
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(p.isdigit() for p in parts):
        raise InputError(f"--size {text}", "must be WxH", "For example --size 1088x720")
    width, height = int(parts[0]), int(parts[1])
    if not (16 <= width <= 8192 and 16 <= height <= 8192):
        raise InputError(f"--size {text}", "each side must be between 16 and 8192 px")
    return width, height


def read_script(path: Path) -> dict[str, Any]:
    """Reads a TOML script: ``image``, ``seed``, ``[[zoom]] at, factor, prompt, parent``.

    Returns:
        Keyword arguments of `Generation`, except those that the script leaves out.

    Raises:
        InputError: when it is missing, malformed, or holds unknown keys.
    """
    try:
        if path.stat().st_size > MAX_SCRIPT_BYTES:
            raise InputError(str(path), "is too large for a script")
        record = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputError(str(path), (error.strerror or str(error)).lower(), "Check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"is not TOML ({error})") from error
    unknown = set(record) - {"image", "seed", "zoom"}
    if unknown:
        raise InputError(str(path), f"unknown key {sorted(unknown)[0]!r}", "Known: image, seed, zoom.")
    found: dict[str, Any] = {"zooms": tuple(_zoom(path, z) for z in record.get("zoom", []))}
    if "image" in record:
        found["image"] = path.parent / str(record["image"])
    if "seed" in record:
        found["seed"] = int(record["seed"])
    return found


def _zoom(path: Path, record: Any) -> Zoom:  # noqa: ANN401
    try:
        unknown = set(record) - {"at", "factor", "prompt", "parent"}
        if unknown:
            raise InputError(str(path), f"unknown key {sorted(unknown)[0]!r} in a zoom")
        x, y = (float(v) for v in record["at"])
        factor = float(record.get("factor", ZOOM_FACTOR))
        parent = record.get("parent")
        return Zoom(x, y, factor, str(record.get("prompt", "")), None if parent is None else int(parent))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(str(path), "a zoom needs at = [X, Y]") from error
