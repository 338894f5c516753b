"""The Gymnasium environments."""

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import robofin

ROLL = {"tool-tilt.roll_angle": (-0.02, 0.02), "grit-dulling.dulling_volume": None, "winkler.stiffness": (5e9, 2e10)}


def actions(seed: int, steps: int, count: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    chosen = random.uniform(-1, 1, (steps, count, 5)).astype(np.float32)
    chosen[..., 0] = np.abs(chosen[..., 0])
    return chosen


def run(suite: robofin.Suite, seed: int, steps: int = 12, count: int = 3, **keywords: object) -> list[np.ndarray]:
    environments = gymnasium.make_vec("robofin/Grind-v0", num_envs=count, tasks=suite, **keywords)
    seen = [environments.reset(seed=seed)[0]]
    for action in actions(seed, steps, count):
        observations, rewards, *_ = environments.step(action)
        seen += [observations, rewards]
    return seen


@pytest.mark.parametrize("name", ["robofin/Grind-v0", "robofin/Sand-v0"])
def test_the_checker_of_gymnasium_passes(name: str) -> None:
    tasks = robofin.suite("grinding" if "Grind" in name else "sanding", count=1)
    environment = gymnasium.make(name, tasks=tasks, render_mode="rgb_array", disable_env_checker=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Its spaces are not bounded, of which the checker warns: heights and travels have no natural bound.
        warnings.filterwarnings("ignore", message=".*Box observation space.*")
        check_env(environment.unwrapped)


def test_make_vec_gives_the_native_environment_that_declares_its_autoreset(suite: robofin.Suite) -> None:
    environments = gymnasium.make_vec("robofin/Grind-v0", num_envs=3, tasks=suite)
    assert type(environments.unwrapped).__name__ == "FinishingVectorEnv"
    assert environments.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert environments.observation_space.shape == (3, 26) and environments.action_space.shape == (3, 5)


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(suite: robofin.Suite) -> None:
    first, again, other = (run(suite, seed, randomise=ROLL) for seed in (5, 5, 6))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[-1], other[-1])


def test_each_environment_is_the_one_of_its_seed_alone(suite: robofin.Suite) -> None:
    together = gymnasium.make_vec("robofin/Grind-v0", num_envs=2, tasks=suite, randomise=ROLL)
    alone = gymnasium.make("robofin/Grind-v0", tasks=suite, randomise=ROLL)
    both, (one, _) = together.reset(seed=40)[0], alone.reset(seed=41)
    np.testing.assert_array_equal(both[1], one)
    for action in actions(1, 8, 2):
        both, rewards, *_ = together.step(action)
        one, reward, *_ = alone.step(action[1])
        np.testing.assert_array_equal(both[1], one)
        assert rewards[1] == reward


@pytest.mark.parametrize("observation", ["state", "rgb"])
def test_the_number_of_threads_changes_no_byte(observation: str) -> None:
    program = (
        "import hashlib, numpy as np, robofin\n"
        "from robofin._gymnasium import FinishingVectorEnv\n"
        "e = FinishingVectorEnv(4, tasks=robofin.suite(count=1), randomise=['grit-dulling.dulling_volume'],\n"
        f"                       observation='{observation}')\n"
        "h = hashlib.sha256(e.reset(seed=1)[0].tobytes())\n"
        "r = np.random.default_rng(0)\n"
        "for _ in range(10):\n"
        "    o, w, *_ = e.step(r.uniform(-1, 1, (4, 5)).astype('f4'))\n"
        "    h.update(o.tobytes() + w.tobytes())\n"
        "h.update(e.batch.workpiece(2).field.to_nanovdb())\n"
        "print(h.hexdigest())\n"
    )
    outputs = [
        subprocess.run([sys.executable, "-c", program], env={"RAYON_NUM_THREADS": threads}, capture_output=True,
                       text=True, check=True).stdout
        for threads in ("1", "3")
    ]
    assert outputs[0] == outputs[1] and len(outputs[0].strip()) == 64


def test_randomisation_draws_from_the_ranges_and_is_refused_by_name(suite: robofin.Suite) -> None:
    plain, drawn = run(suite, 5), run(suite, 5, randomise=["grit-dulling.dulling_volume"])
    assert not np.array_equal(plain[-2], drawn[-2])
    with pytest.raises(robofin.RoboFinError, match="grit-dulling.sharpness"):
        run(suite, 5, randomise=["grit-dulling.sharpness"])
    with pytest.raises(robofin.RoboFinError, match="the lesser first"):
        run(suite, 5, randomise={"winkler.stiffness": (2.0, 1.0)})


def test_observations_show_the_bead_that_goes_away(suite: robofin.Suite) -> None:
    shapes = {"state": (26,), "heights": (32, 16), "depth": (32, 32)}
    for observation, shape in shapes.items():
        environment = gymnasium.make("robofin/Grind-v0", tasks=suite, observation=observation)
        before, _ = environment.reset(seed=2)
        assert before.shape == shape and np.isfinite(before).all()
        for _ in range(40):
            after, *_ = environment.step(np.array([0, 0, 0, 0, 1], dtype=np.float32))
        if observation == "heights":
            assert before.max() == pytest.approx(suite.tasks[0].width * 0.3e3, rel=0.2)
            assert after.max() <= before.max() and after.sum() < before.sum()
        if observation == "depth":
            # What is ground off is farther from the camera.
            assert after.sum() > before.sum()


def test_photographs_show_the_weld_and_what_is_ground_off_it(suite: robofin.Suite) -> None:
    environment = gymnasium.make("robofin/Grind-v0", tasks=suite, observation="rgb")
    before, _ = environment.reset(seed=2)
    assert before.shape == (64, 64, 3) and before.dtype == np.uint8
    assert environment.observation_space.contains(before)
    # The bead runs from the bottom to the top; beside it the flat plate has one colour.
    middle, beside = before[:, 24:40].astype(float), before[:, 2:10].astype(float)
    assert middle.std() > 3.0 * beside.std()
    for _ in range(60):
        after, *_ = environment.step(np.array([0, 0, 0, 0, 1], dtype=np.float32))
    changed = np.abs(after.astype(int) - before).max(axis=2) > 10
    # The wheel stands in the middle of the picture.
    assert changed[24:40, 24:40].mean() > 0.5 and changed[:, :8].mean() < 0.1


def test_an_episode_ends_in_time_and_begins_again_in_the_next_step(suite: robofin.Suite) -> None:
    environments = gymnasium.make_vec("robofin/Grind-v0", num_envs=2, tasks=suite, time_limit=0.4)
    first, _ = environments.reset(seed=1)
    lifted = np.tile(np.array([0, 0, 0, 0, -1], dtype=np.float32), (2, 1))
    for _ in range(9):
        _, _, terminated, truncated, _ = environments.step(lifted)
        assert not (terminated | truncated).any()
    _, _, terminated, truncated, infos = environments.step(lifted)
    assert truncated.all() and not terminated.any()
    assert infos["metrics"][0, robofin.Batch.metric_names().index("time")] == pytest.approx(0.4)
    seen, rewards, terminated, truncated, infos = environments.step(np.ones((2, 5), dtype=np.float32))
    np.testing.assert_array_equal(seen, first)
    assert not rewards.any() and not (terminated | truncated).any()
    assert not infos["metrics"][:, robofin.Batch.metric_names().index("time")].any()


def test_a_moment_of_an_environment_is_put_back_bit_for_bit(suite: robofin.Suite) -> None:
    environment = gymnasium.make("robofin/Grind-v0", tasks=suite, randomise=ROLL).unwrapped
    environment.reset(seed=9)
    chosen = actions(3, 20, 1)[:, 0]
    for action in chosen[:8]:
        environment.step(action)
    batch = environment.all.batch
    moment, field = batch.snapshot(0), batch.workpiece(0).field
    first = [environment.step(action)[:2] for action in chosen[8:]]
    ended = batch.workpiece(0).field
    batch.restore(0, moment)
    assert batch.workpiece(0).field == field
    again = [environment.step(action)[:2] for action in chosen[8:]]
    assert all(np.array_equal(a[0], b[0]) and a[1] == b[1] for a, b in zip(first, again, strict=True))
    assert batch.workpiece(0).field == ended


def test_rewards_add_up_to_the_bead_that_went_away(suite: robofin.Suite) -> None:
    environments = gymnasium.make_vec("robofin/Grind-v0", num_envs=1, tasks=suite)
    environments.reset(seed=2)
    total = 0.0
    for _ in range(60):
        _, rewards, _, _, infos = environments.step(np.array([[0.3, 0, 0, 0, 0.5]], dtype=np.float32))
        total += rewards[0]
    names = robofin.Batch.metric_names()
    left, gouged, time, returned = (infos["metrics"][0, names.index(name)]
                                    for name in ("left", "gouge_volume", "time", "return"))
    assert returned == pytest.approx(total, abs=1e-12)
    haste = total - (1.0 - left - 5.0 * gouged / suite.tasks[0].volume)
    assert -0.1 < haste < 0.0 and time == pytest.approx(2.4)
    removed = infos["metrics"][0, names.index("removed_volume")]
    assert (1.0 - left) * suite.tasks[0].volume == pytest.approx(removed, rel=0.15)


def test_sanding_takes_the_coating_off() -> None:
    tasks = robofin.suite("sanding", count=1)
    result = robofin.evaluate("raster", tasks, seeds=[0])
    assert result["left"][0] < 0.9 and result["removed_volume"][0] == 0.0
