import numpy as np

from wzviewer.core.anchor import AnchoredView, LevelFrame
from wzviewer.core.camera import Camera
from wzviewer.core.opacity import Cover, Modulation, feather_px
from wzviewer.gl.blocks import COVER_TEXELS, HEAD_TEXELS, BlockTexture


def many_covers(count):
    camera = Camera.initial(40, 30)
    frame = LevelFrame.of_camera(camera, 1.0)
    near = [camera.zoomed_to_region(0.1 + 0.8 * k / count, 0.5, 8.0) for k in range(count)]
    return camera, frame, Modulation(None, tuple(Cover.expand(c, camera, frame) for c in near))


def test_texels_lie_where_the_shader_reads_them():
    camera, _, modulation = many_covers(2)
    texels = modulation.texels()
    assert texels.shape == (2 + 2 * COVER_TEXELS, 4)
    assert texels[1].tolist() == [2.0, 0.0, 1.0, 0.0]
    second = texels[2 + COVER_TEXELS :]
    np.testing.assert_array_equal(second[:3], modulation.covers[1].view.rows.astype(np.float32))
    np.testing.assert_array_equal(second[3], modulation.covers[1].parent_rows.astype(np.float32))
    assert second[4].tolist() == [40.0, 30.0, np.float32(feather_px(camera)), 1.0]


def test_no_cover_is_dropped(gl_context):
    blocks = BlockTexture(gl_context.ctx)
    for count in (3, 64, 65, 200):
        camera, frame, modulation = many_covers(count)
        view = AnchoredView.expand(camera, frame)
        blocks.write({0: view}, {0: modulation, 5: Modulation(None, ())})
        width, height = blocks.texture.size
        assert height == 6
        data = np.frombuffer(blocks.texture.read(), np.float32).reshape(height, width, 4)
        used = HEAD_TEXELS + count * COVER_TEXELS
        assert data[0, HEAD_TEXELS - 1, 0] == count
        expected = modulation.texels()[2:]
        np.testing.assert_array_equal(data[0, HEAD_TEXELS:used], expected)
        np.testing.assert_array_equal(data[0, :3], AnchoredView.expand(camera, frame).rows.astype(np.float32))
    blocks.release()
