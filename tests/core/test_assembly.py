"""A level that comes in chunks is the level that was sent; chunks that do not fit are refused."""

import numpy as np
import pytest

from tests.core.builders import random_surfels
from wzviewer.core import assembly as assembly_module
from wzviewer.core.anchor import LevelFrame
from wzviewer.core.assembly import MAX_SURFELS, LevelAssembly, finished, surfel_arrays
from wzviewer.core.camera import Camera
from wzviewer.core.records import header_of
from wzviewer.core.scene import Level
from wzviewer.core.surfels import Surfels

SIZES = (7, 5, 1)


def begun():
    """An assembly that waits for chunks, the surfels that they are cut from, and the level."""
    camera = Camera.initial(8, 6)
    frame = LevelFrame.of_camera(camera, 2.0)
    surfels = random_surfels(sum(SIZES))
    image, relief = np.zeros((6, 8, 3), np.uint8), np.zeros((6, 8), np.float32)
    level = Level(0, None, camera, frame, surfels, image, relief)
    assembly = LevelAssembly()
    assembly.begin(header_of(level), {"image": image, "relief": relief})
    return assembly, surfels, level


def chunk(surfels, start, size):
    return surfel_arrays(surfels.take(slice(start, start + size)))


def test_chunks_make_up_the_revision():
    assembly, surfels, level = begun()
    start, total = 0, len(surfels)
    for size in SIZES:
        complete = assembly.add(start, total, chunk(surfels, start, size))
        start += size
        assert complete == (start == total)
        assert len(assembly.level().surfels) == (total if complete else 0)
    expected = finished(surfels, level.camera, level.frame)
    for name, array in assembly.level().surfels.arrays().items():
        np.testing.assert_array_equal(array, getattr(expected, name))


def test_unpacking_in_pieces_changes_no_bit(monkeypatch):
    _, _, level = begun()
    surfels = random_surfels(1000)
    whole = finished(surfels, level.camera, level.frame)
    monkeypatch.setattr(assembly_module, "UNPACKED_SURFELS", 64)
    pieces = finished(surfels, level.camera, level.frame)
    for name, array in whole.arrays().items():
        assert pieces.arrays()[name].tobytes() == array.tobytes()


def test_a_revision_may_begin_again():
    assembly, surfels, level = begun()
    assembly.add(0, 13, chunk(surfels, 0, 7))
    assert assembly.add(0, 5, chunk(surfels, 8, 5))
    expected = finished(surfels.take(slice(8, 13)), level.camera, level.frame)
    np.testing.assert_array_equal(assembly.level().surfels.means, expected.means)


def test_a_revision_may_be_empty():
    assembly, _, _ = begun()
    assert assembly.add(0, 0, surfel_arrays(Surfels.empty()))
    assert len(assembly.level().surfels) == 0


@pytest.mark.parametrize(
    ("start", "total", "size"),
    [(6, 13, 5), (8, 13, 5), (7, 11, 5), (7, 14, 5), (0, 4, 5), (0, MAX_SURFELS + 1, 5)],
    ids=["again", "gap", "past the end", "another total", "too many", "no end"],
)
def test_a_chunk_that_does_not_fit_is_refused(start, total, size):
    assembly, surfels, _ = begun()
    assembly.add(0, 13, chunk(surfels, 0, 7))
    with pytest.raises(ValueError, match="out of order"):
        assembly.add(start, total, chunk(surfels, 0, size))
    assert len(assembly.level().surfels) == 0
