"""What tests share: parts, and the measured campaigns of the project."""

from pathlib import Path

import numpy as np
import pytest

import robofin

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def plate() -> robofin.Mesh:
    """A plate of 60 x 40 x 6 mm, its lowest corner at the origin."""
    size = np.array([0.06, 0.04, 0.006])
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]) * size
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return robofin.Mesh(corners, [row for a, b, c, d in quads for row in ([a, b, c], [a, c, d])])


@pytest.fixture(scope="session")
def field(plate: robofin.Mesh) -> robofin.Field:
    """The plate's field at 0.5 mm."""
    return robofin.Field.bake(plate, 5e-4)


@pytest.fixture(scope="session")
def suite() -> robofin.Suite:
    """Two easy welds to grind off."""
    return robofin.suite("grinding", difficulty="easy", count=1)


@pytest.fixture(scope="session")
def trials() -> list[Path]:
    """Three trial folders that come with the project."""
    return sorted((ROOT / "data/campaigns/first-look").glob("trial-*"))
