"""Cards of results, and networks read again."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import torch
from safetensors import SafetensorError

from .data import LABELS, TARGETS
from .errors import WrongUse
from .models import Segmenter, UNet
from .sam2 import Sam2

CARD, MODEL = "run.json", "model"
FORMAT = "robofin-perception-run/1"
#: Packages that a card names with their versions.
PACKAGES = ("numpy", "pillow", "robofin", "safetensors", "segmentation-models-pytorch", "torch", "transformers")


def versions() -> dict[str, str]:
    """The installed packages that decide a result."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def find_device(name: str) -> torch.device:
    """`auto` is the GPU if there is one."""
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name == "cuda" and not torch.cuda.is_available():
        raise WrongUse("--device cuda: torch finds no GPU; cpu or auto is accepted")
    return torch.device(name)


@dataclass(frozen=True)
class Trained:
    """A network, its name, and what it was trained for."""

    name: str
    segmenter: Segmenter
    labels: str
    target: str


def read_run(folder: Path) -> Trained:
    """Opens what `train` has written."""
    path = folder / CARD
    try:
        card = json.loads(path.read_text(encoding="utf-8"))
        options, kind = card["options"], card["kind"]
        if card["format"] != FORMAT or options["labels"] not in LABELS or options["target"] not in TARGETS:
            raise WrongUse(f"{path} has the format {card['format']!r}; {FORMAT!r} is accepted")
        if not (folder / MODEL).is_dir():
            raise WrongUse(f"{folder / MODEL} is missing; a run has the folder of its network")
        if kind == UNet.kind:
            width, height = options["size"]
            segmenter: Segmenter = UNet.read(folder / MODEL, (width, height))
        else:
            segmenter = Sam2.read(str(folder / MODEL))
    except (OSError, ValueError, KeyError, TypeError, SafetensorError) as error:
        raise WrongUse(f"--run {folder} cannot be read: {type(error).__name__}, {error}") from None
    return Trained(str(folder), segmenter, options["labels"], options["target"])
