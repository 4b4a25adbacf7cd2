import pytest

from wzviewer.gl.timing import FrameTimer

pytestmark = pytest.mark.gl


def drawn(gl_context, timer, framebuffer, times):
    with timer.frame():
        for _ in range(times):
            framebuffer.clear(0.1, 0.2, 0.3, 1.0)
    gl_context.ctx.finish()


def test_a_frame_is_read_one_frame_later(gl_context):
    timer = FrameTimer(gl_context.ctx)
    framebuffer = gl_context.ctx.simple_framebuffer((512, 512))
    assert timer.seconds == 0.0
    drawn(gl_context, timer, framebuffer, 200)
    assert timer.seconds == 0.0
    drawn(gl_context, timer, framebuffer, 1)
    first = timer.seconds
    assert first == timer.seconds  # of the first frame, until there is a third
    drawn(gl_context, timer, framebuffer, 1)
    framebuffer.release()
    assert 0.0 < first < 60.0
    assert 0.0 < timer.seconds != first
