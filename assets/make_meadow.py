"""Paint the bundled picture: a meadow with a flower near, trees and hills far, and its true depth.

    plants, stones, hills            camera                  sun
    -> sheets of triangles  -> visibility buffer   +   two shadow maps
                                     |
                           shade every sample (shadow, occlusion, translucency, haze)
                                     |
       clouds marched per pixel  ->  mean of the samples, tone curve  ->  meadow.png
                                     depth of the surface that most samples see  ->  meadow_depth.npz

Run `python assets/make_meadow.py`. Axes of the world: x right, y up, z away from the camera.
"""

import argparse
import struct
import zlib
from pathlib import Path

import numpy as np
from meadow.light import shade_samples
from meadow.planting import meadow_mesh
from meadow.sky import sky_picture
from meadow.visibility import project_vertices, rasterize, sun_view
from meadow.world import HEIGHT, SKY_DEPTH, WIDTH, FloatArray
from numba import njit
from numpy.typing import NDArray


@njit(nogil=True)
def _settle(nearness: FloatArray, height: int, width: int, samples: int) -> FloatArray:
    """Depth of the surface that most samples of a pixel see (0: the sky), never a mean of two surfaces."""
    out = np.zeros((height, width), np.float32)
    n = samples * samples
    values = np.empty(n)
    for y in range(height):
        for x in range(width):
            for k in range(n):
                values[k] = nearness[y * samples + k // samples, x * samples + k % samples]
            best, chosen = 0, 0.0
            ordered = np.sort(values)
            start = 0
            for k in range(n):
                while ordered[k] - ordered[start] > 0.03 * ordered[k]:
                    start += 1
                if k - start + 1 >= best:
                    best, chosen = k - start + 1, ordered[(k + start) // 2]
            out[y, x] = 1.0 / chosen if chosen > 0 else 0.0
    return out


def render_meadow(
    width: int, height: int, samples: int, seed: int
) -> tuple[NDArray[np.uint8], FloatArray, NDArray[np.bool_]]:
    """Render the meadow.

    Args:
        width: Pixels; the focal length is 1024/1088 of it.
        height: Pixels.
        samples: Samples of a pixel along each side.
        seed: Of every random choice.

    Returns:
        Picture (h, w, 3); depth along the view axis (h, w), median of what is not sky = 1, sky = 36.7;
        sky (h, w).
    """
    vertices, triangles, materials = meadow_mesh(seed)
    screen = project_vertices(vertices[:, :3], width, height, samples)
    nearness = np.zeros((height * samples, width * samples), np.float32)
    index = np.full(nearness.shape, -1, np.int32)
    rasterize(screen, triangles, nearness, index)
    shadow = sun_view(vertices, triangles, 4096 if height > 300 else 2048)
    sky_color = sky_picture(width, height)
    picture = shade_samples(vertices, triangles, materials, screen, nearness, index, sky_color, samples,
                     shadow.maps, shadow.axes, shadow.windows)  # fmt: skip
    depth = _settle(nearness, height, width, samples)
    sky = depth == 0
    depth = np.where(sky, SKY_DEPTH, depth / np.median(depth[~sky])).astype(np.float32)
    return _encode(picture), depth, sky


def _encode(linear: FloatArray) -> NDArray[np.uint8]:
    """Grade a little (warm lights, cool shadows), then sRGB."""
    luma = linear @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    graded = luma[..., None] + 1.06 * (linear - luma[..., None])
    graded = graded * (1 + (luma[..., None] - 0.4) * np.array([0.035, 0.0, -0.05]))
    graded = np.clip(graded, 0, 1)
    coded = np.where(graded <= 0.0031308, 12.92 * graded, 1.055 * graded ** (1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * coded), np.uint8)


def _rounded(depth: FloatArray) -> FloatArray:
    """Keep 14 bits of the mantissa (3e-5 of the depth): the rest would only be noise to compress."""
    drop = np.uint32(23 - 14)
    bits = depth.view(np.uint32) + np.uint32(1 << 8)
    return (bits >> drop << drop).view(np.float32)


def _png(picture: NDArray[np.uint8]) -> bytes:
    """An 8-bit RGB PNG; each row takes the filter with the least sum of absolute differences."""
    height, width, _ = picture.shape
    now = picture.reshape(height, -1).astype(np.int16)
    above = np.vstack([np.zeros_like(now[:1]), now[:-1]])
    left = np.pad(now, ((0, 0), (3, 0)))[:, :-3]
    corner = np.pad(above, ((0, 0), (3, 0)))[:, :-3]
    guess = left + above - corner
    pa, pb, pc = np.abs(guess - left), np.abs(guess - above), np.abs(guess - corner)
    paeth = np.where((pa <= pb) & (pa <= pc), left, np.where(pb <= pc, above, corner))
    rows = np.stack([now - g for g in (0 * now, left, above, (left + above) >> 1, paeth)]).astype(np.uint8)
    cost = np.abs(rows.astype(np.int8).astype(np.int32)).sum(-1)
    body = b"".join(bytes([k]) + rows[k, y].tobytes() for y, k in enumerate(cost.argmin(0)))

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = (
        chunk(b"IHDR", head),
        chunk(b"sRGB", b"\0"),
        chunk(b"IDAT", zlib.compress(body, 9)),
        chunk(b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def main() -> None:
    """Render and write the two files."""
    parser = argparse.ArgumentParser(description="Render the bundled meadow picture and its depth.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the two files")
    parser.add_argument("--size", default=f"{WIDTH}x{HEIGHT}")
    parser.add_argument("--samples", type=int, default=4, help="along each side of a pixel")
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    width, height = (int(part) for part in options.size.split("x"))
    picture, depth, sky = render_meadow(width, height, options.samples, options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "meadow.png").write_bytes(_png(picture))
    np.savez_compressed(options.out / "meadow_depth.npz", depth=_rounded(depth), sky=sky)


if __name__ == "__main__":
    main()
