"""Drawn sets of labelled images for the tests of perception, which are skipped where its packages are missing."""

import importlib.util
import json
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

NEEDED = ("torch", "torchvision", "transformers", "segmentation_models_pytorch", "safetensors")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
if MISSING:
    NOT_TESTED = f"robofin_perception is NOT TESTED: {', '.join(MISSING)} missing; pip install \"./python[perception]\""
    warnings.warn(NOT_TESTED, stacklevel=1)
    pytest.skip(NOT_TESTED, allow_module_level=True)

import torch

WIDTH, HEIGHT = 64, 48
#: Coating and metal of the same grey value: no threshold tells them apart.
COATING, METAL = np.array([60.0, 118.0, 176.0]), np.array([107.0, 107.0, 107.0])


def draw(random: np.random.Generator, sanded: float) -> tuple[np.ndarray, np.ndarray]:
    """A workpiece on a table, sanded on this share of its width from the left or the right, with its label."""
    label = np.zeros((HEIGHT, WIDTH), dtype=np.uint8)
    left, top = random.integers(3, 14), random.integers(3, 10)
    right, bottom = random.integers(46, 61), random.integers(34, 45)
    label[top:bottom, left:right] = 2
    part = label[top:bottom, left:right]
    start = 0 if random.random() < 0.5 else round((1 - sanded) * part.shape[1])
    part[:, start:start + round(sanded * part.shape[1])] = 1
    image = np.empty((HEIGHT, WIDTH, 3))
    image[:] = random.uniform(40, 220)
    image[label == 1], image[label == 2] = METAL, COATING
    light = np.linspace(random.uniform(0.7, 1.0), random.uniform(1.0, 1.3), WIDTH)[None, :, None]
    return np.clip(image * light + random.normal(0, 4, image.shape), 0, 255).astype(np.uint8), label


def rewrite(root: Path, change: Callable[[str], str]) -> None:
    path = root / "train/metadata.jsonl"
    path.write_text(change(path.read_text()))


def write_set(root: Path, counts: dict[str, int], seed: int) -> Path:
    """A set in the layout of `robofin dataset images`; the first image of each split is unsanded."""
    random = np.random.default_rng(seed)
    (root / "appearance").mkdir(parents=True)
    for split, number in counts.items():
        (root / split / "images").mkdir(parents=True)
        rows = []
        for k in range(number):
            name = f"{split}-{k:02}"
            image, label = draw(random, 0.0 if k == 0 else random.uniform(0.2, 0.7))
            Image.fromarray(image).save(root / split / "images" / f"{name}.png")
            Image.fromarray(label).save(root / "appearance" / f"{name}.png")
            rows.append({"file_name": f"images/{name}.png", "id": name, "workpiece": "block", "placement": k // 2,
                         "appearance": f"appearance/{name}.png"})
        (root / split / "metadata.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return root


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)


@pytest.fixture(scope="session")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_set(tmp_path_factory.mktemp("shapes") / "set", {"train": 24, "test": 8}, 1)


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A set that a test may spoil."""
    return write_set(tmp_path / "set", {"train": 2, "test": 2}, 2)
