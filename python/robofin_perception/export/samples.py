"""The images of a set, with their files and what is known of them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..data import LABELS, SPLITS, Row, read_rows
from ..errors import WrongUse

#: Keys of a row that are paths of files.
PATHS = ("file_name", *LABELS, "view", "instances", "depth", "amodal")


@dataclass(frozen=True)
class Sample:
    """An image of the set in the folder `root`."""

    root: Path
    split: str
    row: Row

    @property
    def id(self) -> str:
        """The name of the image."""
        return self.row.id

    def path(self, key: str) -> Path:
        """The path of a file that exists: of the image (`file_name`), a label, or a part of the view."""
        base = self.row.metadata.parent if key == "file_name" else self.root
        path = base / self.row.file(key)
        if not path.is_file():
            raise WrongUse(f"{path} is missing; {self.row.where} names it")
        return path

    def labels(self) -> list[str]:
        """The labels that the image has."""
        return [name for name in LABELS if name in self.row.values]

    def view(self) -> dict[str, Any]:
        """The camera and the pose of the workpiece."""
        path = self.path("view")
        try:
            view = json.loads(path.read_text(encoding="utf-8"))
            return {key: value for key, value in view.items() if key != "files"}
        except (OSError, ValueError, AttributeError) as error:
            raise WrongUse(f"{path} cannot be read: {error}; a view of `robofin dataset images` is accepted") from None

    def facts(self) -> dict[str, Any]:
        """All that is known of the image, with the contents of its view, without paths."""
        known = {key: value for key, value in self.row.values.items() if key not in PATHS}
        known |= {"id": self.id, "split": self.split}
        return known | {"view": self.view()} if "view" in self.row.values else known


def read_set(root: Path) -> list[Sample]:
    """All images, by split and name."""
    splits = [split for split in SPLITS if (root / split / "metadata.jsonl").is_file()]
    if not splits:
        raise WrongUse(f"--data {root} has no train/metadata.jsonl; a set of `robofin dataset images` is accepted")
    found = [Sample(root, split, row) for split in splits for row in read_rows(root, split)]
    return sorted(found, key=lambda sample: (SPLITS.index(sample.split), sample.id))


def shards(samples: Sequence[Sample], size: int) -> Iterator[tuple[str, list[list[Sample]]]]:
    """Each split with its images in parts of `size`."""
    for split in SPLITS:
        of_split = [sample for sample in samples if sample.split == split]
        if of_split:
            yield split, [of_split[start:start + size] for start in range(0, len(of_split), size)]
