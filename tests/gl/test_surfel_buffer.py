import numpy as np
import pytest

from tests.core.builders import random_surfels
from wzviewer.gl.pages import PAGE_BYTES, PAGE_SURFELS
from wzviewer.gl.records import pack
from wzviewer.gl.surfel_buffer import SurfelBuffer


@pytest.fixture
def buffer(gl_context):
    made = SurfelBuffer(gl_context.ctx)
    yield made
    made.release()


def records_of(buffer, index):
    parts = [buffer.buffer.read(PAGE_BYTES, offset=int(r) * 32) for r in buffer.first_records((index, 0))]
    return b"".join(parts)[: 32 * len(buffer.shown((index, 0)))]


def test_bytes_of_a_level_are_exact_and_never_change(buffer):
    first, second = random_surfels(PAGE_SURFELS + 7, 1), random_surfels(900, 2)
    buffer.stage((0, 0), first, 0)
    buffer.upload()
    before = records_of(buffer, 0)
    assert before == pack(first, 0).tobytes()
    pages = buffer.first_records((0, 0)).tolist()
    buffer.stage((1, 0), second, 1)
    buffer.upload()
    assert records_of(buffer, 0) == before
    assert buffer.first_records((0, 0)).tolist() == pages
    assert records_of(buffer, 1) == pack(second, 1).tobytes()


def test_a_budget_spreads_an_upload(buffer):
    buffer.stage((0, 0), random_surfels(3 * PAGE_SURFELS), 0)
    assert buffer.upload(1) == PAGE_BYTES  # at least one page, or it would never end
    assert buffer.shown((0, 0)) is None
    assert buffer.upload(2 * PAGE_BYTES) == 2 * PAGE_BYTES
    assert buffer.shown((0, 0)) is not None
    assert buffer.upload() == 0


def test_a_replaced_level_is_shown_until_the_next_version_is_complete(buffer):
    old, new = random_surfels(100, 1), random_surfels(2 * PAGE_SURFELS, 2)
    buffer.stage((0, 0), old, 0)
    buffer.upload()
    buffer.stage((0, 0), new, 0)
    buffer.upload(1)
    assert buffer.shown((0, 0)) is old
    assert buffer.latest((0, 0)) is new
    assert records_of(buffer, 0) == pack(old, 0).tobytes()
    buffer.upload()
    assert buffer.shown((0, 0)) is new
    assert records_of(buffer, 0) == pack(new, 0).tobytes()


def test_pages_are_given_back_and_used_again(buffer):
    for index in range(2):
        buffer.stage((index, 0), random_surfels(2 * PAGE_SURFELS, index), index)
    buffer.upload()
    held = buffer.num_bytes
    kept = records_of(buffer, 1)
    buffer.remove((0, 0))
    buffer.reclaim()
    buffer.stage((2, 0), random_surfels(2 * PAGE_SURFELS, 5), 2)
    buffer.upload()
    assert buffer.num_bytes == held
    assert records_of(buffer, 1) == kept
    assert np.intersect1d(buffer.first_records((1, 0)), buffer.first_records((2, 0))).size == 0


def test_a_preview_that_is_superseded_leaks_no_page(buffer):
    buffer.stage((0, 0), random_surfels(4 * PAGE_SURFELS), 0)
    buffer.upload(1)
    held = buffer.num_bytes
    for seed in range(3):
        buffer.stage((0, 0), random_surfels(4 * PAGE_SURFELS, seed), 0)
        buffer.upload(1)
    assert buffer.num_bytes == held


def test_retired_pages_are_not_written_before_they_are_reclaimed(buffer):
    first = random_surfels(PAGE_SURFELS, 1)
    buffer.stage((0, 0), first, 0)
    buffer.upload()
    page = int(buffer.first_records((0, 0))[0])
    buffer.stage((0, 0), random_surfels(PAGE_SURFELS, 2), 0)
    buffer.upload()
    buffer.stage((1, 0), random_surfels(PAGE_SURFELS, 3), 1)
    buffer.upload()
    assert buffer.buffer.read(PAGE_BYTES, offset=page * 32) == pack(first, 0).tobytes()
    buffer.reclaim()
    buffer.stage((2, 0), random_surfels(PAGE_SURFELS, 4), 2)
    buffer.upload()
    assert int(buffer.first_records((2, 0))[0]) == page
