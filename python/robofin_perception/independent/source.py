"""The set of the program whose workpieces and doses are rendered."""

import hashlib
import json
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import robofin

if TYPE_CHECKING:
    from .plan import Treatment

FORMAT = "robofin-images/"
HEAT_REACH = 0.009
"""Distance from a weld within which heat has tinted the metal [m]."""


@dataclass(frozen=True)
class Surface:
    """A workpiece: vertices [m] of shape `[n, 3]`, unit normals, triangles, and the heat of welding, 0 to 1."""

    positions: NDArray[np.float64]
    normals: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    heat: NDArray[np.float32]


class SourceSet:
    """A folder made by `robofin dataset images`."""

    def __init__(self, folder: Path) -> None:
        """Reads its recipe. Raises `WrongUse` if it is no such folder."""
        self.folder = folder
        path = folder / "dataset.json"
        try:
            text = path.read_bytes()
            recipe = json.loads(text)
        except (OSError, ValueError) as error:
            raise robofin.WrongUse(
                f"--data {folder}: {path} cannot be read ({error}); a folder of `robofin dataset images` is accepted"
            ) from error
        found = str(recipe.get("format"))
        if not found.startswith(FORMAT):
            raise robofin.WrongUse(f"--data {folder}: the format in {path} is {found}; {FORMAT}N is accepted")
        self.sha256 = hashlib.sha256(text).hexdigest()
        self.workpieces: list[str] = [workpiece["name"] for workpiece in recipe["workpieces"]]
        self.patterns: list[str] = recipe["patterns"]
        self.stages: int = recipe["stages"]

    @cache
    def surface(self, workpiece: str) -> Surface:
        """The surface of a workpiece, at the resolution of its field."""
        field = robofin.Field.read(self.folder / "fields" / f"{workpiece}.nvdb")
        mesh = field.surface()
        positions = mesh.positions
        return Surface(positions, field.normal(positions), mesh.triangles, heat(positions, field.label(positions)))

    def dose(self, workpiece: str, treatment: "Treatment") -> NDArray[np.float32]:
        """The dose at each vertex of a workpiece's surface, shape `[n]`."""
        positions = self.surface(workpiece).positions
        if treatment.kind != "stage":
            return np.full(len(positions), float(treatment.kind == "bare"), dtype=np.float32)
        fields = self.folder / "fields"
        whole = fields / f"{workpiece}.nvdb"
        dose = fields / f"{workpiece}-{treatment.pattern}" / f"stage-{treatment.stage}.nvdb"
        return with_dose(whole, dose).channel("dose", positions)


def with_dose(whole: Path, dose: Path) -> robofin.Field:
    """A field with the dose of another file.

    A NanoVDB file is a sequence of segments, so the one file followed by the other is also a file.
    """
    with tempfile.TemporaryDirectory() as folder:
        both = Path(folder) / dose.name
        both.write_bytes(whole.read_bytes() + dose.read_bytes())
        return robofin.Field.read(both)


def heat(positions: NDArray[np.float64], weld: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Heat at vertices, from 1 on a weld to 0 at the end of its reach."""
    bead = positions[weld > 0][::4]
    nearest = np.full(len(positions), np.inf)
    for block in np.array_split(bead, len(bead) // 16 + 1):
        if len(block):
            squares = ((positions[:, None] - block[None]) ** 2).sum(axis=2)
            nearest = np.minimum(nearest, squares.min(axis=1))
    return np.asarray(np.clip(1.0 - np.sqrt(nearest) / HEAT_REACH, 0.0, 1.0), dtype=np.float32)
