"""Photographs in and pictures out.  The header is read and capped before a pixel is allocated."""

import os
import struct
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np

from wzviewer.core.types import ByteArray
from wzviewer.errors import InputError, OutputError

MAX_FILE_BYTES = 256 << 20
MAX_PIXELS = 120_000_000
MIN_SIDE_PX = 16
LONG_SIDE_PX = 1088  # of the working image; the paper's
CUTOUT_PX = 1024  # long side of a picture that is put into another
SIDE_MULTIPLE_PX = 8  # so that a x8 crop has whole pixels
FINER_MIN, FINER_MAX = 1.2, 4  # times the working image's size; 4 is 12 megapixels, what a phone takes
FORMATS = "PNG, JPEG or WebP"


def load_photo(path: Path) -> ByteArray:
    """Reads a photograph: upright (EXIF), 8-bit sRGB, transparency over mid grey.

    Returns:
        (h, w, 3) uint8 RGB.

    Raises:
        InputError: when it is missing, a directory, empty, too large, truncated or no image.
    """
    import cv2

    data = _read_bytes(path)
    _check_header(path, data)
    buffer = np.frombuffer(data, np.uint8)
    try:
        image = cv2.imdecode(buffer, cv2.IMREAD_UNCHANGED)
        if image is not None and not _has_alpha(image):
            # Only this mode applies the EXIF orientation.
            image = cv2.imdecode(buffer, cv2.IMREAD_COLOR)
    except cv2.error:
        image = None
    if image is None:
        raise InputError(str(path), "the image is damaged or truncated", "Try to export it again.")
    return _rgb8(image)


def load_cutout(path: Path, long_side_px: int = CUTOUT_PX) -> ByteArray:
    """Reads a picture with its transparency, to be put into another.

    Returns:
        (h, w, 4) uint8 sRGB and alpha, its long side at most ``long_side_px``; opaque where it has none.

    Raises:
        InputError: as `load_photo`.
    """
    import cv2

    data = _read_bytes(path)
    _check_header(path, data)
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None or not _has_alpha(image):
        rgb = load_photo(path)
        rgba = np.dstack([rgb, np.full(rgb.shape[:2], 255, np.uint8)])
    else:
        eight = (image >> 8).astype(np.uint8) if image.dtype == np.uint16 else image
        rgba = cv2.cvtColor(eight, cv2.COLOR_BGRA2RGBA)
    ratio = long_side_px / max(rgba.shape[:2])
    if ratio >= 1.0:
        return np.ascontiguousarray(rgba)
    # Premultiplied: what is transparent has no say in the colour of an edge.
    alpha = rgba[..., 3:].astype(np.float32)
    weighted = np.dstack([rgba[..., :3] * alpha, alpha])
    size = (max(round(rgba.shape[1] * ratio), 1), max(round(rgba.shape[0] * ratio), 1))
    small = cv2.resize(weighted, size, interpolation=cv2.INTER_AREA)
    color = small[..., :3] / np.maximum(small[..., 3:], 1.0)
    return np.ascontiguousarray(np.rint(np.dstack([color, small[..., 3:]])).clip(0, 255).astype(np.uint8))


def fit_photo(image: ByteArray, long_side_px: int = LONG_SIDE_PX) -> ByteArray:
    """Resizes a photo to the working size: long side at most ``long_side_px``, sides whole eighths.

    Returns:
        (h, w, 3) uint8; the aspect is kept to within the rounding, small photos are enlarged to 256 px.
    """
    import cv2

    height, width = image.shape[:2]
    ratio = min(long_side_px / max(height, width), max(1.0, 256 / max(height, width)))
    size = [
        max(SIDE_MULTIPLE_PX * 4, round(s * ratio / SIDE_MULTIPLE_PX) * SIDE_MULTIPLE_PX)
        for s in (width, height)
    ]
    if (width, height) == tuple(size):
        return image
    mode = cv2.INTER_AREA if ratio < 1 else cv2.INTER_CUBIC
    return np.ascontiguousarray(cv2.resize(image, size, interpolation=mode), np.uint8)


def finer_photo(photo: ByteArray, image: ByteArray) -> ByteArray | None:
    """Returns what a photo knows beyond its working image, for the first zooms; None if next to nothing.

    Args:
        photo: (H, W, 3) uint8 as it was read.
        image: (h, w, 3) uint8, the same fitted to the working size.

    Returns:
        (H', W', 3) uint8, at most `FINER_MAX` times as large as the image each way.
    """
    import cv2

    finer = max(photo.shape[:2]) / max(image.shape[:2])
    if finer < FINER_MIN:
        return None
    if finer <= FINER_MAX:
        return photo
    size = (FINER_MAX * image.shape[1], FINER_MAX * image.shape[0])
    return np.ascontiguousarray(cv2.resize(photo, size, interpolation=cv2.INTER_AREA), np.uint8)


def encode_png(image: ByteArray) -> bytes:
    """Encodes (h, w, 3) RGB or (h, w, 4) RGBA uint8 as PNG."""
    import cv2

    code = cv2.COLOR_RGBA2BGRA if image.shape[2] == 4 else cv2.COLOR_RGB2BGR
    ok, data = cv2.imencode(".png", cv2.cvtColor(image, code))
    if not ok:
        raise ValueError("PNG encoder failed")
    return bytes(data)


def decode_png(data: bytes, name: str) -> ByteArray:
    """Decodes a PNG of a scene file to (h, w, 3) uint8.

    Raises:
        InputError: when it is not a PNG of a bearable size.
    """
    import cv2

    size = _png_size(data)
    if size is None or size[0] * size[1] > MAX_PIXELS:
        raise InputError(name, "is not a PNG image of a bearable size")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise InputError(name, "the PNG image is damaged")
    return np.ascontiguousarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB))


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Opens a file that is written whole or not at all: temporary file beside it, fsync, rename.

    Raises:
        OutputError: when the folder is missing or cannot be written.
    """
    temporary: Path | None = None
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        temporary = Path(name)
        with os.fdopen(descriptor, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(0o644)
        temporary.replace(path)
    except OSError as error:
        raise OutputError(str(path), _reason(error), "Choose another folder.") from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Fails early, before minutes of work, when a file cannot be written.

    Raises:
        OutputError: when the folder is missing or cannot be written, or the path is a directory.
    """
    if path.is_dir():
        raise OutputError(str(path), "is a directory", "Give a file name.")
    if not path.parent.is_dir():
        raise OutputError(str(path), "no such folder", "Make it first.")
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise OutputError(str(path), _reason(error), "Choose another folder.") from error


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _read_bytes(path: Path) -> bytes:
    if path.is_dir():
        raise InputError(str(path), "is a directory", f"Give a {FORMATS} file.")
    if not path.is_file():
        raise InputError(str(path), "no such file", "Check the path.")
    try:
        size = path.stat().st_size
        if size == 0:
            raise InputError(str(path), "the file is empty")
        if size > MAX_FILE_BYTES:
            raise InputError(str(path), f"the file has {size >> 20} MiB", f"At most {MAX_FILE_BYTES >> 20}.")
        return path.read_bytes()
    except OSError as error:
        raise InputError(str(path), _reason(error)) from error


def _check_header(path: Path, data: bytes) -> None:
    size = _png_size(data) or _jpeg_size(data) or _webp_size(data)
    if size is None:
        raise InputError(str(path), f"is not a {FORMATS} image")
    width, height = size
    if width * height > MAX_PIXELS:
        raise InputError(
            str(path), f"has {width}x{height} pixels", f"At most {MAX_PIXELS // 10**6} megapixels."
        )
    if min(width, height) < MIN_SIDE_PX:
        raise InputError(str(path), f"has {width}x{height} pixels", f"At least {MIN_SIDE_PX} each way.")
    if max(width, height) > 8 * min(width, height):
        raise InputError(str(path), f"is {width}x{height}, too narrow", "At most 8:1.")


def _png_size(data: bytes) -> tuple[int, int] | None:
    if data[:8] != b"\x89PNG\r\n\x1a\n" or len(data) < 33:
        return None
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    if data[:2] != b"\xff\xd8":
        return None
    at = 2
    while at + 9 < len(data):
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if data[at] != 0xFF:
            return None
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        at += 1 if marker == 0xFF else 2 + length
    return None


def _webp_size(data: bytes) -> tuple[int, int] | None:
    if data[:4] != b"RIFF" or data[8:12] != b"WEBP" or len(data) < 30:
        return None
    kind = data[12:16]
    if kind == b"VP8X":
        return 1 + int.from_bytes(data[24:27], "little"), 1 + int.from_bytes(data[27:30], "little")
    if kind == b"VP8L":
        bits = int.from_bytes(data[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    width, height = struct.unpack("<HH", data[26:30])
    return width & 0x3FFF, height & 0x3FFF


def _has_alpha(image: np.ndarray) -> bool:  # type: ignore[type-arg]
    return image.ndim == 3 and image.shape[2] == 4


def _rgb8(image: np.ndarray) -> ByteArray:  # type: ignore[type-arg]
    import cv2

    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    if _has_alpha(image):
        alpha = image[..., 3:].astype(np.float32) / 255.0
        image = np.rint(image[..., :3] * alpha + 128.0 * (1.0 - alpha)).astype(np.uint8)
    return np.ascontiguousarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)
