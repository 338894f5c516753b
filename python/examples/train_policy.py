"""Trains a policy that grinds welds with PPO, and judges it on welds of parts that it never saw.

    pip install "./python[policy]"
    python python/examples/train_policy.py --out out/policy

The network corrects the baseline "oracle": it scales the force, changes the feed, moves the tool sideways and rolls it.
At first it changes nothing, so training starts from the baseline. The wheel is symmetric about its axis, so pitch has no
effect and is left alone. The algorithm is proximal policy optimisation (Schulman et al. 2017) with generalised advantage
estimation (Schulman et al. 2016). The same seed gives the same policy, bit for bit, on one kind of processor.

The policy shall leave as little bead as possible and gouge no deeper than the baseline "raster" does on the training
welds. So the reward is the fall of the bead left less the rise of the gouge's depth times a price, and the price rises
while episodes gouge deeper than the raster (dual ascent, Altman 1999). At the end one number is chosen, the greatest factor
of all forces with which the policy gouges no deeper than the raster on the training welds. The "scaled oracle" of the
results is the oracle with a factor that is chosen in the same way. Held-out welds are used once, to judge.

Written are `policy.pt` (weights), `curve.svg` (learning curve), `curve.csv` and `results.json` (held-out figures).
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from learning_curve import Curve, drawn
from numpy.typing import NDArray
from torch import Tensor, nn

import robofin
from robofin._gymnasium import FinishingVectorEnv

#: Parameters that are drawn for each episode: wear of the wheel, misalignment of the tool [rad], contact stiffness [Pa/m].
RANDOMISE: dict[str, tuple[float, float] | None] = {
    "grit-dulling.dulling_volume": (100e-9, 1e-6), "tool-tilt.roll_angle": (-0.02, 0.02), "winkler.stiffness": None}
#: Figures that are compared on held-out welds, with their unit and its factor from SI.
FIGURES = {"left": ("1", 1.0), "gouge_depth": ("µm", 1e6), "gouge_volume": ("mm³", 1e9), "time": ("s", 1.0),
           "return": ("1", 1.0)}
#: Columns of the metrics: bead left [1], depth of the gouges [m].
COLUMNS = [robofin.Batch.metric_names().index(name) for name in ("left", "gouge_depth")]
#: Columns of the state: place along the weld, offset, roll.
ARC, OFFSET, ROLL = 0, 1, 2
STATE = 26
#: Corrections: logarithm of the force's factor, feed, offset, roll; and how much a correction of one is.
CORRECTIONS = 4
FORCE, FEED, SHIFT, TURN = 2.0, 0.4, 0.2, 0.2
#: Greatest logarithm of the force's factor; range of that of all forces, and how often it is halved.
STRONGEST, STRENGTHS, HALVINGS = 2.0, (-1.0, 1.5), 5
#: Share of the way to the wanted offset and roll that a step takes, in units of an action.
APPROACH = 5.0
#: Observations are cut at so many standard deviations.
CUT = 5.0

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Settings:
    """What training depends on."""

    seed: int = 1
    #: Steps of all environments together.
    steps: int = 160_000
    environments: int = 32
    #: Training welds, and episodes on them that measure the baselines and choose the factor of the forces.
    welds: int = 6
    measured: int = 32
    #: Steps of each environment between two updates.
    horizon: int = 64
    epochs: int = 6
    minibatches: int = 8
    learning_rate: float = 1e-3
    discount: float = 0.995
    #: Weight of later steps in an advantage, λ.
    trace: float = 0.95
    clip: float = 0.2
    #: Logarithm of the first standard deviation of corrections.
    log_std: float = -1.2
    #: First price of a gouge [1/mm], and how fast it follows the excess of the depth.
    price: float = 1.0
    haggling: float = 0.05


class Network(nn.Module):
    """Mean of the corrections and value of a state, by a network of two hidden layers each; normalises its input."""

    def __init__(self, inputs: int, log_std: float) -> None:
        super().__init__()
        self.actor, self.critic = _layers(inputs, CORRECTIONS, 0.01), _layers(inputs, 1, 1.0)
        self.log_std = nn.Parameter(torch.full((CORRECTIONS,), log_std))
        self.mean, self.variance, self.count = (
            nn.Buffer(start) for start in (torch.zeros(inputs), torch.ones(inputs), torch.tensor(1e-4)))
        #: Logarithm of a factor of all forces.
        self.strength = nn.Buffer(torch.tensor(0.0))

    def learn_scale(self, seen: Tensor) -> None:
        """Adds inputs of shape `[n, inputs]` to the running mean and variance (Chan et al. 1979)."""
        added, total = len(seen), self.count + len(seen)
        shift = seen.mean(0) - self.mean
        spread = self.variance * self.count + seen.var(0, correction=0) * added + shift**2 * self.count * added / total
        self.mean.copy_(self.mean + shift * added / total)
        self.variance.copy_(spread / total)
        self.count.copy_(total)

    def normalised(self, seen: Tensor) -> Tensor:
        """Inputs of mean 0 and variance 1."""
        return ((seen - self.mean) / (self.variance + 1e-6).sqrt()).clamp(-CUT, CUT)

    def log_probability(self, seen: Tensor, corrections: Tensor) -> Tensor:
        """Logarithm of the normal density of corrections given normalised inputs, shape `[n]`, less a constant."""
        errors: Tensor = (corrections - self.actor(seen)) / self.log_std.exp()
        return -(0.5 * errors.square() + self.log_std).sum(-1)

    def value(self, seen: Tensor) -> Tensor:
        """Expected sum of discounted rewards, shape `[n]`."""
        values: Tensor = self.critic(seen)
        return values.squeeze(-1)


def _layers(inputs: int, outputs: int, gain: float) -> nn.Sequential:
    """Two hidden layers of 64, orthogonal at first; the last layer scaled by `gain`."""
    first, second, last = nn.Linear(inputs, 64), nn.Linear(64, 64), nn.Linear(64, outputs)
    for linear, scale in ((first, 2**0.5), (second, 2**0.5), (last, gain)):
        nn.init.orthogonal_(linear.weight, scale)
        nn.init.zeros_(linear.bias)
    return nn.Sequential(first, nn.Tanh(), second, nn.Tanh(), last)


class Guide:
    """The baseline "oracle", and what corrections make of it."""

    def __init__(self) -> None:
        self.act = robofin.baseline("oracle")
        self.actions: Floats = np.zeros((0, 5), dtype=np.float32)

    def inputs(self, seen: Floats) -> Floats:
        """The state, and feed and force of the baseline: shape `[n, 28]`."""
        self.actions = self.act(seen)
        return np.concatenate([seen, self.actions[:, [0, 4]]], axis=1)

    def corrected(self, seen: Floats, corrections: Floats, strength: float = 0.0) -> Floats:
        """Actions of shape `[n, 5]` from corrections of shape `[n, 4]` and the logarithm of a factor of all forces; where
        the baseline lifts the tool, it is lifted."""
        force, feed, shift, turn = corrections.T
        actions = self.actions.copy()
        actions[:, 4] = (actions[:, 4] + 1.0) * np.exp(np.clip(FORCE * force + strength, -STRONGEST, STRONGEST)) - 1.0
        actions[:, 0] *= np.clip(1.0 + FEED * feed / 0.5, 0.0, 2.0)
        actions[:, 1] = APPROACH * (SHIFT * shift - seen[:, OFFSET])
        actions[:, 2] = APPROACH * (TURN * turn - seen[:, ROLL])
        clipped: Floats = np.clip(actions, -1.0, 1.0)
        return clipped


def policy(network: Network) -> robofin.Policy:
    """The trained policy, for `robofin.evaluate`: the mean correction, nothing at random."""
    guide = Guide()

    def ppo(seen: Floats) -> Floats:
        with torch.no_grad():
            inputs = network.normalised(torch.from_numpy(guide.inputs(seen)))
            return guide.corrected(seen, network.actor(inputs).numpy(), float(network.strength))

    return ppo


def oracle() -> Network:
    """The oracle as a network that corrects nothing."""
    network = Network(STATE + 2, 0.0)
    for parameter in network.actor.parameters():
        nn.init.zeros_(parameter)
    return network


def depth_on(suite: robofin.Suite, judged: robofin.Policy | str, episodes: int) -> float:
    """Mean depth of the gouges of a policy on a suite [mm]."""
    return 1e3 * robofin.evaluate(judged, suite, range(episodes), randomise=RANDOMISE).mean("gouge_depth")[0]


def choose_strength(network: Network, suite: robofin.Suite, depth: float, episodes: int) -> None:
    """Sets the greatest factor of all forces with which the policy gouges to a mean depth of at most `depth` [mm] in some
    episodes on a suite, by bisection of the range of its logarithm."""
    low, high = STRENGTHS
    for _ in range(HALVINGS):
        network.strength.fill_(0.5 * (low + high))
        if depth_on(suite, policy(network), episodes) > depth:
            high = float(network.strength)
        else:
            low = float(network.strength)
    network.strength.fill_(low)


@dataclass
class Rollout:
    """Steps of all environments between two updates, each of shape `[horizon, n, ...]`."""

    inputs: Tensor
    corrections: Tensor
    log_probabilities: Tensor
    rewards: Tensor
    values: Tensor
    #: 1 where an episode has ended with this step.
    ended: Tensor
    #: False for the step after an episode, which only begins the next one.
    counts: Tensor

    @staticmethod
    def empty(settings: Settings) -> Rollout:
        """Zeros."""
        shape = (settings.horizon, settings.environments)
        return Rollout(torch.zeros(*shape, STATE + 2), torch.zeros(*shape, CORRECTIONS), torch.zeros(shape),
                       torch.zeros(shape), torch.zeros(shape), torch.zeros(shape), torch.zeros(shape, dtype=torch.bool))

    def advantages(self, last: Tensor, settings: Settings) -> Tensor:
        """Generalised advantage estimates; `last` are the values after the rollout, shape `[n]`.

        The state holds the time, so an episode that ran out of time has ended like any other.
        """
        found, sum_ahead = torch.zeros_like(self.rewards), torch.zeros_like(last)
        for step in reversed(range(settings.horizon)):
            ahead = last if step + 1 == settings.horizon else self.values[step + 1]
            goes_on = 1.0 - self.ended[step]
            error = self.rewards[step] + settings.discount * goes_on * ahead - self.values[step]
            sum_ahead = error + settings.discount * settings.trace * goes_on * sum_ahead
            found[step] = sum_ahead
        return found


class Trainer:
    """Environments, network and optimiser; `update` does one round of both."""

    def __init__(self, settings: Settings) -> None:
        torch.manual_seed(settings.seed)
        torch.set_num_threads(1)
        self.settings = settings
        self.network = Network(STATE + 2, settings.log_std)
        self.optimiser = torch.optim.Adam(self.network.parameters(), settings.learning_rate, eps=1e-5)
        tasks = robofin.suite("grinding", "train", count=settings.welds)
        self.environments = FinishingVectorEnv(settings.environments, tasks=tasks, randomise=RANDOMISE)
        self.guide = Guide()
        self.seen, _ = self.environments.reset(seed=1000 * settings.seed)
        self.begins = np.zeros(settings.environments, dtype=np.bool_)
        self.figures = np.tile([1.0, 0.0], (settings.environments, 1))
        self.price, self.depth = settings.price, depth_on(tasks, "raster", settings.measured)

    def update(self, share_left: float) -> list[list[float]]:
        """A rollout and an improvement at a share of the learning rate. Returns the bead left [1] and the depth of the
        gouges [mm] of each episode that ended."""
        for group in self.optimiser.param_groups:
            group["lr"] = share_left * self.settings.learning_rate
        rollout, ended = self._collect()
        with torch.no_grad():
            last = self.network.value(self.network.normalised(torch.from_numpy(self.guide.inputs(self.seen))))
            advantages = rollout.advantages(last, self.settings)
        self._improve(rollout, advantages)
        self.network.learn_scale(rollout.inputs[rollout.counts])
        if ended:
            excess = float(np.mean(ended, axis=0)[1]) / self.depth - 1.0
            self.price *= float(np.exp(self.settings.haggling * len(ended) / self.settings.environments * excess))
        return ended

    def _reward(self, metrics: NDArray[np.float64], begins: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Fall of the bead left, less the rise of the gouge's depth times the price, shape `[n]`."""
        figures = metrics[:, COLUMNS] * [1.0, 1e3]
        before = np.where(begins[:, None], figures, self.figures)
        self.figures = figures
        rewards: NDArray[np.float64] = (before - figures) @ [1.0, self.price]
        return rewards

    @torch.no_grad()
    def _collect(self) -> tuple[Rollout, list[list[float]]]:
        rollout, ended = Rollout.empty(self.settings), []
        for step in range(self.settings.horizon):
            rollout.inputs[step] = torch.from_numpy(self.guide.inputs(self.seen))
            inputs = self.network.normalised(rollout.inputs[step])
            means: Tensor = self.network.actor(inputs)
            corrections = means + self.network.log_std.exp() * torch.randn(means.shape)
            actions = self.guide.corrected(self.seen, corrections.numpy())
            rollout.corrections[step], rollout.values[step] = corrections, self.network.value(inputs)
            rollout.log_probabilities[step] = self.network.log_probability(inputs, corrections)
            rollout.counts[step] = torch.from_numpy(~self.begins)
            self.seen, _, terminated, truncated, infos = self.environments.step(actions)
            rollout.rewards[step] = torch.from_numpy(self._reward(infos["metrics"], self.begins))
            self.begins = terminated | truncated
            rollout.ended[step] = torch.from_numpy(self.begins)
            ended += self.figures[self.begins].tolist()
        return rollout, ended

    def _improve(self, rollout: Rollout, advantages: Tensor) -> None:
        counts = rollout.counts
        inputs, corrections = self.network.normalised(rollout.inputs[counts]), rollout.corrections[counts]
        before, gains = rollout.log_probabilities[counts], advantages[counts]
        targets = gains + rollout.values[counts]
        gains = (gains - gains.mean()) / (gains.std() + 1e-8)
        for _ in range(self.settings.epochs):
            for part in torch.randperm(len(inputs)).chunk(self.settings.minibatches):
                ratio = (self.network.log_probability(inputs[part], corrections[part]) - before[part]).exp()
                limited = ratio.clamp(1.0 - self.settings.clip, 1.0 + self.settings.clip)
                policy_loss = -torch.min(ratio * gains[part], limited * gains[part]).mean()
                value_loss = (self.network.value(inputs[part]) - targets[part]).square().mean()
                self.optimiser.zero_grad()
                (policy_loss + 0.5 * value_loss).backward()  # type: ignore[no-untyped-call]
                nn.utils.clip_grad_norm_(self.network.parameters(), 0.5)
                self.optimiser.step()


def train(settings: Settings) -> tuple[Network, Curve]:
    """Trains for `settings.steps`, printing the figures of training episodes."""
    trainer, curve, begun = Trainer(settings), Curve(), time.monotonic()
    batch = settings.horizon * settings.environments
    updates = max(1, settings.steps // batch)
    recent: list[list[float]] = []
    for update in range(updates):
        recent += trainer.update(1.0 - update / updates)
        if len(recent) >= settings.environments or update + 1 == updates and recent:
            left, depth = np.mean(recent, axis=0)
            curve.append((batch * (update + 1), float(left), float(depth)))
            print(f"{curve[-1][0]:7d} steps, {time.monotonic() - begun:4.0f} s, left {left:.3f}, gouge {1e3 * depth:.0f} µm, "
                  f"price {trainer.price:.2f} 1/mm", flush=True)
            recent = []
    return trainer.network, curve


def judge(networks: dict[str, Network], suite: robofin.Suite, seeds: Sequence[int]) -> dict[str, robofin.Evaluation]:
    """Figures of the baselines and of networks on a suite under the randomisation of training."""
    judged: dict[str, robofin.Policy | str] = {"raster": "raster", "oracle": "oracle"}
    judged |= {name: policy(network) for name, network in networks.items()}
    return {name: robofin.evaluate(each, suite, seeds, randomise=RANDOMISE) for name, each in judged.items()}


def table(found: dict[str, robofin.Evaluation]) -> str:
    """A Markdown table: means and paired differences from the raster, with intervals of 95 %."""
    lines = ["| policy | " + " | ".join(f"{name} [{unit}]" for name, (unit, _) in FIGURES.items()) + " |",
             "|" + "---|" * (len(FIGURES) + 1)]
    rows = [(name, {figure: each.mean(figure) for figure in FIGURES}) for name, each in found.items()]
    rows += [(f"ppo less {name}", {figure: found["ppo"].difference(each, figure) for figure in FIGURES})
             for name, each in found.items() if name != "ppo"]
    for name, figures in rows:
        cells = [" ({1:.3g} to {2:.3g})".join(["{0:.3g}", ""]).format(*(FIGURES[figure][1] * value for value in values))
                 for figure, values in figures.items()]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(words: Sequence[str] | None = None) -> None:
    """Trains, judges and writes."""
    parser = argparse.ArgumentParser(description="Trains a grinding policy with PPO and judges it on held-out welds.")
    parser.add_argument("--out", type=Path, default=Path("out/policy"), help="folder of the results")
    parser.add_argument("--seed", type=int, default=Settings.seed)
    parser.add_argument("--steps", type=int, default=Settings.steps, help="of all environments together")
    parser.add_argument("--environments", type=int, default=Settings.environments)
    parser.add_argument("--measured", type=int, default=Settings.measured, help="episodes on training welds that choose")
    parser.add_argument("--held-out", type=int, default=12, help="held-out welds")
    parser.add_argument("--episodes", type=int, default=32, help="held-out episodes")
    given = parser.parse_args(words)
    settings = Settings(given.seed, given.steps, given.environments, measured=given.measured)
    network, curve = train(settings)
    if not curve:
        raise robofin.WrongUse(f"--steps is {given.steps}, in which no episode ended; about 500 per environment are needed")
    training, networks = robofin.suite("grinding", "train", count=settings.welds), {"scaled oracle": oracle(), "ppo": network}
    depth = depth_on(training, "raster", settings.measured)
    for name, each in networks.items():
        choose_strength(each, training, depth, settings.measured)
        print(f"factor of all forces, {name}: {float(each.strength.exp()):.2f}", flush=True)
    given.out.mkdir(parents=True, exist_ok=True)
    torch.save(network.state_dict(), given.out / "policy.pt")
    rows = "".join(f"{steps},{left:.6f},{1e3 * depth:.3f}\n" for steps, left, depth in curve)
    (given.out / "curve.csv").write_text("steps,left,gouge_depth_um\n" + rows)
    known = judge(networks, training, range(settings.measured))
    print("training welds:", table(known), sep="\n")
    marks = {name: (each.mean("left")[0], 1e3 * each.mean("gouge_depth")[0]) for name, each in known.items() if name != "ppo"}
    found = judge(networks, robofin.suite("grinding", "held-out", count=given.held_out), range(given.episodes))
    print("held-out welds:", table(found), sep="\n")
    (given.out / "curve.svg").write_text(drawn(curve, marks), encoding="utf-8")
    figures = {name: {figure: each.mean(figure) for figure in FIGURES} for name, each in found.items()}
    results = {"settings": asdict(settings), "welds": given.held_out, "episodes": given.episodes, "figures": figures}
    (given.out / "results.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
