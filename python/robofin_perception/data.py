"""Sets of labelled images: which there are, their pixels, and the box around the workpiece."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from .errors import WrongUse

#: Index labels.
BACKGROUND, SANDED, UNSANDED, IGNORE = 0, 1, 2, 255
#: What a network can be asked for.
TARGETS = {"sanded": SANDED, "unsanded": UNSANDED}
LABELS = ("appearance", "dose")
SPLITS = ("train", "validation", "test")

#: Left, top, right, bottom in pixels; right and bottom are outside.
Box = tuple[int, int, int, int]
Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Record:
    """An image of a set, and what it is called. Images of one `group` are not independent."""

    id: str
    image: Path
    label: Path
    group: str


@dataclass(frozen=True)
class Example:
    """Pixels `[height, width, 3]`, index labels `[height, width]`, and the box around the workpiece."""

    image: Bytes
    label: Bytes
    box: Box

    def inside(self) -> Mask:
        """The pixels in the box."""
        inside = np.zeros(self.label.shape, dtype=np.bool_)
        left, top, right, bottom = self.box
        inside[top:bottom, left:right] = True
        return inside


def read_split(root: Path, split: str, labels: str) -> list[Record]:
    """The images that `metadata.jsonl` in the split's folder lists, in its order."""
    metadata = root / split / "metadata.jsonl"
    try:
        lines = metadata.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise WrongUse(f"{metadata} is missing; a set has a folder for each split, with a metadata.jsonl") from None
    except (OSError, UnicodeDecodeError) as error:
        raise WrongUse(f"{metadata} cannot be read: {error}") from None
    records = [_record(root, metadata, number, labels) for number in enumerate(lines, 1) if number[1].strip()]
    if not records:
        raise WrongUse(f"{metadata} lists no image; at least one is accepted")
    if len({record.id for record in records}) < len(records):
        raise WrongUse(f"{metadata} has the same id twice; each image has its own")
    return records


def _record(root: Path, metadata: Path, numbered: tuple[int, str], labels: str) -> Record:
    number, line = numbered
    where = f"{metadata}, line {number}"
    try:
        row = json.loads(line)
    except json.JSONDecodeError as error:
        raise WrongUse(f"{where}: {error}; one JSON object a line is accepted") from None
    if not isinstance(row, dict):
        raise WrongUse(f"{where} is a {type(row).__name__}; a JSON object is accepted")
    for key in ("file_name", labels):
        if not isinstance(row.get(key), str):
            raise WrongUse(f"{where}: \"{key}\" is {row.get(key)!r}; the path of a file is accepted")
    name = str(row.get("id", Path(row["file_name"]).stem))
    group = f"{row.get('workpiece')}, placement {row['placement']}" if "placement" in row else name
    return Record(name, metadata.parent / row["file_name"], root / row[labels], group)


def open_example(record: Record) -> Example:
    """Opens an image and its label, and finds the box around the workpiece."""
    image = _pixels(record.image, ("RGB", "RGBA", "L", "P")).convert("RGB")
    label = np.asarray(_pixels(record.label, ("L", "P")), dtype=np.uint8)
    if image.size != (label.shape[1], label.shape[0]):
        raise WrongUse(f"{record.label} has {label.shape[1]}x{label.shape[0]} pixels and {record.image} has "
                       f"{image.width}x{image.height}; equal sizes are accepted")
    unknown = set(np.unique(label).tolist()) - {BACKGROUND, SANDED, UNSANDED, IGNORE}
    if unknown:
        raise WrongUse(f"{record.label} has the label {min(unknown)}; 0 background, 1 sanded, 2 unsanded and "
                       "255 ignore are accepted")
    return Example(np.asarray(image), label, _box(label, record.label))


def _pixels(path: Path, modes: tuple[str, ...]) -> Image.Image:
    try:
        image = Image.open(path)
        image.load()
    except FileNotFoundError:
        raise WrongUse(f"{path} is missing; the metadata name it") from None
    except (UnidentifiedImageError, OSError, SyntaxError) as error:
        raise WrongUse(f"{path} cannot be opened as an image: {error}") from None
    if image.mode not in modes:
        raise WrongUse(f"{path} has the mode {image.mode}; {', '.join(modes)} are accepted")
    return image


def _box(label: Bytes, path: Path) -> Box:
    rows, columns = np.nonzero(label != BACKGROUND)
    if len(rows) == 0:
        raise WrongUse(f"{path} has no pixel of the workpiece; the box around it is the prompt")
    return int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1


def sha256(*paths: Path) -> str:
    """The hash of one file, or of several after another."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def fingerprint(root: Path, split: str) -> dict[str, Any]:
    """Which images these are: hashes of the split's metadata and, if there is one, of the set's `dataset.json`."""
    marker, metadata = root / "dataset.json", root / split / "metadata.jsonl"
    return {
        "folder": str(root),
        "split": split,
        "metadata_sha256": sha256(metadata),
        "dataset_sha256": sha256(marker) if marker.is_file() else None,
    }
