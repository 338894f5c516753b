"""Counts of pixels, and the figures that follow from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .data import IGNORE, Bytes, Mask

#: Draws of the bootstrap.
DRAWS = 2000


@dataclass(frozen=True)
class Counts:
    """Pixels that are rightly, wrongly and not marked."""

    true: int
    false: int
    missed: int

    def __add__(self, other: Counts) -> Counts:
        return Counts(self.true + other.true, self.false + other.false, self.missed + other.missed)

    @property
    def iou(self) -> float:
        """Intersection over union; 1 where both are empty, and so 0 where one is."""
        union = self.true + self.false + self.missed
        return self.true / union if union else 1.0

    @property
    def dice(self) -> float:
        """Twice the intersection over the sum of both areas; 1 where both are empty."""
        areas = 2 * self.true + self.false + self.missed
        return 2 * self.true / areas if areas else 1.0

    @property
    def precision(self) -> float | None:
        """The share of the marked pixels that is right; none where nothing is marked."""
        marked = self.true + self.false
        return self.true / marked if marked else None

    @property
    def recall(self) -> float | None:
        """The share of the wanted pixels that is marked; none where nothing is wanted."""
        wanted = self.true + self.missed
        return self.true / wanted if wanted else None


def count(marked: Mask, label: Bytes, target: int) -> Counts:
    """Compares a mask with a label. Pixels to be ignored are not counted."""
    counted, wanted = label != IGNORE, label == target
    return Counts(
        int(np.count_nonzero(marked & wanted)),
        int(np.count_nonzero(marked & counted & ~wanted)),
        int(np.count_nonzero(~marked & wanted)),
    )


@dataclass(frozen=True)
class Summary:
    """Figures of many images: the mean IoU of the images with its interval of 95 %, others from summed counts."""

    mean_iou: float
    low: float
    high: float
    pooled_iou: float
    dice: float
    precision: float | None
    recall: float | None


def summarise(counts: Sequence[Counts], groups: Sequence[str]) -> Summary:
    """Figures of images that belong to `groups`, which the bootstrap draws as a whole."""
    ious = np.array([each.iou for each in counts])
    low, high = _interval(ious, groups)
    pooled = sum(counts, Counts(0, 0, 0))
    return Summary(float(ious.mean()), low, high, pooled.iou, pooled.dice, pooled.precision, pooled.recall)


def _interval(values: np.ndarray[tuple[int], np.dtype[np.float64]], groups: Sequence[str]) -> tuple[float, float]:
    """The bootstrap's percentiles of the mean, over groups (Efron 1979; Field and Welsh 2007)."""
    names, member = np.unique(np.asarray(groups), return_inverse=True)
    sums, sizes = np.bincount(member, weights=values), np.bincount(member)
    draws = np.random.default_rng(0).integers(len(names), size=(DRAWS, len(names)))
    low, high = np.percentile(sums[draws].sum(axis=1) / sizes[draws].sum(axis=1), [2.5, 97.5])
    return float(low), float(high)
