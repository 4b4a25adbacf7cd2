"""Trains the built-in detail network on endless procedural pictures and writes ``detail.safetensors``.

    a pool of pictures -> pieces of 192 px -> seen by a worse camera, 24 px -> network -> 48, 96, 192 px

    python training/train_detail.py --out detail.safetensors --work WORKDIR --steps 7000 [--resume]

Half of the pieces are *worn* as photographs are (blur, area, halo, noise, JPEG), half are clean, as the
pictures of deeper levels are; the network is told which.  Loss: L1 and 0.8 L1 of the gradients at all three
sizes, and 0.15 L1 between the result, shrunk, and what the camera saw before noise and JPEG.

The packaged weights saw about 4,700 steps of 8 pieces on one shared core, resumed three times: what wears a
piece and the weights of the losses changed at step 500, the number of steps at 1,500, rate and precision at
2,500 (``--minutes 32 --rate 1e-3 --bfloat16``).  One run with these settings gives a network like it, not
its bytes.
"""

import argparse
import math
import time
from pathlib import Path

import cv2
import numpy as np
import torch
from detail_pictures import Pictures
from numpy.typing import NDArray
from safetensors.torch import load_file, save_file
from torch import Tensor
from torch.nn import functional

from wzviewer.worker.models.builtin.detail.network import DetailNetwork

PIECE_PX, FACTOR, BATCH, POOL, EMA = 192, 8, 8, 160, 0.998
SIZE_WEIGHTS = (0.25, 0.35, 1.0)
FRESH_EVERY = 8  # steps per new picture
FloatArray = NDArray[np.float32]


class Pool:
    """The last `POOL` pictures; draws pieces of any of them, at a random reduction."""

    def __init__(self, seed: int) -> None:
        self.maker, self.random = Pictures(seed), np.random.default_rng(seed + 1)
        self.kept = [self.maker.picture() for _ in range(POOL // 2)]

    def refresh(self) -> None:
        """Makes one new picture and forgets the oldest."""
        self.kept.append(self.maker.picture())
        if len(self.kept) > POOL:
            self.kept.pop(0)

    def piece(self) -> FloatArray:
        """Returns one (192, 192, 3) truth in 0..1."""
        r = self.random
        picture = self.kept[r.integers(len(self.kept))]
        size = int(PIECE_PX * min(math.exp(abs(r.normal(0, 0.45))), 3.2))
        x, y = r.integers(0, picture.shape[1] - size + 1), r.integers(0, picture.shape[0] - size + 1)
        piece = cv2.resize(
            picture[y : y + size, x : x + size], (PIECE_PX, PIECE_PX), interpolation=cv2.INTER_AREA
        )
        piece = np.rot90(piece, int(r.integers(4)))[:, :: int(r.choice((-1, 1)))]
        result = np.ascontiguousarray(piece).astype(np.float32) / 255
        if r.random() < 0.12:  # out of focus as a whole: stays so
            result = cv2.GaussianBlur(result, (0, 0), math.exp(r.uniform(1.0, 2.9)))
        return result[..., r.permutation(3)] if r.random() < 0.3 else result

    def batch(self) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Truth (n, 3, 192, 192), input (n, 3, 24, 24), the same before noise, and the flags (n,)."""
        truths = [self.piece() for _ in range(BATCH)]
        flags = self.random.random(BATCH) < 0.5
        pairs = [seen(truth, bool(flag), self.random) for truth, flag in zip(truths, flags, strict=True)]
        stack = [truths, [pair[0] for pair in pairs], [pair[1] for pair in pairs]]
        planes = [torch.from_numpy(np.stack(part)).permute(0, 3, 1, 2).contiguous() for part in stack]
        return planes[0], planes[1], planes[2], torch.from_numpy(flags).float()


def seen(truth: FloatArray, worn: bool, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Returns what a camera an eighth as fine sees of it, with and without noise and compression."""
    side = PIECE_PX // FACTOR
    optics = random.uniform(0.3, 1.0) if worn else random.uniform(0.1, 0.6)
    if random.random() < 0.8:
        truth = cv2.GaussianBlur(truth, (0, 0), optics * FACTOR)
    small = cv2.resize(truth, (side, side), interpolation=cv2.INTER_AREA)
    if not worn:
        return small, small
    if random.random() < 0.4:
        small = small + np.float32(random.uniform(0, 0.7)) * (small - cv2.GaussianBlur(small, (0, 0), 1.0))
    plain = np.clip(small, 0, 1)
    noisy = plain + random.normal(0, random.uniform(0, 3.5) / 255, plain.shape).astype(np.float32)
    noisy = np.clip(noisy * 255 + 0.5, 0, 255).astype(np.uint8)
    if random.random() < 0.6:
        quality = int(random.integers(60, 97))
        noisy = cv2.imdecode(
            cv2.imencode(".jpg", noisy, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_COLOR
        )
    return noisy.astype(np.float32) / 255, plain


def detail_loss(made: list[Tensor], truth: Tensor, observed: Tensor) -> tuple[Tensor, dict[str, float]]:
    """The loss of the module docstring and its parts."""
    level, slope = torch.zeros(()), torch.zeros(())
    for image, weight in zip(made, SIZE_WEIGHTS, strict=True):
        target = functional.avg_pool2d(truth, truth.shape[-1] // image.shape[-1])
        level = level + weight * (image - target).abs().mean()
        for axis in (2, 3):
            slope = slope + 0.5 * weight * (image - target).diff(dim=axis).abs().mean()
    shrunk = (functional.avg_pool2d(made[-1], FACTOR) - observed).abs().mean()
    total = level + 0.8 * slope + 0.15 * shrunk
    parts = {"level": level, "slope": slope, "shrunk": shrunk}
    return total, {name: float(value.detach()) for name, value in parts.items()}


def save(network: DetailNetwork, path: Path, half: bool) -> None:
    """Writes the weights whole or not at all."""
    state = {name: (v.half() if half else v).contiguous() for name, v in network.state_dict().items()}
    scratch = path.with_suffix(".part")
    save_file(state, str(scratch))
    scratch.replace(path)


def learning_rate(step: int, progress: float, peak: float) -> float:
    """Warm-up, then a cosine over the steps or the time that there is."""
    fade = 0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * min(progress, 1.0)))
    return peak * min(1.0, (step + 1) / 200) * fade


def train(arguments: argparse.Namespace) -> None:
    """Runs until the steps or the minutes are over, saving the averaged weights every 100 steps."""
    network, average, work = DetailNetwork(), DetailNetwork(), Path(arguments.work)
    first = 0
    if arguments.resume:
        network.load_state_dict(load_file(str(work / "last.safetensors")))
        first = int((work / "step").read_text())
    average.load_state_dict(network.state_dict())
    network.to(memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), 1e-3, (0.9, 0.99), weight_decay=1e-4)
    pool, history, started = Pool(arguments.seed + first), dict[str, float](), time.monotonic()
    for step in range(first, arguments.steps):
        progress = max(step / arguments.steps, (time.monotonic() - started) / 60 / arguments.minutes)
        if progress > 1:
            break
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(step, progress, arguments.rate)
        if step % FRESH_EVERY == 0:
            pool.refresh()
        truth, image, observed, worn = pool.batch()
        with torch.autocast("cpu", torch.bfloat16, enabled=arguments.bfloat16):
            made = network(image.to(memory_format=torch.channels_last), worn)
        total, parts = detail_loss([picture.float() for picture in made], truth, observed)
        optimizer.zero_grad(set_to_none=True)
        total.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), 0.5)
        optimizer.step()
        keep = min(EMA, 1 - 1 / (1 + 0.2 * (step - first + 1)))
        with torch.no_grad():
            for slow, fast in zip(average.parameters(), network.parameters(), strict=True):
                slow.lerp_(fast, 1 - keep)
        history = {k: 0.99 * history.get(k, v) + 0.01 * v for k, v in parts.items()}
        if (step + 1) % 100 == 0:
            line = " ".join(f"{name} {value:.5f}" for name, value in history.items())
            print(f"{step + 1} {time.monotonic() - started:.0f}s {line}", flush=True)
        if (step + 1) % 100 == 0:
            save(network, work / "last.safetensors", half=False)
            (work / "step").write_text(str(step + 1))
            save(average, Path(arguments.out), half=True)
    save(average, Path(arguments.out), half=True)


def main() -> None:
    """Reads the command line and trains."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--steps", type=int, default=7000)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--rate", type=float, default=1.2e-3, help="peak of the learning rate")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bfloat16", action="store_true", help="faster where the processor has it")
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    Path(arguments.work).mkdir(parents=True, exist_ok=True)
    torch.manual_seed(arguments.seed)
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    train(arguments)


if __name__ == "__main__":
    main()
