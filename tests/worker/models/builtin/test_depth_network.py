import importlib.util
from importlib import resources

import pytest
import torch

from wzviewer.worker.models.builtin.depth.estimator import load_network
from wzviewer.worker.models.builtin.depth.network import DepthNetwork, planes

assert importlib.util.find_spec("wzviewer.worker.models.builtin.weights")
WEIGHTS = resources.files("wzviewer.worker.models.builtin.weights").joinpath("depth.safetensors")
needs_weights = pytest.mark.skipif(not WEIGHTS.is_file(), reason="no trained weights here")


@pytest.mark.parametrize(("h", "w"), [(96, 144), (144, 96), (112, 112), (64, 192)])
def test_output_is_half_the_input_and_never_negative(h, w):
    torch.manual_seed(0)
    with torch.no_grad():
        disparity, logit, stands = DepthNetwork().eval()(torch.rand(2, 3, h, w))
    assert disparity.shape == logit.shape == stands.shape == (2, h // 2, w // 2)
    assert float(disparity.min()) >= 0
    assert bool(torch.isfinite(logit).all())


def test_planes_tell_height_and_distance_from_the_middle():
    seen = planes(torch.full((1, 3, 32, 48), 0.45))[0]
    assert torch.allclose(seen[:3], torch.zeros(3, 32, 48), atol=1e-6)
    assert float(seen[3, 0, 0]) == -1
    assert float(seen[3, -1, 0]) == 1
    assert torch.allclose(seen[4], seen[4].flip(-1))
    assert float(seen[4].min()) < 0.05
    assert torch.allclose(seen[5], torch.zeros(32, 48), atol=1e-5)


@needs_weights
def test_shipped_file_is_small_and_fits_the_network():
    assert len(WEIGHTS.read_bytes()) <= 3_000_000  # measured: 2 903 958
    network = load_network()
    assert all(bool(torch.isfinite(p).all()) for p in network.parameters())
    assert not any(p.requires_grad for p in network.parameters())


@needs_weights
def test_pictures_in_one_batch_do_not_see_each_other():
    network, images = load_network(), torch.rand(2, 3, 96, 144, generator=torch.Generator().manual_seed(1))
    with torch.no_grad():
        together, alone = network(images)[0][1], network(images[1:])[0][0]
    assert torch.allclose(together, alone, atol=1e-5)  # measured: 0 to 5e-7
