"""A set of labelled images in the formats of other readers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..folders import new_folder
from .samples import read_set


@dataclass(frozen=True)
class Export:
    """An export: the set, the format, and the images of each file of formats that have shards."""

    data: Path
    to: str
    shard: int


def export(request: Export, out: Path) -> int:
    """Writes a set to the new folder `out`. Returns the number of images."""
    samples = read_set(request.data)
    with new_folder(out) as folder:
        if request.to == "bop":
            from .bop import write_bop

            write_bop(samples, folder)
        elif request.to == "webdataset":
            from .webdataset import write_webdataset

            write_webdataset(samples, folder, request.shard)
        elif request.to == "parquet":
            from .parquet import write_parquet

            write_parquet(request.data, samples, folder, request.shard)
        else:
            from .croissant import write_croissant

            write_croissant(request.data, samples, folder, out)
    return len(samples)
