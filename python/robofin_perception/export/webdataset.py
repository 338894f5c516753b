"""Shards for WebDataset: tar files whose neighbouring members with one key are a sample."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Sequence
from pathlib import Path

from ..errors import WrongUse
from .samples import Sample, shards


def write_webdataset(samples: Sequence[Sample], folder: Path, size: int) -> None:
    """Writes SPLIT-000000.tar and so on. The same set gives the same bytes."""
    for split, parts in shards(samples, size):
        for number, part in enumerate(parts):
            with tarfile.open(folder / f"{split}-{number:06}.tar", "w", format=tarfile.GNU_FORMAT) as tar:
                for sample in part:
                    _add(tar, sample)


def _add(tar: tarfile.TarFile, sample: Sample) -> None:
    if "." in sample.id or "/" in sample.id:
        raise WrongUse(f"{sample.row.where}: the id {sample.id!r} has a dot or slash; WebDataset ends a key there")
    members = {f"{label}.png": sample.path(label).read_bytes() for label in sample.labels()}
    members["json"] = json.dumps(sample.facts(), sort_keys=True).encode()
    image = sample.path("file_name")
    members[image.suffix[1:]] = image.read_bytes()
    for suffix, content in sorted(members.items()):
        member = tarfile.TarInfo(f"{sample.id}.{suffix}")
        member.size = len(content)
        tar.addfile(member, io.BytesIO(content))
