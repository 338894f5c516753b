"""Gymnasium environments over batches: `robofin/Grind-v0` and `robofin/Sand-v0`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._robofin import Batch, WrongUse, photograph
from ._suites import Suite, suite

#: Numbers of an action: feed along the weld and across it, rates of roll and pitch, force; each from -1 to 1.
ACTION = 5
#: Pixels of a rendered picture.
SIZE = (320, 240)
#: Largest seed of an episode that is drawn here.
SEEDS = 2**31

Array = NDArray[Any]
Ranges = Sequence[str] | Mapping[str, tuple[float, float] | None]


def register() -> None:
    """Makes the environments known to Gymnasium."""
    for name, process in [("Grind", "grinding"), ("Sand", "sanding")]:
        gymnasium.register(
            id=f"robofin/{name}-v0",
            entry_point="robofin._gymnasium:FinishingEnv",
            vector_entry_point="robofin._gymnasium:FinishingVectorEnv",
            kwargs={"process": process},
            order_enforce=True,
        )


class FinishingVectorEnv(VectorEnv[Array, Array, Array]):
    """Many welds that are finished at once. One call steps all of them over threads, without Python's lock.

    - `process`: "grinding" or "sanding"
    - `tasks`: a suite; without one, the training suite of `difficulty`
    - `observation`: "state" (26 numbers), "heights" (32 stations of 16 points [mm] around the tool, or what is left of the
      coating), "depth" (32 x 32 pixels [m] from above the tool) or "rgb" (64 x 64 pixels of three bytes, by the same camera)
    - `randomise`: names of parameters that are drawn for each episode from the range of their effect file, or names with
      ranges [SI]; their effects are added to the model
    - `limits`: changes to the limits of actions, such as `{"force": 40.0}`
    - `time_limit`: of an episode [s]

    An episode that has ended begins again in the next step, whose action is ignored (`AutoresetMode.NEXT_STEP`).
    `infos["metrics"]` holds the figures of all episodes so far, one row each, named by `Batch.metric_names()`.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": ["rgb_array"]}

    def __init__(self, num_envs: int = 1, *, process: str = "grinding", tasks: Suite | None = None,
                 difficulty: str = "easy", observation: str = "state", randomise: Ranges = (),
                 limits: Mapping[str, float] | None = None, time_limit: float | None = None,
                 render_mode: str | None = None) -> None:
        chosen = tasks if tasks is not None else suite(process, difficulty=difficulty)
        if chosen.process != process:
            raise WrongUse(f"the suite {chosen.name} is for {chosen.process}, and the environment for {process}")
        ranges = dict(randomise) if isinstance(randomise, Mapping) else dict.fromkeys(randomise)
        model = chosen.model
        for effect in dict.fromkeys(name.split(".")[0] for name in ranges):
            if not any(name.startswith(f"{effect}.") for name in model.values):
                model = model.with_effect(effect)
        self.suite, self.render_mode, self.num_envs = chosen, render_mode, num_envs
        self.batch = Batch(list(chosen.tasks), chosen.tool, model, num_envs, observation=observation,
                           randomise=list(ranges.items()), limits=list((limits or {}).items()), time_limit=time_limit)
        shape = tuple(self.batch.observation_shape)
        self.single_observation_space = Box(-np.inf, np.inf, shape, np.float32)
        if observation == "rgb":
            self.single_observation_space = Box(0, 255, shape, np.uint8)
        self.single_action_space = Box(-1.0, 1.0, (ACTION,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._shape = (num_envs, *shape)
        self._metrics = len(Batch.metric_names())

    def reset(self, *, seed: int | Sequence[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begins episodes: environment i gets `seed + i`, or its own of a list. `options["reset_mask"]` names the
        environments that begin; without a seed they begin their next episode."""
        mask = np.ones(self.num_envs, dtype=np.bool_)
        if options and "reset_mask" in options:
            mask = np.ascontiguousarray(options["reset_mask"], dtype=np.bool_)
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
            seeds: list[int | None] = [int(seed) + k for k in range(self.num_envs)]
        else:
            seeds = [None] * self.num_envs if seed is None else [None if one is None else int(one) for one in seed]
        observations = np.empty(self._shape, dtype=np.float32)
        self.batch.reset(seeds, mask, observations)
        return self._seen(observations), {}

    def step(self, actions: Array) -> tuple[Array, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_],
                                            dict[str, Any]]:
        """Steps all environments under actions of shape `[num_envs, 5]`."""
        wanted = np.ascontiguousarray(actions, dtype=np.float32)
        observations = np.empty(self._shape, dtype=np.float32)
        rewards = np.empty(self.num_envs)
        terminated, truncated = np.empty(self.num_envs, dtype=np.bool_), np.empty(self.num_envs, dtype=np.bool_)
        metrics = np.empty((self.num_envs, self._metrics))
        self.batch.step(wanted, observations, rewards, terminated, truncated, metrics)
        return self._seen(observations), rewards, terminated, truncated, {"metrics": metrics}

    def _seen(self, observations: Array) -> Array:
        """Observations in the type of their space."""
        return observations.astype(self.single_observation_space.dtype, copy=False)

    def render(self) -> tuple[Array, ...] | None:
        """Photographs of all workpieces, shape `[240, 320, 3]` each."""
        if self.render_mode is None:
            return None
        shown = (photograph(self.batch.workpiece(k), size=SIZE, samples=1) for k in range(self.num_envs))
        return tuple(picture["rgb"] for picture in shown)


class FinishingEnv(gymnasium.Env[Array, Array]):
    """One weld that is finished; the keywords are those of `FinishingVectorEnv`."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}

    def __init__(self, render_mode: str | None = None, **keywords: Any) -> None:
        self.all = FinishingVectorEnv(1, render_mode=render_mode, **keywords)
        self.render_mode = render_mode
        self.observation_space = self.all.single_observation_space
        self.action_space = self.all.single_action_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begins the first episode of a seed, or the next one."""
        super().reset(seed=seed)
        observations, infos = self.all.reset(seed=seed)
        return observations[0], infos

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """One step under an action of shape `[5]`."""
        seen, rewards, terminated, truncated, infos = self.all.step(np.asarray(action)[None])
        names = Batch.metric_names()
        figures = {"metrics": dict(zip(names, infos["metrics"][0].tolist(), strict=True))}
        return seen[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), figures

    def render(self) -> Any:
        """A photograph of the workpiece, shape `[240, 320, 3]`."""
        shown = self.all.render()
        return None if shown is None else shown[0]
