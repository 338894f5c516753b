"""Workpieces as meshes in PLY, in millimetres around the centre of their box."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import WrongUse

try:
    import robofin
except ImportError as error:  # also of the sources without the compiled part
    raise ModuleNotFoundError(str(error), name="robofin") from error

Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Solid:
    """Vertices [mm] around `centre_mm`, which is given in the frame of the part; normals and triangles."""

    positions_mm: Reals
    normals: Reals
    triangles: NDArray[np.uint32]
    centre_mm: Reals

    @classmethod
    def read(cls, path: Path) -> Solid:
        """The surface of a workpiece's field."""
        try:
            mesh = robofin.Field.read(path).surface()
        except (robofin.RoboFinError, OSError) as error:
            raise WrongUse(f"{path} cannot be read: {error}; the field of a workpiece is accepted") from None
        positions, triangles = mesh.positions, mesh.triangles
        centre = 500.0 * (positions.min(axis=0) + positions.max(axis=0))
        return cls(1000.0 * positions - centre, normals_of(positions, triangles), triangles, centre)

    def write(self, path: Path) -> None:
        """Writes PLY as text."""
        with path.open("w", encoding="ascii", newline="\n") as file:
            reals = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
            file.write(f"ply\nformat ascii 1.0\ncomment unit: mm\nelement vertex {len(self.positions_mm)}\n{reals}"
                       f"element face {len(self.triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
            np.savetxt(file, np.hstack([self.positions_mm, self.normals]), fmt="%.4f")
            np.savetxt(file, self.triangles, fmt="3 %d %d %d")

    def info(self) -> dict[str, float]:
        """Box and diameter [mm], with the keys of models_info.json."""
        least, most = self.positions_mm.min(axis=0), self.positions_mm.max(axis=0)
        box = {f"min_{axis}": float(value) for axis, value in zip("xyz", least)}
        size = {f"size_{axis}": float(value) for axis, value in zip("xyz", most - least)}
        return {"diameter": diameter(self.positions_mm)} | box | size


def normals_of(positions: Reals, triangles: NDArray[np.uint32]) -> Reals:
    """At each vertex the mean normal of its triangles, weighted by area."""
    corners = positions[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(positions)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], across)
    return np.asarray(sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300))


def diameter(points: Reals) -> float:
    """The largest distance between two points.

    A pair at this distance or more has both its points at least as far from the origin as the distance lacks from
    the largest radius, so few points are compared.
    """
    radius = np.linalg.norm(points, axis=1)
    far = points[np.argmax(radius)]
    far = points[np.argmax(np.linalg.norm(points - far, axis=1))]
    bound = float(np.linalg.norm(points - far, axis=1).max())
    left = points[radius >= bound - radius.max() - 1e-9]
    squares = (left**2).sum(axis=1)
    blocks = (np.s_[start:start + 256] for start in range(0, len(left), 256))
    return math.sqrt(max(float((squares[block, None] + squares - 2 * left[block] @ left.T).max()) for block in blocks))
