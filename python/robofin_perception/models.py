"""Networks that mark an area of the workpiece in a box, and say whether it exists at all."""

from __future__ import annotations

import hashlib
import sys
from abc import ABC, abstractmethod
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor, nn

from .data import IGNORE, Box, Bytes, Example, Mask

Tensors = dict[str, Tensor]


class Segmenter(nn.Module, ABC):
    """A network with masks of `grid` (width, height) that cover a frame of the image."""

    kind: str
    grid: tuple[int, int]

    @abstractmethod
    def frame(self, example: Example) -> Box:
        """The part of the image that the masks cover."""

    @abstractmethod
    def encode(self, example: Example) -> Tensors:
        """The input of `forward` for an image, in compact form; deterministic."""

    @abstractmethod
    def forward(self, batch: Tensors) -> tuple[Tensor, Tensor]:
        """Logits of masks `[n, height, width]`, and of the area's existence `[n]`."""

    @abstractmethod
    def save(self, folder: Path) -> None:
        """Writes configuration and weights (safetensors) in the form of the network's library."""

    def frozen(self) -> Tensors:
        """The weights that decide what `encode` gives, and that training must not change."""
        return {}

    def augment(self, batch: Tensors, target: Tensor) -> tuple[Tensors, Tensor]:
        """A random variant of images and targets."""
        return batch, target

    def target(self, example: Example, wanted: int) -> Tensor:
        """The label on the grid: 1 wanted, 0 other, 255 not counted, as are the pixels outside the box."""
        label = np.where(example.inside() & (example.label != IGNORE), example.label == wanted, IGNORE).astype(np.uint8)
        frame = Image.fromarray(label).crop(self.frame(example))
        return torch.from_numpy(np.array(frame.resize(self.grid, Image.Resampling.NEAREST)))

    @torch.no_grad()
    def predict(self, example: Example) -> Mask:
        """The marked pixels of an image, clipped to the box; none where the network denies that the area exists."""
        device = next(self.parameters()).device
        logits, presence = self({name: part[None].to(device) for name, part in self.encode(example).items()})
        marked = np.zeros(example.label.shape, dtype=np.bool_)
        if presence.item() > 0:
            left, top, right, bottom = self.frame(example)
            small = Image.fromarray(logits[0].float().cpu().numpy())
            full = small.resize((right - left, bottom - top), Image.Resampling.BILINEAR)
            marked[top:bottom, left:right] = np.asarray(full) > 0
        return marked & example.inside()


def sha256_of(tensors: Tensors) -> str | None:
    """The hash of names and values, in the order of the names; none of nothing."""
    digest = hashlib.sha256()
    for name in sorted(tensors):
        digest.update(name.encode())
        digest.update(tensors[name].detach().cpu().contiguous().view(torch.uint8).numpy().tobytes())
    return digest.hexdigest() if tensors else None


def pixels(image: Bytes, frame: Box, size: tuple[int, int]) -> Tensor:
    """The frame of an image, resized, as bytes `[3, height, width]`."""
    resized = Image.fromarray(image).crop(frame).resize(size, Image.Resampling.BILINEAR)
    return torch.from_numpy(np.array(resized)).permute(2, 0, 1).contiguous()


class UNet(Segmenter):
    """A small U-Net (Ronneberger et al. 2015) on the box and a margin of an eighth around it.

    Its fourth channel is the box. It starts from random weights. On a GPU it computes in 16 bits (bfloat16).
    """

    kind = "unet"

    def __init__(self, net: Any, grid: tuple[int, int]) -> None:
        super().__init__()
        self.net, self.grid = net, grid

    @classmethod
    def random(cls, grid: tuple[int, int]) -> UNet:
        from segmentation_models_pytorch import Unet

        return cls(Unet("tu-resnet18", encoder_depth=4, encoder_weights=None, decoder_channels=(128, 64, 32, 16),
                        in_channels=4, aux_params={"classes": 1, "pooling": "max", "dropout": None}), grid)

    @classmethod
    def read(cls, folder: Path, grid: tuple[int, int]) -> UNet:
        from segmentation_models_pytorch import Unet

        with redirect_stdout(sys.stderr):  # which the library tells of loading
            return cls(Unet.from_pretrained(folder), grid)

    def frame(self, example: Example) -> Box:
        left, top, right, bottom = example.box
        across, down = (right - left) // 8, (bottom - top) // 8
        height, width = example.label.shape
        return max(0, left - across), max(0, top - down), min(width, right + across), min(height, bottom + down)

    def encode(self, example: Example) -> Tensors:
        frame = self.frame(example)
        box = Image.fromarray(example.inside().astype(np.uint8) * 255).crop(frame)
        channel = torch.from_numpy(np.array(box.resize(self.grid, Image.Resampling.NEAREST)))
        return {"image": torch.cat([pixels(example.image, frame, self.grid), channel[None]])}

    def forward(self, batch: Tensors) -> tuple[Tensor, Tensor]:
        image = batch["image"].float() / 127.5 - 1.0
        if image.is_cuda:  # the order of values with which its 16-bit convolutions are fastest
            image = image.contiguous(memory_format=torch.channels_last)
        with torch.autocast(image.device.type, torch.bfloat16, enabled=image.is_cuda):
            masks, presence = self.net(image)
        return masks[:, 0].float(), presence[:, 0].float()

    def augment(self, batch: Tensors, target: Tensor) -> tuple[Tensors, Tensor]:
        """Mirrored along either axis or none."""
        axes = [axis for axis in (-1, -2) if torch.rand(()) < 0.5]
        return {"image": batch["image"].flip(axes)}, target.flip(axes)

    def save(self, folder: Path) -> None:
        self.net.save_pretrained(folder)
