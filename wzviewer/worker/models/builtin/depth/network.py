"""The compact depth network: a picture in; inverse depth, sky and what stands out, at half its size.

1.45 million parameters, trained from scratch on procedural scenes (``training/train_depth.py``) and
stored as float16.  Fully convolutional; two kinds of far-reaching context are added at the
bottleneck: one vector for the whole picture and one per row (which row is the horizon?).
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

CHANNELS = (16, 40, 80, 120)
PLANES = 6  # red, green, blue, height, distance from the middle, brightness against the mean
STRIDE = 16  # input sides are multiples of this


class Block(nn.Module):
    """Two 3x3 convolutions beside a skip connection."""

    def __init__(self, inputs: int, outputs: int, stride: int = 1) -> None:
        super().__init__()
        self.first = nn.Conv2d(inputs, outputs, 3, stride, 1)
        self.second = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.norm = nn.GroupNorm(8, outputs)
        plain = inputs == outputs and stride == 1
        self.skip = nn.Identity() if plain else nn.Conv2d(inputs, outputs, 1, stride, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        """(n, inputs, h, w) to (n, outputs, h / stride, w / stride)."""
        y = self.norm(self.second(functional.leaky_relu(self.first(x), 0.1)))
        return functional.leaky_relu(y + self.skip(x), 0.1)


class Up(nn.Module):
    """Doubles the size and joins what the encoder knew there."""

    def __init__(self, inputs: int, joined: int, outputs: int) -> None:
        super().__init__()
        self.mix = nn.Conv2d(inputs + joined, outputs, 3, 1, 1)
        self.block = Block(outputs, outputs)

    def forward(self, x: Tensor, fine: Tensor) -> Tensor:
        """(n, inputs, h, w) and (n, joined, 2h, 2w) to (n, outputs, 2h, 2w)."""
        x = functional.interpolate(x, size=fine.shape[-2:], mode="bilinear", align_corners=False)
        return self.block(functional.leaky_relu(self.mix(torch.cat([x, fine], 1)), 0.1))


class DepthNetwork(nn.Module):
    """The U-Net; see `forward`."""

    def __init__(self) -> None:
        super().__init__()
        a, b, c, d = CHANNELS
        self.stem = nn.Conv2d(PLANES, a, 5, 2, 2)
        self.e1 = Block(a, a)
        self.e2 = nn.Sequential(Block(a, b, 2), Block(b, b))
        self.e3 = nn.Sequential(Block(b, c, 2), Block(c, c))
        self.e4 = nn.Sequential(Block(c, d, 2), Block(d, d), Block(d, d))
        self.whole = nn.Sequential(nn.Linear(2 * d, d), nn.LeakyReLU(0.1), nn.Linear(d, d))
        self.rows = nn.Conv1d(d, d, 3, 1, 1)
        self.d3 = Up(d, c, c)
        self.d2 = Up(c, b, b)
        self.d1 = Up(b, a, 24)
        self.out = nn.Conv2d(24, 3, 3, 1, 1)

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Reads pictures.

        Args:
            image: (n, 3, h, w) sRGB 0..1, sides multiples of `STRIDE`.

        Returns:
            Disparity >= 0, relative to its nearest things, logits of sky, and logits of standing (a wall, a
            person) rather than lying (a floor); each (n, h/2, w/2).
        """
        x = functional.leaky_relu(self.stem(planes(image)), 0.1)
        e1 = self.e1(x)
        e2 = self.e2(e1)
        e3 = self.e3(e2)
        e4 = self.e4(e3)
        summary = self.whole(torch.cat([e4.mean((2, 3)), e4.amax((2, 3))], 1))
        e4 = e4 + summary[:, :, None, None] + self.rows(e4.mean(3))[:, :, :, None]
        y = self.out(self.d1(self.d2(self.d3(e4, e3), e2), e1))
        return functional.softplus(2 * y[:, 0]) / 2, y[:, 1], y[:, 2]


def planes(image: Tensor) -> Tensor:
    """(n, 3, h, w) pictures to the (n, 6, h, w) that the network sees."""
    n, _, h, w = image.shape
    y = torch.linspace(-1, 1, h, dtype=image.dtype, device=image.device)[:, None].expand(n, 1, h, w)
    x = torch.linspace(-1, 1, w, dtype=image.dtype, device=image.device).abs().expand(n, 1, h, w)
    grey = image.mean(1, keepdim=True)
    return torch.cat([(image - 0.45) * 2.2, y, x, (grey - grey.mean((2, 3), keepdim=True)) * 3], 1)
