"""Metadata in Croissant 1.0 for a set that stays where it is."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..data import SPLITS, sha256
from ..folders import write_json
from .samples import Sample

#: Terms of the vocabulary that map to themselves in `cr:`.
TERMS = ("citeAs column equivalentProperty extract field fileProperty fileObject fileSet format includes isLiveDataset "
         "jsonPath key md5 parentField path recordSet references regex repeated replace samplingRate separator source "
         "subField transform").split()
CONTEXT: dict[str, Any] = {term: f"cr:{term}" for term in TERMS} | {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "rai": "http://mlcommons.org/croissant/RAI/",
    "sc": "https://schema.org/",
}
TYPES = {str: "sc:Text", int: "sc:Integer", float: "sc:Float"}


def write_croissant(root: Path, samples: Sequence[Sample], folder: Path, out: Path) -> None:
    """Writes croissant.json, whose paths lead from the folder `out` to the set."""
    there = Path(os.path.relpath(root.resolve(), out.resolve())).as_posix()
    splits = [split for split in SPLITS if any(sample.split == split for sample in samples)]
    write_json(folder / "croissant.json", {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": "labelled-images",
        "description": "Images of coated workpieces in the course of sanding, with labels of the sanded area. In a "
                       f"record, file_name is relative to {there}/SPLIT, other paths are relative to {there}",
        "distribution": [_metadata(root, there, split) for split in splits],
        "recordSet": [_records(split, [sample for sample in samples if sample.split == split]) for split in splits],
    } | _origin(root))


def _origin(root: Path) -> dict[str, Any]:
    """Version and licence of a set of the program."""
    path = root / "dataset.json"
    recipe = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if not str(recipe.get("format")).startswith("robofin-images/"):
        return {}
    if any(workpiece["origin"]["kind"] == "asset" for workpiece in recipe["workpieces"]):
        return {"version": recipe["version"]}  # the licence is that of the parts, which the set does not know
    return {"version": recipe["version"], "license": ["https://spdx.org/licenses/MIT",
                                                      "https://spdx.org/licenses/Apache-2.0"]}


def _metadata(root: Path, there: str, split: str) -> dict[str, Any]:
    path = root / split / "metadata.jsonl"
    return {
        "@type": "cr:FileObject",
        "@id": f"{split}/metadata.jsonl",
        "name": f"{split}/metadata.jsonl",
        "contentUrl": f"{there}/{split}/metadata.jsonl",
        "encodingFormat": "application/jsonlines",
        "contentSize": f"{path.stat().st_size} B",
        "sha256": sha256(path),
    }


def _records(split: str, samples: Sequence[Sample]) -> dict[str, Any]:
    """The lines of a split, with the keys under which every line has one text or number."""
    kinds = {key: {type(sample.row.values.get(key)) for sample in samples} for key in samples[0].row.values}
    plain = {key: found for key, found in kinds.items() if found <= {str} or found <= {int, float}}
    records = {
        "@type": "cr:RecordSet",
        "@id": split,
        "name": split,
        "description": f"One record for each image of {split}",
        "field": [_field(split, key, float if float in found else next(iter(found))) for key, found in plain.items()],
    }
    return records | {"key": {"@id": f"{split}/id"}} if "id" in plain else records


def _field(split: str, key: str, kind: type) -> dict[str, Any]:
    return {
        "@type": "cr:Field",
        "@id": f"{split}/{key}",
        "name": f"{split}/{key}",
        "description": key,
        "dataType": TYPES[kind],
        "source": {"fileObject": {"@id": f"{split}/metadata.jsonl"}, "extract": {"column": key}},
    }
