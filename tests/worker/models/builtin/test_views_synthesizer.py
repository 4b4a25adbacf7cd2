"""Laws of the layers behind a picture: depth, colour, source view, coverage, determinism."""

import hashlib

import numba
import numpy as np
import pytest

from wzviewer.core.camera import Camera
from wzviewer.errors import Cancelled
from wzviewer.worker.models.builtin.views.backdrop import STRIDE_PX
from wzviewer.worker.models.builtin.views.synthesizer import Completion, ViewSynthesizer
from wzviewer.worker.models.builtin.views.underlay import STRIDE_PX as UNDERLAY_STRIDE_PX
from wzviewer.worker.stages.stage4_auxiliary_views import neighbour_cameras, warp_view

HEIGHT, WIDTH, FOCAL_PX = 144, 216, 200.0
FAR, NEAR = 100.0, -80.0  # relief of two planes, px


def camera() -> Camera:
    return Camera.initial(WIDTH, HEIGHT, FOCAL_PX)


def striped() -> np.ndarray:
    """Vertical-free horizontal stripes of 12 px, so that a row says which colour must continue."""
    rows = (np.arange(HEIGHT) // 12) % 2
    image = np.where(rows[:, None, None] == 1, np.float32([0.8, 0.6, 0.2]), np.float32([0.2, 0.3, 0.6]))
    return np.ascontiguousarray(np.broadcast_to(image, (HEIGHT, WIDTH, 3)), np.float32)


def box() -> np.ndarray:
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[40:104, 80:130] = True
    return mask


def two_planes() -> tuple[np.ndarray, np.ndarray]:
    image = striped()
    image[box()] = [0.9, 0.1, 0.1]
    return image, np.where(box(), NEAR, FAR).astype(np.float32)


def complete(image: np.ndarray, relief: np.ndarray, outside: bool = False, **options: object) -> Completion:
    sky = options.pop("sky", None)
    return ViewSynthesizer().complete(image, relief, sky, camera(), outside, **options)


@pytest.fixture(scope="module")
def behind_box() -> Completion:
    return complete(*two_planes())


@pytest.fixture(scope="module")
def padded() -> Completion:
    return complete(*two_planes(), outside=True)


def on_frame(layer: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A stride-1 layer laid on the frame: image, relief, mask."""
    image, relief = np.zeros((HEIGHT, WIDTH, 3), np.float32), np.zeros((HEIGHT, WIDTH), np.float32)
    mask = np.zeros((HEIGHT, WIDTH), bool)
    x, y = layer.offset_px
    part = np.s_[y : y + layer.mask.shape[0], x : x + layer.mask.shape[1]]
    image[part], relief[part], mask[part] = layer.image, layer.relief, layer.mask
    return image, relief, mask


def digest(completion: Completion) -> str:
    total = hashlib.sha256(completion.relief.tobytes())
    for layer in completion.layers:
        for array in (layer.image, layer.relief, layer.mask):
            total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


def test_layer_continues_the_far_plane_at_its_depth(behind_box):
    _, relief, mask = on_frame(behind_box.layers[0])
    hidden = mask & (behind_box.relief < 0)
    hidden[:42] = hidden[102:] = False
    hidden[:, :82] = hidden[:, 128:] = False  # pixels beside the rim are pushed behind it by 0.4 %
    assert hidden.sum() > 500
    depth = (FOCAL_PX + relief[hidden]) / (FOCAL_PX + FAR)
    assert np.abs(depth - 1).max() < 1e-3  # measured 1.2e-7


def test_layer_lies_behind_the_front(behind_box):
    for layer in behind_box.layers:
        _, relief, mask = on_frame(layer)
        assert (relief[mask] > behind_box.relief[mask]).all()


def test_stripes_continue_behind_the_box(behind_box):
    image, _, mask = on_frame(behind_box.layers[0])
    hidden = mask & box()
    hidden[:44] = hidden[100:] = False
    error = np.abs(image - striped()).max(axis=-1)[hidden]
    assert (error < 0.1).mean() > 0.85  # measured 0.98
    assert (image[hidden][:, 0] < 0.85).mean() > 0.99  # the red box is not its own background


def test_the_picture_is_untouched_and_the_step_is_kept(behind_box):
    image, relief = two_planes()
    assert np.array_equal(behind_box.image, image)
    inner = np.s_[44:100, 84:126]
    assert np.array_equal(behind_box.relief[inner], relief[inner])
    assert set(np.unique(np.round(behind_box.relief, 2))) == {NEAR, FAR}


def near_frame(shape: tuple[int, int], x0: int, y0: int, stride: int) -> np.ndarray:
    x, y = x0 + (np.arange(shape[1]) + 0.5) * stride, y0 + (np.arange(shape[0]) + 0.5) * stride
    return ((y > -3) & (y < HEIGHT + 3))[:, None] & ((x > -3) & (x < WIDTH + 3))[None]


def splat(completion: Completion, with_layers: bool) -> np.ndarray:
    """An independent renderer of the source view: soft 3 x 3 splats, composited front to back."""
    points = [(completion.image, completion.relief, np.ones((HEIGHT, WIDTH), bool), (0, 0), 1)]
    if with_layers:
        points += [
            (layer.image, layer.relief, layer.mask, layer.offset_px, layer.stride)
            for layer in completion.layers
        ]
    items = []
    for image, relief, mask, (x0, y0), stride in points:
        rows, columns = np.nonzero(mask & near_frame(mask.shape, x0, y0, stride))
        x, y = x0 + (columns + 0.5) * stride, y0 + (rows + 0.5) * stride
        items.append(
            np.column_stack([relief[rows, columns], x, y, np.full(len(x), stride), image[rows, columns]])
        )
    table = np.concatenate(items)
    table = table[np.argsort(table[:, 0], kind="stable")]
    color, left = np.zeros((HEIGHT, WIDTH, 3)), np.ones((HEIGHT, WIDTH))
    for _, x, y, stride, r, g, b in table:
        sigma = 0.55 * stride
        for v in range(max(0, int(y - stride - 0.5)), min(HEIGHT, int(y + stride + 0.5) + 1)):
            for u in range(max(0, int(x - stride - 0.5)), min(WIDTH, int(x + stride + 0.5) + 1)):
                far = ((u + 0.5 - x) ** 2 + (v + 0.5 - y) ** 2) / (2 * sigma**2)
                alpha = 0.99 * np.exp(-far)
                if alpha > 1 / 255:
                    color[v, u] += left[v, u] * alpha * np.array([r, g, b])
                    left[v, u] *= 1 - alpha
    return color


def test_source_view_does_not_change(padded):
    # without layers the background is black; compare where the picture itself is opaque
    alone, full = splat(padded, False), splat(padded, True)
    inner = np.s_[3:-3, 3:-3]
    error = np.mean((alone[inner] - full[inner]) ** 2)
    # Measured 55.9 dB: in the gaps between splats there is the backdrop instead of black; 63 without it.
    assert -10 * np.log10(error) > 55


def test_orbit_of_eight_degrees_is_covered(padded):
    image, relief = two_planes()
    for neighbour in neighbour_cameras(camera(), 1.0, ((8, 0), (-8, 0), (0, 5), (6, 4))):
        _, known = warp_view(image, padded.relief, padded.layers, camera(), neighbour)
        bare = warp_view(image, relief, (), camera(), neighbour)[1]
        assert 1 - bare.mean() > 0.02
        assert 1 - known.mean() <= 0.005  # measured 0


def test_sky_stays_sky():
    image, relief = two_planes()
    sky = np.zeros((HEIGHT, WIDTH), bool)
    sky[:60] = True
    sky &= ~box()
    relief = np.where(sky, np.float32(35 * FOCAL_PX), relief)
    completion = complete(image, relief, sky=sky)
    _, layer, mask = on_frame(completion.layers[0])
    behind_top = mask & box() & (np.arange(HEIGHT)[:, None] < 50)
    assert behind_top.sum() > 100
    assert np.median(layer[behind_top]) > 34 * FOCAL_PX
    low = mask & box() & (np.arange(HEIGHT)[:, None] > 95)
    assert (layer[low] < 2 * FAR).all()  # no sky under the horizon


def test_the_pad_surrounds_the_frame(padded):
    covered = np.zeros((HEIGHT + 2 * 32, WIDTH + 2 * 52), bool)
    assert {layer.stride for layer in padded.layers} == {1, 2, UNDERLAY_STRIDE_PX, STRIDE_PX}
    for layer in padded.layers[:-1]:  # the last is the backdrop, which reaches farther
        whole = np.repeat(np.repeat(layer.mask, layer.stride, 0), layer.stride, 1)
        x, y = layer.offset_px[0] + 52, layer.offset_px[1] + 32
        covered[y : y + whole.shape[0], x : x + whole.shape[1]] |= whole
    covered[32:-32, 52:-52] = True
    assert covered.all()


def test_a_smooth_picture_needs_no_layers():
    slope = np.linspace(30, -30, HEIGHT, dtype=np.float32)[:, None] + np.zeros((1, WIDTH), np.float32)
    completion = complete(striped(), slope)
    assert completion.layers == ()
    assert completion.relief is slope


def test_same_seed_same_bytes_for_any_number_of_threads(behind_box):
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        assert digest(complete(*two_planes())) == digest(behind_box)
    finally:
        numba.set_num_threads(threads)
    assert digest(complete(*two_planes(), seed=5)) != digest(behind_box)


def test_a_cancel_gets_through():
    calls = []

    def check() -> None:
        calls.append(1)
        raise Cancelled

    with pytest.raises(Cancelled):
        complete(*two_planes(), check=check)
    assert len(calls) == 1


@pytest.mark.parametrize("jump_px", [60.0, 400.0])
def test_deep_levels_stay_finite_and_behind(jump_px):
    near = camera()
    deep = Camera(np.eye(4), 7e13, 7e13, 3e13, -2e13, near.width, near.height)
    relief = np.where(box(), 0.0, jump_px).astype(np.float32)
    completion = ViewSynthesizer().complete(two_planes()[0], relief, None, deep, False)
    assert completion.layers
    for layer in completion.layers:
        _, depth, mask = on_frame(layer)
        assert np.isfinite(depth).all()
        assert (depth[mask] >= completion.relief[mask] + 0.4).all()
        assert depth[mask & box()].min() > 0.9 * jump_px


@pytest.mark.parametrize("jump_px", [1e6, 1e15])
def test_what_is_out_of_sight_within_a_hundredth_of_a_degree_gets_no_layer(jump_px):
    """Such a background is inherited from the levels that see it; here it must only do no harm."""
    near = camera()
    deep = Camera(np.eye(4), 7e13, 7e13, 3e13, -2e13, near.width, near.height)
    relief = np.where(box(), 0.0, jump_px).astype(np.float32)
    completion = ViewSynthesizer().complete(two_planes()[0], relief, None, deep, False)
    assert completion.layers == ()
    assert np.isfinite(completion.relief).all()


@pytest.mark.parametrize("sky_px", [0.0, -0.01, 5e5])
def test_what_stands_before_the_sky_of_a_close_view_keeps_its_depth(sky_px):
    """The anchor may lie in the sky: its relief is then nothing to measure others by."""
    closer = camera().zoomed_to_region(0.5, 0.5, 8.0)
    sky = np.zeros((HEIGHT, WIDTH), bool)
    sky[:, WIDTH // 2 :] = True
    petal_px = -0.9 * closer.focal_px if sky_px <= 0 else 0.0  # nearer than the sky by far
    relief = np.where(sky, sky_px, petal_px).astype(np.float32)
    image = np.where(sky[..., None], np.float32(0.9), np.float32(0.2)) + np.zeros(
        (HEIGHT, WIDTH, 3), np.float32
    )
    kept = ViewSynthesizer().complete(image, relief, sky, closer, outside=False).relief
    assert np.allclose(kept[:, : WIDTH // 2 - 8], petal_px, rtol=1e-3)
    assert np.allclose(kept[:, WIDTH // 2 + 8 :], sky_px, atol=1.0, rtol=1e-3)
