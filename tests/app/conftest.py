"""An imgui context without a window: panels and input run, nothing is drawn."""

import imgui_bundle  # noqa: F401 - before glfw
import pytest
from imgui_bundle import imgui, implot

from tests.app.screen import Screen
from wzviewer.app.theme import apply_theme


@pytest.fixture
def screen():
    context = imgui.create_context()
    plots = implot.create_context()
    io = imgui.get_io()
    io.set_ini_filename("")
    io.backend_flags |= imgui.BackendFlags_.renderer_has_textures.value
    io.config_input_trickle_event_queue = False  # all events of a frame count in that frame
    yield Screen(apply_theme(1.0))
    implot.destroy_context(plots)
    imgui.destroy_context(context)
