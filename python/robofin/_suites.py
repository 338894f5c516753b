"""Suites: welds to be finished, by process, split and difficulty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ._robofin import Mesh, Model, RoboFinError, Task, Tool, Workpiece, WrongUse, weld

#: Widths of beads by difficulty [m]; height and length follow.
WIDTHS = {"easy": 6e-3, "medium": 8e-3, "hard": 10e-3}
#: Lengths of welds by difficulty [m].
LENGTHS = {"easy": (0.025, 0.04), "medium": (0.04, 0.07), "hard": (0.07, 0.11)}
#: Attempts to place a weld.
SEEDS = 8
#: All exposures.
ANY_EXPOSURE = (0.0, 1.0)


@dataclass(frozen=True)
class Suite:
    """Tasks with the tool and the model that suit them."""

    name: str
    process: str
    tasks: tuple[Task, ...]
    tool: Tool
    model: Model

    def __deepcopy__(self, _: dict[int, object]) -> Suite:
        """A suite never changes: it is its own copy."""
        return self


def suite(process: str = "grinding", split: str = "train", difficulty: str = "easy", *, count: int = 4,
          voxel: float = 5e-4) -> Suite:
    """Welds on parts of a split: "train", or "held-out" with parts that training never sees.

    The same arguments give the same welds, bit for bit. They are made once in a process.
    """
    if split not in PARTS:
        raise WrongUse(f"split is {split!r}, and {' or '.join(map(repr, PARTS))} is accepted")
    if difficulty not in WIDTHS:
        raise WrongUse(f"difficulty is {difficulty!r}, and {', '.join(map(repr, WIDTHS))} are accepted")
    if process not in TOOLS:
        raise WrongUse(f"process is {process!r}, and {' or '.join(map(repr, TOOLS))} is accepted")
    if count < 1:
        raise WrongUse(f"count is {count}, and 1 or more is accepted")
    return _suite(process, split, difficulty, count, voxel)


@lru_cache(maxsize=16)
def _suite(process: str, split: str, difficulty: str, count: int, voxel: float) -> Suite:
    parts = PARTS[split]
    make = Task.grinding if process == "grinding" else Task.sanding
    tasks = tuple(make(_welded(parts[k % len(parts)](), difficulty, k, voxel)) for k in range(count))
    name = f"{process}/{split}/{difficulty}"
    return Suite(name, process, tasks, Tool(TOOLS[process]), Model(process))


def _welded(part: Mesh, difficulty: str, number: int, voxel: float) -> Workpiece:
    """A part with a weld; a seed whose weld finds no place gives way to the next.

    Where no weld fits that has the exposure of its difficulty, any exposure is accepted: a convex part hides no place.
    """
    refusal: RoboFinError | None = None
    for exposure in (None, ANY_EXPOSURE):
        for attempt in range(SEEDS):
            try:
                return weld(part, seed=1000 * number + attempt, voxel=voxel, difficulty=difficulty,
                            width=WIDTHS[difficulty], length=LENGTHS[difficulty], exposure=exposure)
            except RoboFinError as error:
                refusal = error
    raise WrongUse(f"no weld of {SEEDS} seeds fits: {refusal}")


def _box(size: tuple[float, float, float]) -> Mesh:
    """A box of a size [m], its lowest corner at the origin."""
    corner = [[size[axis] * (k >> axis & 1) for axis in range(3)] for k in range(8)]
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    triangles = [row for a, b, c, d in quads for row in ([a, b, c], [a, c, d])]
    return Mesh(np.array(corner), np.array(triangles, dtype=np.uint32))


def _prism(outline: NDArray[np.float64], length: float) -> Mesh:
    """A convex outline, counter-clockwise in y and z [m], along x."""
    count = len(outline)
    ends = [np.column_stack([np.full(count, x), outline]) for x in (0.0, length)]
    after = [(k + 1) % count for k in range(count)]
    sides = [row for k in range(count) for row in ([k, after[k], count + after[k]], [k, count + after[k], count + k])]
    caps = [row for k in range(1, count - 1) for row in ([0, k + 1, k], [count, count + k, count + k + 1])]
    return Mesh(np.concatenate(ends), np.array(sides + caps, dtype=np.uint32))


def _cylinder(radius: float, length: float) -> Mesh:
    """A round bar of a radius and a length [m] along x."""
    turn = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    return _prism(radius * np.column_stack([np.cos(turn), np.sin(turn)]), length)


#: Parts of each split.
PARTS: dict[str, tuple[Callable[[], Mesh], ...]] = {
    "train": (lambda: _box((0.12, 0.08, 0.01)), Mesh.bundled),
    "held-out": (lambda: _cylinder(0.06, 0.12), lambda: _box((0.09, 0.09, 0.02))),
}
#: Tools of each process.
TOOLS = {"grinding": "wheel:radius=40mm,width=12mm", "sanding": "pad:radius=8mm"}
