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
#: Classes that a network can segment.
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


@dataclass(frozen=True)
class Row:
    """A line of `metadata.jsonl`, and where it stands."""

    where: str
    metadata: Path
    values: dict[str, Any]

    def file(self, key: str) -> str:
        """The path under a key."""
        path = self.values.get(key)
        if not isinstance(path, str):
            raise WrongUse(f"{self.where}: \"{key}\" is {path!r}; the path of a file is accepted")
        return path

    @property
    def id(self) -> str:
        """The name of the image."""
        return str(self.values.get("id", Path(self.file("file_name")).stem))


def read_split(root: Path, split: str, labels: str) -> list[Record]:
    """The images that `metadata.jsonl` in the split's folder lists, in its order."""
    return [_record(root, row, labels) for row in read_rows(root, split)]


def read_rows(root: Path, split: str) -> list[Row]:
    """The lines of `metadata.jsonl` in the split's folder."""
    metadata = root / split / "metadata.jsonl"
    try:
        lines = metadata.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise WrongUse(f"{metadata} is missing; a set has a folder for each split, with a metadata.jsonl") from None
    except (OSError, UnicodeDecodeError) as error:
        raise WrongUse(f"{metadata} cannot be read: {error}") from None
    rows = [_row(metadata, number, line) for number, line in enumerate(lines, 1) if line.strip()]
    if not rows:
        raise WrongUse(f"{metadata} lists no image; at least one is accepted")
    if len({row.id for row in rows}) < len(rows):
        raise WrongUse(f"{metadata} has the same id twice; each image has its own")
    return rows


def _row(metadata: Path, number: int, line: str) -> Row:
    where = f"{metadata}, line {number}"
    try:
        values = json.loads(line)
    except json.JSONDecodeError as error:
        raise WrongUse(f"{where}: {error}; one JSON object a line is accepted") from None
    if not isinstance(values, dict):
        raise WrongUse(f"{where} is a {type(values).__name__}; a JSON object is accepted")
    return Row(where, metadata, values)


def _record(root: Path, row: Row, labels: str) -> Record:
    image, label = row.metadata.parent / row.file("file_name"), root / row.file(labels)
    values = row.values
    group = f"{values.get('workpiece')}, placement {values['placement']}" if "placement" in values else row.id
    return Record(row.id, image, label, group)


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
    image = open_picture(path)
    if image.mode not in modes:
        raise WrongUse(f"{path} has the mode {image.mode}; {', '.join(modes)} are accepted")
    return image


def open_picture(path: Path) -> Image.Image:
    """Opens a picture that the metadata name."""
    try:
        image = Image.open(path)
        image.load()
    except FileNotFoundError:
        raise WrongUse(f"{path} is missing; the metadata name it") from None
    except (UnidentifiedImageError, OSError, SyntaxError) as error:
        raise WrongUse(f"{path} cannot be opened as an image: {error}") from None
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
    """Identity of the images: hashes of the split's metadata and, if there is one, of the set's `dataset.json`."""
    marker, metadata = root / "dataset.json", root / split / "metadata.jsonl"
    return {
        "folder": str(root),
        "split": split,
        "metadata_sha256": sha256(metadata),
        "dataset_sha256": sha256(marker) if marker.is_file() else None,
    }
