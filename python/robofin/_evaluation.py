"""Evaluation of policies on suites of welds, with baselines and intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._robofin import Batch, WrongUse
from ._suites import Suite

#: Draws of the bootstrap.
DRAWS = 2000
#: Steps after which an episode is given up; none lasts so long.
MOST_STEPS = 100_000

Observations = NDArray[np.float32]
Actions = NDArray[np.float32]
Policy = Callable[[Observations], Actions]


@dataclass(frozen=True)
class Evaluation:
    """Figures of episodes, one row each, in the columns `names`.

    `left` is the share of bead or coating that is left, `gouge_depth` in m, volumes in m³, `force_error` in N rms, times in
    s; `removed_error` is removed less bead volume, by the bead's.
    """

    policy: str
    suite: str
    names: tuple[str, ...]
    values: NDArray[np.float64]
    seeds: tuple[int, ...]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.values[:, self.names.index(name)]

    def mean(self, name: str) -> tuple[float, float, float]:
        """Mean of a figure and its interval of 95 %: the bootstrap's percentiles over episodes (Efron 1979)."""
        return _interval(self[name])

    def difference(self, other: Evaluation, name: str) -> tuple[float, float, float]:
        """Mean of this figure less that of another policy, episode by episode, and its interval of 95 %.

        Both must be evaluated on the same suite with the same seeds and keywords: then episode i is the same weld with the
        same drawn parameters.
        """
        if (self.suite, self.seeds) != (other.suite, other.seeds):
            raise WrongUse(f"{self.policy} ran {self.suite} with seeds {_brief(self.seeds)} and {other.policy} {other.suite} "
                           f"with seeds {_brief(other.seeds)}; the same suite and seeds are accepted")
        return _interval(self[name] - other[name])

    def table(self) -> dict[str, tuple[float, float, float]]:
        """Means and intervals of all figures."""
        return {name: self.mean(name) for name in self.names}

    def _repr_html_(self) -> str:
        rows = (f"<tr><td>{name}</td><td>{mean:.4g}</td><td>{low:.4g} to {high:.4g}</td></tr>"
                for name, (mean, low, high) in self.table().items())
        title = f"{self.policy} on {self.suite}, {len(self.values)} episodes"
        return f"<table><caption>{title}</caption><tr><th>figure</th><th>mean</th><th>95 %</th></tr>{''.join(rows)}</table>"


def evaluate(policy: Policy | str, suite: Suite, seeds: Sequence[int] = range(8), **keywords: Any) -> Evaluation:
    """Runs one episode for each seed, all at once, until the last has ended.

    - `policy`: from observations of shape `[n, ...]` to actions of shape `[n, 5]`; or a baseline: "nothing", "raster",
      "oracle"
    - `keywords`: as for `robofin/Grind-v0`

    Every seed draws its weld from the suite. An episode's figures are those of its last step.
    """
    from ._gymnasium import FinishingVectorEnv

    seeds = list(seeds)
    if not seeds:
        raise WrongUse("no seeds; at least one is accepted")
    if isinstance(policy, str):
        act = baseline(policy)
        if keywords.setdefault("observation", "state") != "state":
            raise WrongUse("the baselines read the observation \"state\"")
        name = policy
    else:
        name, act = getattr(policy, "__name__", type(policy).__name__), policy
    environments = FinishingVectorEnv(len(seeds), process=suite.process, tasks=suite, **keywords)
    seen, _ = environments.reset(seed=seeds)
    names = tuple(Batch.metric_names())
    values, running = np.zeros((len(seeds), len(names))), np.ones(len(seeds), dtype=np.bool_)
    for _ in range(MOST_STEPS):
        seen, _, terminated, truncated, infos = environments.step(act(seen))
        values[running] = infos["metrics"][running]
        running &= ~(terminated | truncated)
        if not running.any():
            break
    return Evaluation(name, suite.name, names, values, tuple(seeds))


def _interval(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Mean and its interval of 95 %: the bootstrap's percentiles over episodes (Efron 1979)."""
    draws = np.random.default_rng(0).integers(len(values), size=(DRAWS, len(values)))
    low, high = np.percentile(values[draws].mean(axis=1), [2.5, 97.5])
    return float(values.mean()), float(low), float(high)


def _brief(seeds: tuple[int, ...]) -> str:
    """Seeds in a message: all of a few, else the first and the last."""
    return ", ".join(map(str, seeds)) if len(seeds) <= 4 else f"{seeds[0]} to {seeds[-1]} ({len(seeds)} of them)"


#: Columns of the state.
ARC, OFFSET, HEIGHTS = 0, 1, 11
#: Bins across the weld in each of the zones behind, below and ahead.
BINS = 5


def _nothing() -> Policy:
    """The tool stays lifted."""
    return lambda seen: np.tile(np.array([0, 0, 0, 0, -1], dtype=np.float32), (len(seen), 1))


def _raster(feed: float = 0.5, force: float = 0.0) -> Policy:
    """Back and forth along the weld at one feed and one force, whatever the surface looks like."""
    directions: dict[int, NDArray[np.float32]] = {}

    def act(seen: Observations) -> Actions:
        way = directions.setdefault(len(seen), np.ones(len(seen), dtype=np.float32))
        way[seen[:, ARC] > 0.999] = -1.0
        way[seen[:, ARC] < -0.999] = 1.0
        actions = np.zeros((len(seen), 5), dtype=np.float32)
        actions[:, 0], actions[:, 4] = feed * way, force
        return actions

    return act


def _oracle(feed: float = 0.5, full: float = 0.5) -> Policy:
    """Back and forth with a force in proportion to what is left under the tool, and none where nothing is left: what
    a plan with perfect sight of the surface would press."""
    raster = _raster(feed)

    def act(seen: Observations) -> Actions:
        actions = raster(seen)
        zones = seen[:, HEIGHTS:].reshape(len(seen), -1, BINS)
        left = zones[:, 1].max(axis=1)
        share = np.clip(left / full, 0.0, 1.0)
        actions[:, 4] = np.where(left > 0.03, 2.0 * np.maximum(share, 0.1) - 1.0, -1.0)
        return actions

    return act


#: Policies to compare with.
BASELINES: dict[str, Callable[[], Policy]] = {"nothing": _nothing, "raster": _raster, "oracle": _oracle}


def baseline(name: str) -> Policy:
    """A fresh baseline: "nothing", "raster" or "oracle". It reads the observation "state" and remembers the direction of
    each environment, so every batch of environments needs its own."""
    if name not in BASELINES:
        raise WrongUse(f"policy is {name!r}, and {', '.join(map(repr, BASELINES))} or a function is accepted")
    return BASELINES[name]()
