"""Difference of two trainings that were measured on the same images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .metrics import DRAWS

#: IoU of the images of one evaluation, by name.
Ious = Mapping[str, float]


@dataclass(frozen=True)
class Difference:
    """Mean over the images of IoU with minus without, and its interval of 95 %; no interval without two seeds."""

    mean: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a mean IoU over the seeds of training, pooled over trainings, and its degrees of freedom."""

    deviation: float
    freedom: int

    @staticmethod
    def of(means: Sequence[Sequence[float]]) -> Noise | None:
        """Pools the seeds of each training; nothing if none has two."""
        freedom = sum(len(seeds) - 1 for seeds in means if seeds)
        if freedom == 0:
            return None
        square = sum(float(((np.array(seeds) - np.mean(seeds)) ** 2).sum()) for seeds in means if seeds)
        return Noise((square / freedom) ** 0.5, freedom)


def difference(with_it: Sequence[Ious], without: Sequence[Ious], groups: Mapping[str, str],
               noise: Noise | None) -> Difference:
    """Compares the means over the seeds of two trainings, image by image.

    The bootstrap draws whole `groups` of images (Efron 1979); to each draw the noise of both means over seeds is added,
    of Student's distribution with the freedom of `noise`.
    """
    names = sorted(groups)
    mean = [np.mean([[seed[name] for name in names] for seed in seeds], axis=0) for seeds in (with_it, without)]
    values = mean[0] - mean[1]
    if noise is None:
        return Difference(float(values.mean()), None, None)
    found, member = np.unique([groups[name] for name in names], return_inverse=True)
    sums, sizes = np.bincount(member, weights=values), np.bincount(member)
    random = np.random.default_rng(0)
    drawn = random.integers(len(found), size=(DRAWS, len(found)))
    spread = noise.deviation * (1 / len(with_it) + 1 / len(without)) ** 0.5
    draws = sums[drawn].sum(axis=1) / sizes[drawn].sum(axis=1) + spread * random.standard_t(noise.freedom, DRAWS)
    low, high = np.percentile(draws, [2.5, 97.5])
    return Difference(float(values.mean()), float(low), float(high))
