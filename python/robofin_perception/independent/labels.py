"""Index labels of a picture: where the coating is gone, where it is intact, and where that is undecided.

The rule is that of the program's images (docs/images.md, step 5 of the method).
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Labels = NDArray[np.uint8]
Mask = NDArray[np.bool_]

BACKGROUND, SANDED, UNSANDED, IGNORE = 0, 1, 2, 255
SANDED_FROM = 0.75
UNSANDED_TO = 0.25
LEAST_CONTRAST = 0.06
GAMMA = 2.2


def code(light: Floats, exposure: float) -> Floats:
    """Display code, 0 to 1, of linear light at an exposure; shape `[h, w, 3]`."""
    return np.asarray(np.clip(light * exposure, 0.0, 1.0) ** (1.0 / GAMMA), dtype=np.float32)


def seen_share(seen: Floats, unsanded: Floats, bare: Floats) -> Floats:
    """Share of the coating that is gone by appearance, from codes of shape `[h, w, 3]`; NaN where contrast lacks."""
    contrast = np.linalg.norm(bare - unsanded, axis=2)
    known = contrast >= LEAST_CONTRAST
    share = np.full(contrast.shape, np.nan, dtype=np.float32)
    from_unsanded, from_bare = (np.linalg.norm(seen - other, axis=2)[known] for other in (unsanded, bare))
    share[known] = from_unsanded / (from_unsanded + from_bare)
    return share


def labels(share: Floats, on_part: Mask) -> Labels:
    """Labels from the share of the coating that is gone, shape `[h, w]`; a NaN is undecided."""
    classes = np.full(share.shape, IGNORE, dtype=np.uint8)
    classes[share >= SANDED_FROM] = SANDED
    classes[share <= UNSANDED_TO] = UNSANDED
    classes[~on_part] = BACKGROUND
    bordered = np.zeros(share.shape, dtype=np.bool_)
    for own, other in neighbours(classes):
        bordered[own] |= (classes[other] != IGNORE) & (classes[other] != classes[own])
    classes[bordered] = IGNORE
    return classes


def neighbours(array: Labels) -> list[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """Pairs of equal regions of an array, the second shifted by a pixel to each of four sides."""
    rows, columns = (slice(0, size) for size in array.shape)
    first, last = slice(0, -1), slice(1, None)
    across, down = ((rows, first), (rows, last)), ((first, columns), (last, columns))
    return [across, across[::-1], down, down[::-1]]


def agreement(one: Labels, other: Labels) -> float | None:
    """Share of equal classes among the pixels with a class in both labels; None if there are none."""
    both = np.isin(one, (SANDED, UNSANDED)) & np.isin(other, (SANDED, UNSANDED))
    return float(np.mean(one[both] == other[both])) if both.any() else None
