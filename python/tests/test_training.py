"""The example that trains a policy."""

import csv
import importlib.util
import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import robofin

EXAMPLE = Path(__file__).parents[1] / "examples/train_policy.py"

if not importlib.util.find_spec("torch"):
    pytest.skip("the training of a policy is NOT TESTED: torch is missing", allow_module_level=True)


@pytest.fixture(scope="module")
def example() -> ModuleType:
    """The example as a module."""
    spec = importlib.util.spec_from_file_location("train_policy", EXAMPLE)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules["train_policy"] = module
    sys.path.insert(0, str(EXAMPLE.parent))
    spec.loader.exec_module(module)
    return module


def short(example: ModuleType, **changes: Any) -> Any:
    """Settings of a training of two updates."""
    return example.Settings(**{"steps": 128, "environments": 2, "horizon": 32, "welds": 1, "minibatches": 2, "measured": 2} | changes)


def test_an_untrained_policy_is_the_baseline_that_it_corrects(example: ModuleType) -> None:
    suite = robofin.suite("grinding", count=1)
    network = example.Network(example.STATE + 2, -1.0)
    example.nn.init.zeros_(network.actor[-1].weight)
    found = robofin.evaluate(example.policy(network), suite, seeds=[3], time_limit=2.0)
    oracle = robofin.evaluate("oracle", suite, seeds=[3], time_limit=2.0)
    assert found.difference(oracle, "removed_volume")[0] == pytest.approx(0.0, abs=1e-3 * oracle["removed_volume"][0])


def test_the_factor_of_the_forces_is_the_greatest_that_gouges_no_deeper(example: ModuleType,
                                                                   monkeypatch: pytest.MonkeyPatch) -> None:
    network = example.Network(example.STATE + 2, -1.0)
    monkeypatch.setattr(example, "depth_on", lambda *_: 0.05 * float(network.strength.exp()))
    example.choose_strength(network, None, 0.1, 1)
    low, high = example.STRENGTHS
    exact = np.log(2.0)
    assert exact - (high - low) / 2**example.HALVINGS <= float(network.strength) <= exact


def test_rewards_are_the_fall_of_the_cost(example: ModuleType) -> None:
    trainer = object.__new__(example.Trainer)
    trainer.price, trainer.figures = 0.5, np.array([[0.8, 0.01], [0.5, 0.2]])
    metrics = np.zeros((2, len(robofin.Batch.metric_names())))
    metrics[:, example.COLUMNS] = [[0.7, 3e-5], [1.0, 0.0]]
    rewards = trainer._reward(metrics, np.array([False, True]))
    # The second environment has just begun an episode.
    np.testing.assert_allclose(rewards, [0.1 - 0.5 * 0.02, 0.0])
    np.testing.assert_allclose(trainer.figures, [[0.7, 0.03], [1.0, 0.0]])


def test_the_same_seed_trains_the_same_policy_and_another_one_another(example: ModuleType) -> None:
    first, again, other = (example.train(short(example, seed=seed))[0].state_dict() for seed in (4, 4, 5))
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["actor.0.weight"], other["actor.0.weight"])


def test_advantages_are_those_of_the_definition(example: ModuleType) -> None:
    settings = short(example, horizon=5, environments=1)
    rollout, torch = example.Rollout.empty(settings), example.torch
    rollout.rewards, rollout.values = torch.arange(1.0, 6.0)[:, None], torch.tensor([2.0, 0, 1, 3, 1])[:, None]
    rollout.ended[2] = 1.0
    found = rollout.advantages(torch.tensor([7.0]), settings)[:, 0].numpy()
    discount, trace = settings.discount, settings.trace
    ahead = [0.0, 1.0, 0.0, 1.0, 7.0]
    errors = [step + 1 + discount * ahead[step] - float(rollout.values[step]) for step in range(5)]
    for step, last in ((0, 2), (1, 2), (2, 2), (3, 4), (4, 4)):
        wanted = sum((discount * trace) ** (k - step) * errors[k] for k in range(step, last + 1))
        assert found[step] == pytest.approx(wanted, rel=1e-5)


def test_the_running_scale_is_that_of_all_inputs(example: ModuleType) -> None:
    seen = example.torch.from_numpy(np.random.default_rng(0).normal(3.0, 2.0, (300, 4)).astype(np.float32))
    network = example.Network(4, -1.0)
    for part in seen.split([10, 190, 100]):
        network.learn_scale(part)
    np.testing.assert_allclose(network.mean, seen.mean(0), rtol=1e-4)
    np.testing.assert_allclose(network.variance, seen.var(0, correction=0), rtol=1e-4)


def test_ppo_learns_what_is_rewarded(example: ModuleType) -> None:
    """Rewards for a correction near 0.5 move the mean correction there: the loss has the right sign."""
    example.torch.manual_seed(0)
    settings = short(example, horizon=256, environments=1, learning_rate=3e-3)
    trainer = object.__new__(example.Trainer)
    trainer.settings, trainer.network = settings, example.Network(example.STATE + 2, -0.5)
    trainer.optimiser = example.torch.optim.Adam(trainer.network.parameters(), settings.learning_rate)
    for _ in range(30):
        rollout = example.Rollout.empty(settings)
        rollout.counts[:] = True
        inputs = rollout.inputs[:, 0]
        rollout.corrections[:, 0] = (trainer.network.actor(inputs).detach()
                                     + trainer.network.log_std.detach().exp() * example.torch.randn(256, 4))
        rollout.log_probabilities[:, 0] = trainer.network.log_probability(inputs, rollout.corrections[:, 0]).detach()
        trainer._improve(rollout, -(rollout.corrections - 0.5).square().sum(-1))
    np.testing.assert_allclose(trainer.network.actor(inputs[:1]).detach()[0], 0.5, atol=0.1)


def test_the_script_writes_weights_curve_and_figures(tmp_path: Path) -> None:
    words = ["--steps", "3000", "--environments", "2", "--measured", "1", "--held-out", "1", "--episodes", "1",
             "--out", str(tmp_path)]
    output = subprocess.run([sys.executable, str(EXAMPLE), *words], capture_output=True, text=True, check=True).stdout
    assert "| ppo less raster |" in output
    results = json.loads((tmp_path / "results.json").read_text())
    assert set(results["figures"]) == {"raster", "oracle", "scaled oracle", "ppo"} and results["settings"]["seed"] == 1
    rows = list(csv.reader((tmp_path / "curve.csv").open()))
    assert rows[0] == ["steps", "left", "gouge_depth_um"] and 0 < int(rows[-1][0]) <= 3000
    assert ElementTree.parse(tmp_path / "curve.svg").getroot().tag.endswith("svg")
    assert (tmp_path / "policy.pt").stat().st_size > 10_000


def test_the_example_is_strictly_typed() -> None:
    configuration = str(EXAMPLE.parents[1] / "pyproject.toml")
    output = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--config-file", configuration, str(EXAMPLE)],
                          capture_output=True, text=True, cwd=EXAMPLE.parents[1] / "tests")
    assert output.returncode == 0, output.stdout
