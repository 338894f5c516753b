"""Trivial answers, which a network must beat."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .data import BACKGROUND, SANDED, Example, Mask
from .metrics import count

#: Shares of red, green and blue in a grey value (ITU-R BT.601).
GREY = np.array([0.299, 0.587, 0.114])


def whole(example: Example) -> Mask:
    """All of the workpiece, whose outline is taken from the label."""
    workpiece: Mask = example.label != BACKGROUND
    return workpiece


def otsu(example: Example, brighter: bool, within: Mask) -> Mask:
    """The brighter or the darker of the two classes into which Otsu's threshold parts the grey values `within`."""
    grey = np.rint(example.image @ GREY).astype(np.int64)
    above: Mask = grey > threshold(grey[within])
    return np.logical_and(above if brighter else ~above, within)


def threshold(grey: NDArray[np.int64]) -> int:
    """The grey value that separates two classes with the largest variance between them (Otsu 1979)."""
    histogram = np.bincount(grey, minlength=256).astype(np.float64)
    below, sums = np.cumsum(histogram), np.cumsum(histogram * np.arange(len(histogram)))
    above = below[-1] - below
    with np.errstate(divide="ignore", invalid="ignore"):
        between = below * above * (sums / below - (sums[-1] - sums) / above) ** 2
    return int(np.argmax(np.nan_to_num(between)))


def prefers_brighter(examples: Iterable[Example], target: int) -> bool:
    """True if the brighter class has the higher mean IoU on these images, which are not the tested ones."""
    gain = 0.0
    for example in examples:
        box = example.inside()
        bright, dark = (count(otsu(example, side, box), example.label, target) for side in (True, False))
        gain += bright.iou - dark.iou
    return gain >= 0


def usual_side(target: int) -> bool:
    """The side to take without images to learn it from: bare metal is the brighter one."""
    return target == SANDED
