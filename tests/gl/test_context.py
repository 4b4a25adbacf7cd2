import subprocess
import sys

import numpy as np
import pytest

from tests.gl.surfaces import hill_scene
from wzviewer.errors import ContextError
from wzviewer.gl import context as contexts
from wzviewer.gl.renderer import SurfelRenderer

# Another context in this process would take the place of the session's.
OSMESA = """
import sys
import numpy as np
from tests.gl.surfaces import hill_scene
from wzviewer.errors import ContextError
from wzviewer.gl.context import create_context
from wzviewer.gl.renderer import SurfelRenderer

try:
    made = create_context("osmesa")
except ContextError as error:
    print(error, file=sys.stderr)
    sys.exit(77)
with made as context:
    assert context.kind == "osmesa"
    scene = hill_scene()
    renderer = SurfelRenderer(context, "shaders")
    renderer.sync(scene)
    np.save(sys.argv[1], renderer.render(scene[1].camera).read_color8())
    renderer.release()
"""


def test_osmesa_draws_what_egl_draws(gl_context, tmp_path):
    path = tmp_path / "frame.npy"
    done = subprocess.run(
        [sys.executable, "-c", OSMESA, str(path)], capture_output=True, text=True, timeout=120
    )
    if done.returncode == 77:
        pytest.skip(done.stderr.strip().splitlines()[-1])
    assert done.returncode == 0, done.stderr
    scene = hill_scene()
    renderer = SurfelRenderer(gl_context, "shaders")
    renderer.sync(scene)
    expected = renderer.render(scene[1].camera).read_color8()
    renderer.release()
    assert np.abs(np.load(path).astype(int) - expected).max() <= 1  # measured 0


def test_the_context_says_what_it_is(gl_context):
    assert gl_context.kind == "egl"
    assert gl_context.renderer_name
    assert gl_context.ctx.version_code >= 330


def test_without_egl_the_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")

    def fails(**settings):
        assert settings["libegl"] == "libEGL.so.1"  # a slim image has no ldconfig
        raise Exception("libEGL.so.1 not loaded")

    monkeypatch.setattr(contexts.ctypes.util, "find_library", lambda name: None)
    monkeypatch.setattr(contexts.moderngl, "create_context", fails)
    with pytest.raises(ContextError, match=r"not loaded.*libegl1"):
        contexts.create_context("egl")


def test_auto_tries_egl_then_osmesa(monkeypatch):
    def fails(*_):
        raise ContextError("X", "is missing")

    monkeypatch.setattr(contexts, "_egl_context", fails)
    monkeypatch.setattr(contexts, "_osmesa_context", lambda: "osmesa")
    assert contexts.create_context("auto") == "osmesa"
    monkeypatch.setattr(contexts, "_osmesa_context", fails)
    with pytest.raises(ContextError, match=r"EGL: is missing.*OSMesa: is missing"):
        contexts.create_context("auto")
