"""The part of the estimator that a view may train: a bilateral grid of gain and offset.

    D(I)^-1 = d0 * exp(a + A(x, y, luma)) + b + 0.3 B(x, y, luma)          (D_theta of Eq. 5)

with d0 the frozen estimate and theta = (a, b, A, B).  Because the grid is also indexed by
brightness, a correction seen on one part of a thing reaches its hidden part and stops at its edge.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from wzviewer.core.types import FloatArray

GRID = (8, 9, 13)  # luma, rows, columns


class BilateralGrid(nn.Module):
    """Trainable inverse depth on top of a frozen estimate.

    Args:
        estimate: (h, w) inverse depth up to a positive factor and an offset.
        luma: (h, w) brightness 0..1.
    """

    def __init__(self, estimate: FloatArray, luma: FloatArray) -> None:
        super().__init__()
        h, w = estimate.shape
        y = torch.linspace(-1, 1, h)[:, None].expand(h, w)
        x = torch.linspace(-1, 1, w)[None].expand(h, w)
        z = torch.from_numpy(luma).float() * 2 - 1
        self.estimate: Tensor
        self.where: Tensor
        self.register_buffer("estimate", torch.from_numpy(estimate).float())
        self.register_buffer("where", torch.stack([x, y, z], -1)[None, None])
        self.grid = nn.Parameter(torch.zeros(1, 2, *GRID))
        self.gain = nn.Parameter(torch.zeros(()))
        self.offset = nn.Parameter(torch.zeros(()))

    def forward(self) -> Tensor:
        """(h, w) inverse depth, in the unit of the estimate times exp(gain)."""
        sampled = functional.grid_sample(
            self.grid, self.where, mode="bilinear", padding_mode="border", align_corners=True
        )[0, :, 0]
        return self.estimate * torch.exp(self.gain + sampled[0]) + self.offset + 0.3 * sampled[1]

    def applied_to(self, estimate: FloatArray, luma: FloatArray) -> "BilateralGrid":
        """The same parameters over maps of another size."""
        other = BilateralGrid(estimate, luma)
        other.grid, other.gain, other.offset = self.grid, self.gain, self.offset
        return other

    def roughness(self) -> Tensor:
        """Mean squared first difference of the grid along its three axes."""
        g = self.grid
        parts = [g.diff(dim=axis).square().mean() for axis in (2, 3, 4)]
        return torch.stack(parts).sum()


class Adam:
    """Adam (Kingma and Ba) for a handful of tensors; `torch.optim` takes seconds to import.

    Args:
        parameters: leaves with gradients.
        rate: step size.
    """

    def __init__(self, parameters: list[nn.Parameter], rate: float) -> None:
        self.parameters, self.rate, self.count = parameters, rate, 0
        self.first = [torch.zeros_like(p) for p in parameters]
        self.second = [torch.zeros_like(p) for p in parameters]

    def step(self) -> None:
        """Moves the parameters against their gradients and clears these."""
        self.count += 1
        with torch.no_grad():
            for p, m, v in zip(self.parameters, self.first, self.second, strict=True):
                if p.grad is None:
                    continue
                m.lerp_(p.grad, 0.1)
                v.lerp_(p.grad.square(), 0.001)
                mean, power = m / (1 - 0.9**self.count), v / (1 - 0.999**self.count)
                p.sub_(self.rate * mean / (power.sqrt() + 1e-8))
                p.grad = None
