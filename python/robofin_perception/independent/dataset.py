"""The folder of a set: pictures, labels and metadata, written so that an interruption leaves no half of anything."""

import json
from pathlib import Path
from typing import Any

from PIL import Image

import robofin

from .labels import Labels
from .plan import SPLITS, Planned

FORMAT = "robofin-independent/2"
RECIPE_FILE = "dataset.json"


class Dataset:
    """A set that is being rendered."""

    def __init__(self, folder: Path, recipe: dict[str, Any], resume: bool) -> None:
        """Starts a folder or goes on with it. Raises `WrongUse` if it exists otherwise."""
        self.folder = folder
        path = folder / RECIPE_FILE
        if folder.exists() and not resume:
            raise robofin.WrongUse(f"--out {folder}: it exists; a new folder, or --resume to go on, is accepted")
        if folder.exists() and any(folder.iterdir()):
            check(path, recipe)
        for split in SPLITS:
            (folder / split / "images").mkdir(parents=True, exist_ok=True)
        for kind in ("appearance", "dose"):
            (folder / kind).mkdir(exist_ok=True)
        replace(path, (json.dumps(recipe, indent=2) + "\n").encode())
        self.records = {split: self._read(split) for split in SPLITS}

    def done(self) -> set[str]:
        """Names of the pictures that are complete."""
        return {name for records in self.records.values() for name in records}

    def add(self, planned: Planned, image: Image.Image, labels: dict[str, Labels], record: dict[str, Any]) -> None:
        """Writes a picture, its labels, and last its line of metadata."""
        file = f"images/{planned.id}.png"
        write_image(self.folder / planned.split / file, image)
        paths = {kind: f"{kind}/{planned.id}.png" for kind in labels}
        for kind, label in labels.items():
            write_image(self.folder / paths[kind], Image.fromarray(label))
        self.records[planned.split][planned.id] = {"file_name": file, "id": planned.id} | record | paths
        self._write(planned.split)

    def _read(self, split: str) -> dict[str, dict[str, Any]]:
        path = self.folder / split / "metadata.jsonl"
        lines = path.read_text().splitlines() if path.exists() else []
        records = (json.loads(line) for line in lines)
        return {record["id"]: record for record in records}

    def _write(self, split: str) -> None:
        lines = (json.dumps(self.records[split][name]) + "\n" for name in sorted(self.records[split]))
        replace(self.folder / split / "metadata.jsonl", "".join(lines).encode())


def check(path: Path, recipe: dict[str, Any]) -> None:
    """Raises `WrongUse` unless a folder was started with this recipe."""
    try:
        started = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise robofin.WrongUse(
            f"--out {path.parent}: {path.name} cannot be read ({error}); a set of this command is accepted"
        ) from error
    for key, value in recipe.items():
        if started.get(key) != value:
            raise robofin.WrongUse(
                f"--out {path.parent}: started with {key} {started.get(key)!r}, not {value!r}; the same is accepted"
            )


def recipe_of(options: dict[str, Any], source_sha256: str, version: str) -> dict[str, Any]:
    """Settings that determine every picture."""
    return {"format": FORMAT} | options | {"bpy": version, "source_sha256": source_sha256}


def write_image(path: Path, image: Image.Image) -> None:
    """Writes a PNG beside its path, and renames it."""
    beside = path.with_suffix(".part")
    image.save(beside, "PNG")
    beside.replace(path)


def replace(path: Path, content: bytes) -> None:
    """Writes a file beside its path, and renames it."""
    beside = path.with_suffix(".part")
    beside.write_bytes(content)
    beside.replace(path)

