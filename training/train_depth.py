"""Trains the built-in depth network on endless procedural scenes and writes ``depth.safetensors``.

    one process makes pictures ->  a pool of the last few thousand  -> this one trains, averages, saves

    python training/train_depth.py --out depth.safetensors --work WORKDIR [--minutes 60 --start FILE --resume]

Runs on one CPU core (and a second for the scenes); may be killed and resumed.  Losses: with
f(d) = sqrt(d + 0.02) and every disparity term masked by "not sky", 2 mean|f(p) - f(g)|
+ 0.5 scale-and-shift-invariant + 0.6 gradients at four sizes + 0.6 cross entropy of the sky + 0.8 of what
stands.  The last is what makes things stand: a house that leans like its ground has the right mean depth
and the wrong slope, and which of the two a thing is can be learned long before its depth.

The shipped file: weights of an earlier recipe (144x96, epochs over 7000 scenes), then 1250 steps of this one
without the output of what stands, then 1447 steps with it (`--start`), then the mean of the last two
(`--mix`): between the two in figures, and by eye things on photos stand best with it.  About 70 minutes of a
third of a core; from chance, give it some hours.
"""

import argparse
import json
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

SHAPES = ((144, 96), (192, 128), (112, 112), (96, 144))
SHARES = (0.45, 0.35, 0.08, 0.12)
BATCH, POOL, EMA = 16, 250, 0.998
WARM = 16  # batches before the first step
REUSE = 3  # steps a fresh batch: scenes cost more than steps, and no two crops are the same
Batch = tuple[NDArray[np.uint8], NDArray[np.float16], NDArray[np.bool_], NDArray[np.bool_]]


def make_scenes(seed: int, outbox: Any) -> None:  # noqa: ANN401
    """Fills the queue with batches of fresh scenes, all of one shape each, until killed."""
    from depth_sample import sample

    cv2.setNumThreads(1)
    random = np.random.default_rng(seed)
    while True:
        width, height = SHAPES[random.choice(len(SHAPES), p=SHARES)]
        parts: list[tuple[Any, ...]] = []
        while len(parts) < BATCH:
            made = sample(int(random.integers(1 << 62)), width, height)
            if made is not None:
                parts.append(made)
        color, disparity, sky, upright = (np.stack(column) for column in zip(*parts, strict=True))
        outbox.put((color, disparity.astype(np.float16), sky, upright))


class Pool:
    """The last `POOL` batches of each shape; mixes samples of equal shape."""

    def __init__(self, inbox: Any, random: np.random.Generator) -> None:  # noqa: ANN401
        self.inbox, self.random = inbox, random
        self.kept: dict[tuple[int, ...], list[Batch]] = {}
        self.made = self.turn = 0

    def drain(self) -> None:
        """Takes a finished batch every `REUSE` steps; waits only while there is little."""
        self.turn += 1
        while self.made < WARM or self.turn % REUSE == 0:
            try:
                batch: Batch = self.inbox.get(self.made < WARM, 300)
            except Empty:
                return
            self.made += 1
            kept = self.kept.setdefault(batch[0].shape, [])
            kept.append(batch)
            if len(kept) > POOL:
                kept.pop(0)
            if self.made >= WARM:
                return

    def draw(self) -> Batch:
        """Sixteen pictures of one shape, from anywhere in the pool."""
        self.drain()
        shapes = list(self.kept)
        sizes = np.array([len(self.kept[s]) for s in shapes], float)
        kept = self.kept[shapes[self.random.choice(len(shapes), p=sizes / sizes.sum())]]
        picks = [
            (kept[self.random.integers(len(kept))], int(self.random.integers(BATCH))) for _ in range(BATCH)
        ]
        return tuple(np.stack([batch[k][i] for batch, i in picks]) for k in range(4))  # type: ignore[return-value]


def to_tensors(batch: Batch, random: np.random.Generator) -> tuple[Tensor, Tensor]:
    """Images (n, 3, h, w) and truth (n, 3, h/2, w/2): disparity, sky, upright; changed by chance."""
    image = torch.from_numpy(batch[0]).float().div(255).permute(0, 3, 1, 2)
    truth = torch.stack([torch.from_numpy(part).float() for part in batch[1:]], 1)
    if random.random() < 0.4:
        image, truth = _magnified(image, truth, random)
    flip = torch.from_numpy(random.random(BATCH) < 0.5)
    image[flip], truth[flip] = image[flip].flip(-1), truth[flip].flip(-1)
    return _recolored(image, random), truth


def _magnified(image: Tensor, truth: Tensor, random: np.random.Generator) -> tuple[Tensor, Tensor]:
    """A window of the pictures at the full size again: another lens, another horizon."""
    h, w = truth.shape[-2:]
    share = random.uniform(0.65, 1)
    rows, columns = int(h * share), int(w * share)
    top, left = int(random.integers(h - rows + 1)), int(random.integers(w - columns + 1))
    part = image[..., 2 * top : 2 * (top + rows), 2 * left : 2 * (left + columns)]
    image = functional.interpolate(part, size=(2 * h, 2 * w), mode="bilinear", align_corners=False)
    truth = functional.interpolate(
        truth[..., top : top + rows, left : left + columns], size=(h, w), mode="nearest"
    )
    for d, k, _ in truth:
        ground = d[k < 0.5]
        if len(ground) > 50:
            d /= torch.quantile(ground, 0.95).clamp(min=1e-3)
    truth[:, 0].clamp_(0, 2.5)
    return image, truth


def _recolored(image: Tensor, random: np.random.Generator) -> Tensor:
    """Gamma, channel gains and mixing, contrast, softness, noise, grey."""

    def drawn(*shape: int) -> Tensor:
        return torch.from_numpy(random.normal(0, 1, (BATCH, *shape))).float()

    mixing = torch.eye(3) + 0.05 * drawn(3, 3)
    image = torch.einsum("nij,njhw->nihw", mixing, image)
    image = image.clamp(1e-3, 1) ** torch.exp(0.3 * drawn(1, 1, 1)) * torch.exp(0.14 * drawn(3, 1, 1))
    mean = image.mean((1, 2, 3), keepdim=True)
    image = mean + (image - mean) * torch.exp(0.2 * drawn(1, 1, 1)) + 0.04 * drawn(1, 1, 1)
    soft = torch.from_numpy(random.random(BATCH) < 0.2)
    image[soft] = functional.avg_pool2d(image[soft], 3, 1, 1, count_include_pad=False)
    noise = torch.randn_like(image) * torch.from_numpy(random.exponential(0.012, (BATCH, 1, 1, 1))).float()
    grey = torch.from_numpy(random.random(BATCH) < 0.08)
    image[grey] = image[grey].mean(1, keepdim=True).expand(-1, 3, -1, -1)
    return (image + noise).clamp(0, 1)


def depth_loss(guess: tuple[Tensor, ...], truth: Tensor) -> tuple[Tensor, dict[str, float]]:
    """The loss of the module docstring and its parts.

    Args:
        guess: disparity, sky logit, upright logit, each (n, h, w).
        truth: (n, 3, h, w) the same as numbers and masks.
    """
    p, logit, stands = guess
    g, sky, upright = truth.unbind(1)
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
    standing = functional.binary_cross_entropy_with_logits(stands, upright, w)
    total = 2 * level + 0.5 * invariant + 0.6 * gradient + 0.6 * entropy + 0.8 * standing
    parts = {
        "level": level, "invariant": invariant, "gradient": gradient, "sky": entropy, "stands": standing,
    }  # fmt: skip
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


def started_from(state: dict[str, Tensor]) -> dict[str, Tensor]:
    """Weights to begin with; an older file has no output for what stands, which begins at zero."""
    state = {name: value.float() for name, value in state.items()}
    for name in ("out.weight", "out.bias"):
        missing = 3 - len(state[name])
        state[name] = torch.cat([state[name], torch.zeros(missing, *state[name].shape[1:])])
    return state


def mixed(state: dict[str, Tensor], other: dict[str, Tensor]) -> dict[str, Tensor]:
    """The mean of two sets of weights; an output that the other file lacks stays as it is."""
    known = len(other["out.bias"])
    other = started_from(other)
    result = {name: (value.float() + other[name]) / 2 for name, value in state.items()}
    for name in ("out.weight", "out.bias"):
        result[name][known:] = state[name][known:]
    return result


class Course:
    """Network, its running average, optimiser and how far they have come."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.network, self.average = DepthNetwork(), DepthNetwork()
        self.work, self.seen, self.minutes = Path(arguments.work), 0, 0.0
        if arguments.start:
            self.network.load_state_dict(started_from(load_file(arguments.start)))
        self.average.load_state_dict(self.network.state_dict())
        if arguments.resume and (self.work / "state.json").exists():
            self.network.load_state_dict(load_file(str(self.work / "last.safetensors")))
            self.average.load_state_dict(load_file(str(self.work / "slow.safetensors")))
            state = json.loads((self.work / "state.json").read_text())
            self.seen, self.minutes = state["seen"], state["minutes"]
        self.optimizer = torch.optim.AdamW(self.network.parameters(), 1e-3, (0.9, 0.98), weight_decay=0.01)

    def step(self, batch: tuple[Tensor, Tensor], rate: float) -> dict[str, float]:
        """One step of the optimiser and of the average; returns the parts of the loss."""
        image, truth = batch
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        with torch.autocast("cpu", torch.bfloat16):
            guess = self.network(image)
        total, parts = depth_loss(tuple(g.float() for g in guess), truth)
        self.optimizer.zero_grad(set_to_none=True)
        total.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 2.0)
        self.optimizer.step()
        self.seen += 1
        keep = min(EMA, 1 - 1 / (1 + 0.2 * self.seen))
        with torch.no_grad():
            for slow, fast in zip(self.average.parameters(), self.network.parameters(), strict=True):
                slow.lerp_(fast, 1 - keep)
        return parts

    def save(self) -> None:
        """Writes everything that a resumed run needs, and the average as it would be shipped."""
        save(self.network, self.work / "last.safetensors", half=False)
        save(self.average, self.work / "slow.safetensors", half=False)
        save(self.average, self.work / "average.safetensors", half=True)
        state = {"seen": self.seen, "minutes": self.minutes}
        (self.work / "state.json").write_text(json.dumps(state))


def train(arguments: argparse.Namespace, pool: Pool, random: np.random.Generator) -> None:
    """Runs until the minutes are over, saving every two."""
    course = Course(arguments)
    done, started, saved, first = course.minutes, time.monotonic(), time.monotonic(), course.seen
    history: dict[str, float] = {}
    while course.minutes < arguments.minutes:
        course.minutes = done + (time.monotonic() - started) / 60
        rate = learning_rate(course.seen - first, course.minutes / arguments.minutes, arguments.rate)
        parts = course.step(to_tensors(pool.draw(), random), rate)
        history = {k: 0.98 * history.get(k, v) + 0.02 * v for k, v in parts.items()}
        if course.seen % 50 == 0:
            line = " ".join(f"{k} {v:.4f}" for k, v in history.items())
            print(f"{course.seen} {course.minutes:.1f} min, {pool.made * BATCH} scenes, {line}", flush=True)
        if time.monotonic() - saved > 120:
            saved = time.monotonic()
            course.save()
    course.save()
    if arguments.mix:
        course.average.load_state_dict(mixed(course.average.state_dict(), load_file(arguments.mix)))
    save(course.average, Path(arguments.out), half=True)


def main() -> None:
    """Reads the command line, starts the scene process, trains."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--rate", type=float, default=2e-3, help="peak of the learning rate")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", help="weights to begin with instead of chance")
    parser.add_argument("--mix", help="weights to average the result with")
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    Path(arguments.work).mkdir(parents=True, exist_ok=True)
    torch.manual_seed(arguments.seed)
    torch.set_num_threads(1)
    context = mp.get_context("spawn")
    queue = context.Queue(8)
    maker = context.Process(target=make_scenes, args=(arguments.seed, queue), daemon=True)
    maker.start()
    try:
        random = np.random.default_rng(arguments.seed + 1)
        train(arguments, Pool(queue, random), random)
    finally:
        maker.terminate()


if __name__ == "__main__":
    main()
