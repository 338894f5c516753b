"""Training on labelled images, drawn from one set or from two."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from torch import Tensor
from torch.nn import functional

from .data import IGNORE, TARGETS, Record, fingerprint, open_example, read_split, sha256
from .errors import PerceptionError, WrongUse
from .folders import new_folder, write_json
from .models import Segmenter, Tensors, UNet, sha256_of
from .runs import CARD, FORMAT, MODEL, find_device, versions
from .sam2 import Sam2

#: The part of the updates at the end over which the rate falls to zero.
COOLING = 0.2
#: Rates at which each network starts: random weights need larger ones than trained weights.
RATES = {"unet": 1e-3, "sam2-random": 1e-3}
FINE_TUNING_RATE = 2e-5
#: Width and height of the U-Net's input.
SIZE = (256, 256)


@dataclass(frozen=True)
class Options:
    """Options of a training run. `None` is the default of the network."""

    data: Path
    model: str = "unet"
    real: Path | None = None
    real_fraction: float = 0.2
    updates: int = 512
    batch: int = 4
    lr: float | None = None
    labels: str = "appearance"
    target: str = "sanded"
    seed: int = 0
    size: tuple[int, int] | None = None
    device: str = "auto"
    cache: Path | None = None

    def complete(self) -> Options:
        """With the network's defaults; refuses what does not belong to it."""
        unet = self.model == UNet.kind
        if self.size and not unet:
            raise WrongUse(f"--size belongs to --model unet; the size of {self.model} is in its configuration")
        if self.cache and unet:
            raise WrongUse("--cache belongs to SAM 2; unet has no frozen part whose outputs could be kept")
        return replace(
            self,
            lr=self.lr or RATES.get(self.model, FINE_TUNING_RATE),
            size=(self.size or SIZE) if unet else None,
            real_fraction=self.real_fraction if self.real else 0.0,
        )


def create(model: str, seed: int, size: tuple[int, int] | None = None) -> Segmenter:
    """A network by its name, with random weights of a seed or with trained ones."""
    torch.manual_seed(seed)
    if model == UNet.kind:
        return UNet.random(size or SIZE)
    return Sam2.random() if model == "sam2-random" else Sam2.read(model)


class Store:
    """Encoded images with their targets: each is opened and encoded once, then kept in memory or in a folder.

    Without a frozen part an encoded image is small, and is kept in the device's memory.
    """

    def __init__(self, segmenter: Segmenter, wanted: int, cache: Path | None) -> None:
        self.segmenter, self.wanted, self.cache = segmenter, wanted, cache
        self.encoder = sha256_of(segmenter.frozen())
        self.place = torch.device("cpu") if self.encoder else next(segmenter.parameters()).device
        self.kept: dict[Record, Tensors] = {}

    def __getitem__(self, record: Record) -> Tensors:
        if record in self.kept:
            return self.kept[record]
        example = open_example(record)
        present = torch.tensor(float((example.label == self.wanted).any()))
        encoded = {"target": self.segmenter.target(example, self.wanted), "present": present}
        if self.cache:
            name = f"{sha256(record.image, record.label)}-{self.encoder}.safetensors"
            return encoded | self._file(self.cache / name, record)
        encoded |= self.segmenter.encode(example)
        self.kept[record] = {name: part.to(self.place) for name, part in encoded.items()}
        return self.kept[record]

    def _file(self, path: Path, record: Record) -> Tensors:
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            aside = path.with_suffix(".part")
            save_file(self.segmenter.encode(open_example(record)), aside)
            aside.rename(path)
        return load_file(path)


def draws(options: Options) -> Iterator[list[Record]]:
    """Batches without end. Every set is dealt like a pack of cards: no image twice before each was drawn."""
    random = np.random.default_rng(options.seed)
    roots = [options.data] + ([options.real] if options.real else [])
    sets = [read_split(root, "train", options.labels) for root in roots]
    packs: list[list[Record]] = [[] for _ in sets]
    while True:
        batch = []
        for _ in range(options.batch):
            which = int(options.real is not None and random.random() < options.real_fraction)
            if not packs[which]:
                packs[which] = [sets[which][k] for k in random.permutation(len(sets[which]))]
            batch.append(packs[which].pop())
        yield batch


def loss_parts(answer: tuple[Tensor, Tensor], target: Tensor, present: Tensor) -> Tensors:
    """Cross-entropy of counted pixels, Dice loss of images that have the area, cross-entropy of its existence."""
    logits, presence = answer
    counted, truth = (target != IGNORE).float(), (target == 1).float()
    pixels = functional.binary_cross_entropy_with_logits(logits, truth, reduction="none")
    marked = torch.sigmoid(logits) * counted
    shared, areas = (marked * truth).sum((1, 2)), (marked + truth).sum((1, 2))
    has_area = (truth.sum((1, 2)) > 0).float()
    dice = 1 - (2 * shared + 1) / (areas + 1)
    return {
        "cross_entropy": (pixels * counted).sum() / counted.sum().clamp(min=1),
        "dice": (dice * has_area).sum() / has_area.sum().clamp(min=1),
        "presence": functional.binary_cross_entropy_with_logits(presence, present),
    }


class Curve:
    """Losses of all updates. They stay on the device until a report, since reading each would stop it each time."""

    def __init__(self, options: Options) -> None:
        self.options, self.every = options, max(options.updates // 8, 1)
        self.fresh: list[Tensor] = []
        self.rows: list[list[float]] = []

    def add(self, parts: Tensor) -> None:
        """Adds the losses of an update, and reports each eighth."""
        self.fresh.append(parts.detach())
        if len(self.fresh) == self.every:
            self.report()

    def report(self) -> None:
        """Prints the last loss. Raises `PerceptionError` if one since the last report is not finite."""
        fresh = torch.stack(self.fresh).tolist() if self.fresh else []
        self.fresh = []
        for row in fresh:
            if not all(map(math.isfinite, row)):
                raise PerceptionError(f"the loss is not finite at update {len(self.rows)}; "
                                      f"try a smaller --lr than {self.options.lr:g}")
            self.rows.append(row)
        if fresh:
            print(f"update {len(self.rows)} of {self.options.updates}: loss {sum(fresh[-1]):.3f}", file=sys.stderr)


def optimise(segmenter: Segmenter, options: Options) -> list[dict[str, float]]:
    """Trains a network in place, and returns the losses of each update."""
    device = next(segmenter.parameters()).device
    store = Store(segmenter, TARGETS[options.target], options.cache)
    assert options.lr is not None
    trained = [each for each in segmenter.parameters() if each.requires_grad]
    optimiser = torch.optim.AdamW(trained, options.lr, fused=device.type == "cuda")
    rate = torch.optim.lr_scheduler.LambdaLR(
        optimiser, lambda step: min(1.0, (1 - step / max(options.updates, 1)) / COOLING))
    curve, names = Curve(options), []
    segmenter.train()
    for _, records in zip(range(options.updates), draws(options), strict=False):
        items = [store[record] for record in records]
        batch = {name: torch.stack([item[name] for item in items]).to(device) for name in items[0]}
        target, present = batch.pop("target"), batch.pop("present")
        batch, target = segmenter.augment(batch, target)
        parts = loss_parts(segmenter(batch), target, present)
        losses, names = torch.stack(list(parts.values())), list(parts)
        optimiser.zero_grad()
        torch.autograd.backward([losses.sum()])
        optimiser.step()
        rate.step()
        curve.add(losses)
    curve.report()
    return [{name: round(part, 6) for name, part in zip([*names, "total"], [*row, sum(row)], strict=True)}
            for row in curve.rows]


def train(options: Options, out: Path) -> dict[str, Any]:
    """Trains a network and writes its run folder. Returns the card."""
    options = options.complete()
    device = find_device(options.device)
    sets = [root for root in (options.data, options.real) if root]
    for root in sets:
        read_split(root, "train", options.labels)
    with new_folder(out) as folder:
        start = time.monotonic()
        segmenter = create(options.model, options.seed, options.size).to(device)
        before = sha256_of(segmenter.frozen())
        curve = optimise(segmenter, options)
        after = sha256_of(segmenter.frozen())
        if before != after:
            raise PerceptionError("training has changed the frozen image encoder; no run was written")
        segmenter.save(folder / MODEL)
        card = {
            "format": FORMAT,
            "kind": segmenter.kind,
            "options": {name: str(each) if isinstance(each, Path) else each for name, each in asdict(options).items()},
            "device": str(device),
            "versions": versions(),
            "data": [fingerprint(root, "train") for root in sets],
            "encoder_sha256": {"before": before, "after": after},
            "weights_sha256": sha256(folder / MODEL / "model.safetensors"),
            "trained_parameters": sum(each.numel() for each in segmenter.parameters() if each.requires_grad),
            "seconds": round(time.monotonic() - start, 3),
            "loss": curve,
        }
        write_json(folder / CARD, card)
    return card
