"""Parquet files as Hugging Face's `datasets` and its hub read them, with a card."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow
import pyarrow.parquet

from ..data import LABELS
from ..errors import WrongUse
from .samples import Sample, shards

IMAGE = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
#: Rows that are read together: the hub's viewer wants few megabytes.
ROW_GROUP = 100


def write_parquet(root: Path, samples: Sequence[Sample], folder: Path, size: int) -> None:
    """Writes data/SPLIT-00000-of-0000N.parquet and README.md."""
    labels = [label for label in LABELS if all(label in sample.labels() for sample in samples)]
    schema = _schema(root, samples)
    (folder / "data").mkdir()
    splits = []
    for split, parts in shards(samples, size):
        splits.append(split)
        for number, part in enumerate(parts):
            name = f"{split}-{number:05}-of-{len(parts):05}.parquet"
            table = _table(part, labels, schema)
            pyarrow.parquet.write_table(table, folder / "data" / name, row_group_size=ROW_GROUP)
    (folder / "README.md").write_text(_card(root, splits, labels), encoding="utf-8")


def _schema(root: Path, samples: Sequence[Sample]) -> pyarrow.Schema:
    """The types of all facts, the same for each file."""
    rows = [_facts(sample) for sample in samples]
    keys = dict.fromkeys(key for row in rows for key in row)
    try:
        return pyarrow.Table.from_pylist([{key: row.get(key) for key in keys} for row in rows]).schema
    except (pyarrow.ArrowInvalid, pyarrow.ArrowTypeError, OverflowError) as error:
        raise WrongUse(f"--data {root}: metadata fit no table: {error}; one type for each key is accepted") from None


def _facts(sample: Sample) -> dict[str, Any]:
    """The drawn scene is a text: its parts differ from image to image, and its seed has 64 bits without sign."""
    facts = sample.facts()
    scene = facts.get("scene")
    return facts if scene is None or isinstance(scene, str) else facts | {"scene": json.dumps(scene)}


def _table(samples: Sequence[Sample], labels: list[str], schema: pyarrow.Schema) -> pyarrow.Table:
    table = pyarrow.Table.from_pylist([_facts(sample) for sample in samples], schema=schema)
    images = {"image": "file_name"} | {label: label for label in labels}
    for place, (column, key) in enumerate(images.items()):
        paths = [sample.path(key) for sample in samples]
        cells = [{"bytes": path.read_bytes(), "path": path.name} for path in paths]
        table = table.add_column(place, pyarrow.field(column, IMAGE), pyarrow.array(cells, IMAGE))
    features = {column: {"_type": "Image"} for column in images}
    return table.replace_schema_metadata({"huggingface": json.dumps({"info": {"features": features}})})


def _card(root: Path, splits: list[str], labels: list[str]) -> str:
    """The set's own card with other files; a short one if it has none."""
    card = root / "README.md"
    text = card.read_text(encoding="utf-8") if card.is_file() else "# Labelled images\n"
    head, body = re.fullmatch(r"(?:---\n(.*?)---\n)?(.*)", text, re.DOTALL).groups()  # type: ignore[union-attr]
    head = re.sub(r"^configs:\n(?:[ -].*\n)*", "", head or "", flags=re.MULTILINE)
    files = "".join(f"  - split: {split}\n    path: data/{split}-*\n" for split in splits)
    sections = re.split(r"^(?=## )", body, flags=re.MULTILINE)
    first = re.sub(r"^!\[.*\n\n?", "", sections[0], flags=re.MULTILINE).strip()
    others = "".join(section for section in sections[1:] if not section.startswith("## Files"))
    meanings = "".join(f"| `{label}` | index label by {what}: 0 background, 1 sanded, 2 unsanded, 255 ignore |\n"
                       for label, what in (("appearance", "what is seen"), ("dose", "the dose")) if label in labels)
    return (f"---\n{head}configs:\n- config_name: default\n  data_files:\n{files}---\n\n{first}\n\n## Columns\n\n"
            f"| column | holds |\n|---|---|\n| `image` | the image, eight-bit sRGB |\n{meanings}"
            f"| `view` | camera matrix, distortion, pose, boxes, welds |\n"
            f"| `scene` | camera, light, material and sensor as JSON |\n"
            f"| others | one line of the set's `metadata.jsonl` |\n\n{others}")
