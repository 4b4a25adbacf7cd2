"""Fixtures of the whole suite."""

import pytest

from wzviewer.errors import ContextError


@pytest.fixture(scope="session")
def gl_context():
    """One off-screen context for the session; tests that need it are skipped where none can be made."""
    from wzviewer.gl.context import create_context

    try:
        context = create_context("egl")
    except ContextError as error:
        pytest.skip(str(error))
    yield context
    context.close()
