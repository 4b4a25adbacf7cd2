"""Trains the built-in depth network on endless procedural scenes and writes ``depth.safetensors``.

    one process makes pictures ->  a pool of the last few thousand  -> this one trains, averages, saves

    python training/train_depth.py --out depth.safetensors --work WORKDIR --minutes 40 [--resume --rate 8e-4]

Losses: with f(d) = sqrt(d + 0.02) and every disparity term masked by "not sky",
2 mean|f(p) - f(g)| + 0.5 scale-and-shift-invariant + 0.8 multi-scale gradients + 0.5 sky cross entropy.
"""

import argparse
import math
import multiprocessing as mp
import time
from pathlib import Path
from queue import Empty
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.torch import load_file, save_file
from torch import Tensor
from torch.nn import functional

from wzviewer.worker.models.builtin.depth.network import DepthNetwork

SHAPES = ((144, 96), (112, 112), (96, 144))
SHARES = (0.7, 0.15, 0.15)
BATCH, POOL, EMA = 16, 420, 0.997
WARM = 30  # batches before the first step
Batch = tuple[NDArray[np.uint8], NDArray[np.float16], NDArray[np.bool_]]


def make_scenes(seed: int, outbox: Any) -> None:  # noqa: ANN401
    """Fills the queue with batches of fresh scenes, all of one shape each, until killed."""
    from depth_kinds import sample

    cv2.setNumThreads(1)
    random = np.random.default_rng(seed)
    while True:
        width, height = SHAPES[random.choice(3, p=SHARES)]
        parts: list[tuple[Any, ...]] = []
        while len(parts) < BATCH:
            made = sample(int(random.integers(1 << 62)), width, height)
            if made is not None:
                parts.append(made)
        color, disparity, sky = (np.stack(column) for column in zip(*parts, strict=True))
        outbox.put((color, disparity.astype(np.float16), sky))


class Pool:
    """The last `POOL` batches per process lifetime; mixes samples of equal shape."""

    def __init__(self, inbox: Any, random: np.random.Generator) -> None:  # noqa: ANN401
        self.inbox, self.random = inbox, random
        self.kept: dict[tuple[int, ...], list[Batch]] = {}
        self.fresh: list[Batch] = []
        self.made = 0

    def drain(self) -> None:
        """Takes what the scene process has finished; waits only while there is little."""
        while True:
            try:
                batch: Batch = self.inbox.get(self.made < WARM, 300)
            except Empty:
                return
            self.made += 1
            kept = self.kept.setdefault(batch[0].shape, [])
            kept.append(batch)
            if len(kept) > POOL:
                kept.pop(0)

    def draw(self) -> Batch:
        """Sixteen pictures of one shape, from anywhere in the pool."""
        self.drain()
        shapes = list(self.kept)
        sizes = np.array([len(self.kept[s]) for s in shapes], float)
        kept = self.kept[shapes[self.random.choice(len(shapes), p=sizes / sizes.sum())]]
        picks = [
            (kept[self.random.integers(len(kept))], int(self.random.integers(BATCH))) for _ in range(BATCH)
        ]
        return tuple(np.stack([batch[k][i] for batch, i in picks]) for k in range(3))  # type: ignore[return-value]


def to_tensors(batch: Batch, random: np.random.Generator) -> tuple[Tensor, Tensor, Tensor]:
    """Images (n, 3, h, w), disparity and sky (n, h/2, w/2), flipped and recoloured by chance."""
    image = torch.from_numpy(batch[0]).float().div(255).permute(0, 3, 1, 2)
    disparity, sky = torch.from_numpy(batch[1]).float(), torch.from_numpy(batch[2]).float()
    flip = torch.from_numpy(random.random(BATCH) < 0.5)
    image[flip], disparity[flip], sky[flip] = (
        image[flip].flip(-1),
        disparity[flip].flip(-1),
        sky[flip].flip(-1),
    )
    gamma = torch.from_numpy(np.exp(random.normal(0, 0.18, (BATCH, 1, 1, 1)))).float()
    gain = torch.from_numpy(np.exp(random.normal(0, 0.12, (BATCH, 3, 1, 1)))).float()
    image = (image.clamp(1e-3, 1) ** gamma * gain).clamp(0, 1)
    grey = torch.from_numpy(random.random(BATCH) < 0.06)
    image[grey] = image[grey].mean(1, keepdim=True).expand(-1, 3, -1, -1)
    return image, disparity, sky


def depth_loss(p: Tensor, logit: Tensor, g: Tensor, sky: Tensor) -> tuple[Tensor, dict[str, float]]:
    """The loss of the module docstring and its parts; all (n, h, w)."""
    w = 1 - sky
    count = w.sum((1, 2)) + 1
    fp, fg = (p + 0.02).sqrt(), (g + 0.02).sqrt()
    level = ((fp - fg).abs() * w).sum() / w.sum()
    invariant = _aligned(p, g, w, count)
    gradient = torch.zeros(())
    for k in range(4):
        e, m = (fp - fg)[:, :: 1 << k, :: 1 << k] * w[:, :: 1 << k, :: 1 << k], w[:, :: 1 << k, :: 1 << k]
        mx, my = m[:, :, 1:] * m[:, :, :-1], m[:, 1:] * m[:, :-1]
        gradient = gradient + ((e[:, :, 1:] - e[:, :, :-1]).abs() * mx).sum() / (mx.sum() + 1)
        gradient = gradient + ((e[:, 1:] - e[:, :-1]).abs() * my).sum() / (my.sum() + 1)
    entropy = functional.binary_cross_entropy_with_logits(logit, sky)
    total = 2 * level + 0.5 * invariant + 0.2 * gradient + 0.5 * entropy
    parts = {"level": level, "invariant": invariant, "gradient": gradient, "sky": entropy}
    return total, {name: float(v.detach()) for name, v in parts.items()}


def _aligned(p: Tensor, g: Tensor, w: Tensor, count: Tensor) -> Tensor:
    """Mean residual after the best scale and shift per picture, relative to the spread of truth."""
    mean_p, mean_g = (p * w).sum((1, 2)) / count, (g * w).sum((1, 2)) / count
    dp, dg = (p - mean_p[:, None, None]) * w, (g - mean_g[:, None, None]) * w
    factor = ((dp * dg).sum((1, 2)) / ((dp * dp).sum((1, 2)) + 1e-3)).clamp(0.1, 10).detach()
    residual = (factor[:, None, None] * dp - dg).abs().sum((1, 2)) / count
    return (residual / (dg.abs().sum((1, 2)) / count + 0.05)).mean()


def save(network: DepthNetwork, path: Path, half: bool) -> None:
    """Writes the weights whole or not at all."""
    state = {name: (v.half() if half else v).contiguous() for name, v in network.state_dict().items()}
    scratch = path.with_suffix(".part")
    save_file(state, str(scratch))
    scratch.replace(path)


def learning_rate(step: int, progress: float, peak: float) -> float:
    """Warm-up, then a cosine over the time that there is."""
    return (
        peak * min(1.0, (step + 1) / 80) * (0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * min(progress, 1.0))))
    )


def train(arguments: argparse.Namespace, pool: Pool, random: np.random.Generator) -> None:
    """Runs until the minutes are over, saving the averaged weights every two."""
    network, average = DepthNetwork(), DepthNetwork()
    work, started, saved, seen = Path(arguments.work), time.monotonic(), time.monotonic(), 0
    if arguments.resume:
        network.load_state_dict(load_file(str(work / "last.safetensors")))
    average.load_state_dict(network.state_dict())
    optimizer = torch.optim.AdamW(network.parameters(), 1e-3, (0.9, 0.98), weight_decay=0.01)
    history: dict[str, float] = {}
    while (progress := (time.monotonic() - started) / 60 / arguments.minutes) < 1:
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(seen, progress, arguments.rate)
        image, disparity, sky = to_tensors(pool.draw(), random)
        guess, logit = network(image)
        total, parts = depth_loss(guess, logit, disparity, sky)
        optimizer.zero_grad(set_to_none=True)
        total.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimizer.step()
        seen += 1
        keep = min(EMA, 1 - 1 / (1 + 0.2 * seen))
        with torch.no_grad():
            for slow, fast in zip(average.parameters(), network.parameters(), strict=True):
                slow.lerp_(fast, 1 - keep)
        history = {k: 0.98 * history.get(k, v) + 0.02 * v for k, v in parts.items()}
        if seen % 25 == 0:
            line = " ".join(f"{k} {v:.4f}" for k, v in history.items())
            print(f"{seen} {progress:.3f} scenes {pool.made * BATCH} {line}", flush=True)
        if time.monotonic() - saved > 120:
            saved = time.monotonic()
            save(network, work / "last.safetensors", half=False)
            save(average, work / "average.safetensors", half=True)
    save(network, work / "last.safetensors", half=False)
    save(average, Path(arguments.out), half=True)


def main() -> None:
    """Reads the command line, starts the scene process, trains."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--minutes", type=float, default=40)
    parser.add_argument("--rate", type=float, default=2.5e-3, help="peak of the learning rate")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    Path(arguments.work).mkdir(parents=True, exist_ok=True)
    torch.manual_seed(arguments.seed)
    torch.set_num_threads(1)
    context = mp.get_context("spawn")
    queue = context.Queue(40)
    maker = context.Process(target=make_scenes, args=(arguments.seed, queue), daemon=True)
    maker.start()
    try:
        random = np.random.default_rng(arguments.seed + 1)
        train(arguments, Pool(queue, random), random)
    finally:
        maker.terminate()


if __name__ == "__main__":
    main()
