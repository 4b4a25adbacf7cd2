import numpy as np
import torch

from wzviewer.worker.models.builtin.depth.grid import Adam, BilateralGrid


def maps(h=60, w=90):
    rng = np.random.default_rng(0)
    return rng.random((h, w)).astype(np.float32), np.linspace(0, 1, h * w, dtype=np.float32).reshape(h, w)


def test_untrained_it_is_the_identity():
    estimate, luma = maps()
    module = BilateralGrid(estimate, luma)
    assert np.array_equal(module().detach().numpy(), estimate)
    assert float(module.roughness().detach()) == 0


def test_gain_and_offset_are_affine():
    module = BilateralGrid(*maps())
    with torch.no_grad():
        module.gain.fill_(np.log(2.0))
        module.offset.fill_(0.25)
        assert torch.allclose(module(), 2 * module.estimate + 0.25, atol=1e-5)  # measured: 2e-7


def test_a_correction_follows_brightness():
    estimate = np.ones((40, 60), np.float32)
    luma = np.zeros((40, 60), np.float32)
    luma[:, 30:] = 1
    module = BilateralGrid(estimate, luma)
    with torch.no_grad():
        module.grid[0, 1, -1] = 1.0  # the brightest layer only
        out = module().numpy()
    assert np.allclose(out[:, :30], 1.0)
    assert np.allclose(out[:, 30:], 1.3, atol=1e-6)


def test_only_the_grid_and_the_line_are_trained_and_move_to_other_sizes():
    estimate, luma = maps()
    module = BilateralGrid(estimate, luma)
    assert sorted(name for name, _ in module.named_parameters()) == ["gain", "grid", "offset"]
    with torch.no_grad():
        module.offset.fill_(0.5)
    other = module.applied_to(estimate[:30], luma[:30])
    assert np.allclose(other().detach().numpy(), estimate[:30] + 0.5)


def test_adam_takes_the_steps_that_torch_takes():
    module, twin = BilateralGrid(*maps()), BilateralGrid(*maps())
    ours, theirs = Adam(list(module.parameters()), 0.06), torch.optim.Adam(twin.parameters(), 0.06)
    for _ in range(5):
        for each in (module, twin):
            (each() * each.where[0, 0, ..., 2] - 0.3).abs().mean().backward()
        ours.step()
        theirs.step()
        theirs.zero_grad()
    for a, b in zip(module.parameters(), twin.parameters(), strict=True):
        assert torch.allclose(a, b, atol=1e-6)  # measured: 1e-8
