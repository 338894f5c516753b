"""A policy that learns to grind welds off: proximal policy optimisation (Schulman et al. 2017), in NumPy alone.

    python examples/ppo.py [steps] [seed]

It learns feed and force on the training suite and is compared with the baselines on parts that it has never seen.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from numpy.typing import NDArray

import robofin
from robofin._gymnasium import FinishingVectorEnv

Array = NDArray[np.float64]

ENVIRONMENTS, ROLLOUT, EPOCHS, BATCHES = 32, 64, 6, 4
DISCOUNT, TRACE, CLIP, RATE = 0.995, 0.95, 0.2, 1e-3
#: Numbers of an action that are learnt: feed along the weld, and force.
LEARNT = [0, 4]
HIDDEN = 64


class Network:
    """Two hidden layers of tanh, trained by Adam (Kingma and Ba 2015)."""

    def __init__(self, sizes: list[int], random: np.random.Generator, last: float) -> None:
        scale = [1.0] * (len(sizes) - 2) + [last]
        self.weights = [s * random.normal(size=(a, b)) / np.sqrt(a) for a, b, s in zip(sizes, sizes[1:], scale)]
        self.weights += [np.zeros(b) for b in sizes[1:]]
        self.moments = [(np.zeros_like(w), np.zeros_like(w)) for w in self.weights]
        self.updates = 0

    def forward(self, x: Array) -> tuple[Array, list[Array]]:
        """Outputs, and the layers before them."""
        layers, count = [x], len(self.weights) // 2
        for k in range(count - 1):
            layers.append(np.tanh(layers[-1] @ self.weights[k] + self.weights[count + k]))
        return layers[-1] @ self.weights[count - 1] + self.weights[-1], layers

    def gradients(self, layers: list[Array], slope: Array) -> list[Array]:
        """Gradients of a loss whose slope by the outputs is given."""
        count = len(layers)
        found: list[Array] = [np.empty(0)] * (2 * count)
        for k in reversed(range(count)):
            found[k], found[count + k] = layers[k].T @ slope, slope.sum(axis=0)
            slope = (slope @ self.weights[k].T) * (1.0 - layers[k] ** 2)
        return found

    def descend(self, gradients: list[Array]) -> None:
        """One step of Adam, the gradient's length cut to 0.5."""
        length = np.sqrt(sum(float((g * g).sum()) for g in gradients))
        self.updates += 1
        for k, gradient in enumerate(gradients):
            gradient = gradient * min(1.0, 0.5 / (length + 1e-8))
            first, second = self.moments[k]
            first, second = 0.9 * first + 0.1 * gradient, 0.999 * second + 0.001 * gradient**2
            self.moments[k] = first, second
            step = first / (1 - 0.9**self.updates) / (np.sqrt(second / (1 - 0.999**self.updates)) + 1e-8)
            self.weights[k] = self.weights[k] - RATE * step


class Learner:
    """A Gaussian policy and the value of observations."""

    def __init__(self, observations: int, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.actor = Network([observations, HIDDEN, HIDDEN, len(LEARNT)], self.random, 0.01)
        self.critic = Network([observations, HIDDEN, HIDDEN, 1], self.random, 1.0)
        self.deviation = np.full(len(LEARNT), 0.5)

    def __call__(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """What the policy does without exploring."""
        return full(self.actor.forward(seen.astype(float))[0])

    def density(self, chosen: Array, mean: Array) -> Array:
        """Logarithm of the density of actions, but for a constant."""
        return -0.5 * (((chosen - mean) / self.deviation) ** 2).sum(axis=1)

    def learn(self, seen: Array, chosen: Array, advantages: Array, returns: Array) -> None:
        """Some epochs over a rollout, flattened."""
        before = self.density(chosen, self.actor.forward(seen)[0])
        advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        for _ in range(EPOCHS):
            for rows in np.array_split(self.random.permutation(len(seen)), BATCHES):
                mean, layers = self.actor.forward(seen[rows])
                ratio = np.exp(np.clip(self.density(chosen[rows], mean) - before[rows], -20, 20))
                worth = advantages[rows]
                acts = ~(((worth > 0) & (ratio > 1 + CLIP)) | ((worth < 0) & (ratio < 1 - CLIP)))
                slope = -(acts * worth * ratio)[:, None] * (chosen[rows] - mean) / self.deviation**2
                self.actor.descend(self.actor.gradients(layers, slope / len(rows)))
                value, layers = self.critic.forward(seen[rows])
                self.critic.descend(self.critic.gradients(layers, (value - returns[rows, None]) / len(rows)))


def full(learnt: Array) -> NDArray[np.float32]:
    """Actions of five numbers from those that are learnt."""
    actions = np.zeros((len(learnt), 5), dtype=np.float32)
    actions[:, LEARNT] = np.clip(learnt, -1.0, 1.0)
    return actions


def advantages_of(rewards: Array, values: Array, ended: NDArray[np.bool_], last: Array) -> Array:
    """Generalised advantages (Schulman et al. 2016)."""
    found, running, after = np.zeros_like(rewards), np.zeros(rewards.shape[1]), last
    for k in reversed(range(len(rewards))):
        goes_on = ~ended[k]
        running = rewards[k] + DISCOUNT * after * goes_on - values[k] + DISCOUNT * TRACE * running * goes_on
        found[k], after = running, values[k]
    return found


def train(steps: int, seed: int) -> Learner:
    """Trains a policy and prints its course: the returns of the episodes that ended since the line before."""
    environments = FinishingVectorEnv(ENVIRONMENTS, tasks=robofin.suite("grinding", "train", count=4))
    seen, _ = environments.reset(seed=seed)
    learner, begun, ends = Learner(seen.shape[1], seed), time.perf_counter(), []
    returned = robofin.Batch.metric_names().index("return")
    rollouts = max(1, steps // (ENVIRONMENTS * ROLLOUT))
    for rollout in range(rollouts):
        shape = (ROLLOUT, ENVIRONMENTS)
        all_seen, all_chosen = np.zeros((*shape, seen.shape[1])), np.zeros((*shape, len(LEARNT)))
        rewards, values, ended = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=np.bool_)
        for k in range(ROLLOUT):
            all_seen[k] = seen
            mean, values[k] = learner.actor.forward(all_seen[k])[0], learner.critic.forward(all_seen[k])[0][:, 0]
            all_chosen[k] = mean + learner.deviation * learner.random.normal(size=mean.shape)
            seen, rewards[k], terminated, truncated, infos = environments.step(full(all_chosen[k]))
            ended[k] = terminated | truncated
            ends += infos["metrics"][ended[k], returned].tolist()
        last = learner.critic.forward(seen.astype(float))[0][:, 0]
        advantages = advantages_of(10 * rewards, values, ended, last)
        flat = (all_seen.reshape(-1, seen.shape[1]), all_chosen.reshape(-1, len(LEARNT)))
        learner.learn(*flat, advantages.ravel(), (advantages + values).ravel())
        learner.deviation = np.full(len(LEARNT), 0.5 - 0.35 * rollout / rollouts)
        if rollout % 5 == 4 or rollout == rollouts - 1:
            mean = f"{np.mean(ends):.3f} over {len(ends)} episodes" if ends else "no episode ended"
            done = (rollout + 1) * ENVIRONMENTS * ROLLOUT
            print(f"{done} steps, {time.perf_counter() - begun:.0f} s: return {mean}", flush=True)
            ends = []
    return learner


def main() -> None:
    """Trains, then compares on held-out parts."""
    given = [int(word) for word in sys.argv[1:]]
    steps, seed = (*given, *(200_000, 1)[len(given):])
    learner = train(steps, seed)
    held_out = robofin.suite("grinding", "held-out", count=4)
    for policy in ("raster", "oracle", learner):
        result = robofin.evaluate(policy, held_out, seeds=range(100, 116))
        figures = {name: result.mean(name) for name in ("left", "gouge_depth", "return", "time")}
        told = ", ".join(f"{name} {mean:.3g} ({low:.3g} to {high:.3g})" for name, (mean, low, high) in figures.items())
        print(f"{result.policy}: {told}")


if __name__ == "__main__":
    main()
