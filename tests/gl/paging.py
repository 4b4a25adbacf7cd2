"""Small pages, so that small scenes have many chunks."""

from wzviewer.gl import arrivals, pages, surfel_buffer
from wzviewer.gl.records import RECORD_BYTES


def shrink_pages(monkeypatch, surfels):
    """Makes a page hold so many surfels; returns its bytes."""
    page_bytes = surfels * RECORD_BYTES
    monkeypatch.setattr(pages, "PAGE_SURFELS", surfels)
    monkeypatch.setattr(arrivals, "PAGE_SURFELS", surfels)
    monkeypatch.setattr(pages, "PAGE_BYTES", page_bytes)
    monkeypatch.setattr(surfel_buffer, "PAGE_BYTES", page_bytes)
    return page_bytes
