"""Pictures of a lens with distortion, as a pinhole camera with the same matrix would see them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
#: Of each pixel of the pinhole camera, column and row in the picture, and whether they are in it.
Grid = tuple[Reals, Reals, NDArray[np.bool_]]


@dataclass(frozen=True)
class Lens:
    """OpenCV's camera matrix and its coefficients k1, k2, p1, p2, k3; the middle of the first pixel is (0, 0)."""

    matrix: Reals
    coefficients: Sequence[float]

    def grid(self, size: tuple[int, int], margin: int = 0) -> Grid:
        """The pixels of a picture of this size, and of a margin around it."""
        width, height = size
        columns = np.arange(-margin, width + margin)
        rows = np.arange(-margin, height + margin)
        x, y = np.meshgrid((columns - self.matrix[0, 2]) / self.matrix[0, 0],
                           (rows - self.matrix[1, 2]) / self.matrix[1, 1])
        bent_x, bent_y = self._bend(x, y)
        source_x = self.matrix[0, 0] * bent_x + self.matrix[0, 2]
        source_y = self.matrix[1, 1] * bent_y + self.matrix[1, 2]
        inside = (source_x >= -0.5) & (source_x < width - 0.5) & (source_y >= -0.5) & (source_y < height - 0.5)
        return source_x, source_y, inside & (x * x + y * y < self._reach())

    def _bend(self, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Where the lens shows what a pinhole camera shows at (x, y), both relative to the focal length."""
        k1, k2, p1, p2, k3 = self.coefficients
        square = x * x + y * y
        radial = 1 + square * (k1 + square * (k2 + square * k3))
        return (x * radial + 2 * p1 * x * y + p2 * (square + 2 * x * x),
                y * radial + p1 * (square + 2 * y * y) + 2 * p2 * x * y)

    def _reach(self) -> float:
        """The square of the radius at which the polynomial turns back; beyond, it shows nothing real."""
        k1, k2, _, _, k3 = self.coefficients
        turns = np.roots([7 * k3, 5 * k2, 3 * k1, 1.0])
        return min((float(turn.real) for turn in turns if abs(turn.imag) < 1e-9 and turn.real > 0), default=math.inf)


def nearest(picture: NDArray[Any], grid: Grid) -> NDArray[Any]:
    """Each pixel has the value of one pixel of the picture, or 0 outside."""
    columns, rows, inside = grid
    height, width = picture.shape[:2]
    column = np.clip(np.floor(columns + 0.5), 0, width - 1).astype(np.intp)
    row = np.clip(np.floor(rows + 0.5), 0, height - 1).astype(np.intp)
    return np.where(inside, picture[row, column], 0).astype(picture.dtype)


def bilinear(picture: NDArray[np.uint8], grid: Grid) -> NDArray[np.uint8]:
    """Each pixel of a colour picture is mixed from four of them, or is black outside."""
    columns, rows, inside = grid
    height, width = picture.shape[:2]
    x, y = np.clip(columns, 0, width - 1), np.clip(rows, 0, height - 1)
    left = np.minimum(x.astype(np.intp), width - 2)
    top = np.minimum(y.astype(np.intp), height - 2)
    right_share, low_share = (x - left)[:, :, None], (y - top)[:, :, None]
    upper = picture[top, left] * (1 - right_share) + picture[top, left + 1] * right_share
    lower = picture[top + 1, left] * (1 - right_share) + picture[top + 1, left + 1] * right_share
    mixed = np.rint(upper * (1 - low_share) + lower * low_share)
    return np.where(inside[:, :, None], mixed, 0).astype(np.uint8)
