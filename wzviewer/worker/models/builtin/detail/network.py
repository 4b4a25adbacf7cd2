"""The compact network behind the crisp base: a picture in, the same twice, four and eight times larger out.

354 thousand parameters, trained from scratch on procedural pictures (``training/train_detail.py``) and
stored as float16.  Most of the work happens at the small size, so eight times larger costs little more than
twice::

    image, flag -> trunk (8 convolutions) -> x2 -> x4 -> x8
                                              |     |     |   each adds what bicubic enlargement lacks
"""

import itertools

import torch
from torch import Tensor, nn
from torch.nn import functional

TRUNK_CHANNELS = 56
STEP_CHANNELS = (32, 24, 16)
TRUNK_BLOCKS = 4
PLANES = 4  # red, green, blue, and whether a camera or compression has worn the picture


class Block(nn.Module):
    """Two 3x3 convolutions beside a skip connection."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first, self.second = (nn.Conv2d(channels, channels, 3, 1, 1) for _ in range(2))
        self.before, self.between = (nn.PReLU(channels) for _ in range(2))

    def forward(self, x: Tensor) -> Tensor:
        """(n, channels, h, w) to the same."""
        y: Tensor = x + self.second(self.between(self.first(self.before(x))))
        return y


class Doubling(nn.Module):
    """Doubles the size of the features and reads a correction of the picture off them."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.spread = nn.Conv2d(inputs, 4 * outputs, 3, 1, 1)
        self.mix = nn.Conv2d(outputs, outputs, 3, 1, 1)
        self.after_spread, self.after_mix = (nn.PReLU(outputs) for _ in range(2))
        self.color = nn.Conv2d(outputs, 3, 3, 1, 1)
        for values in self.color.parameters():
            nn.init.zeros_(values)  # training starts from the bicubic enlargement

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """(n, inputs, h, w) to features (n, outputs, 2h, 2w) and correction (n, 3, 2h, 2w)."""
        x = self.after_spread(functional.pixel_shuffle(self.spread(x), 2))
        x = self.after_mix(self.mix(x))
        return x, self.color(x)


class DetailNetwork(nn.Module):
    """The network; see `forward`."""

    def __init__(self) -> None:
        super().__init__()
        self.head = nn.Conv2d(PLANES, TRUNK_CHANNELS, 3, 1, 1)
        self.trunk = nn.Sequential(*(Block(TRUNK_CHANNELS) for _ in range(TRUNK_BLOCKS)))
        sizes = (TRUNK_CHANNELS, *STEP_CHANNELS)
        self.steps = nn.ModuleList(Doubling(a, b) for a, b in itertools.pairwise(sizes))

    def forward(self, image: Tensor, worn: Tensor, doublings: int = 3) -> list[Tensor]:
        """Enlarges pictures.

        Args:
            image: (n, 3, h, w) sRGB 0..1.
            worn: (n,) 1 for a photograph, 0 for a clean picture of our own.
            doublings: how many sizes to make, 1 to 3.

        Returns:
            (n, 3, 2h, 2w), and (n, 3, 4h, 4w), and (n, 3, 8h, 8w), as far as asked for; not clipped.
        """
        flag = worn.to(image.dtype)[:, None, None, None].expand(-1, 1, *image.shape[2:])
        x = self.head(torch.cat([image - 0.5, flag], 1))
        x = x + self.trunk(x)
        made, picture = [], image
        for step in list(self.steps)[:doublings]:
            x, correction = step(x)
            picture = (
                functional.interpolate(picture, scale_factor=2, mode="bicubic", align_corners=False)
                + correction
            )
            made.append(picture)
        return made
