"""Baselines and intervals."""

import numpy as np
import pytest

import robofin


def test_baselines_are_ordered_as_they_must_be(suite: robofin.Suite) -> None:
    results = {name: robofin.evaluate(name, suite, seeds=[0, 1]) for name in ("nothing", "raster", "oracle")}
    nothing, raster, oracle = (results[name] for name in ("nothing", "raster", "oracle"))
    assert nothing["left"] == pytest.approx(1.0) and nothing["gouge_depth"].max() < 1e-6
    assert not nothing["contact_time"].any()
    assert oracle["left"].max() < 0.1 and raster["left"].max() < 0.9
    assert oracle["return"].mean() > max(raster["return"].mean(), nothing["return"].mean())
    assert oracle["gouge_depth"].mean() <= raster["gouge_depth"].mean()


def test_a_function_is_a_policy_and_its_interval_holds_the_mean(suite: robofin.Suite) -> None:
    def press(seen: np.ndarray) -> np.ndarray:
        return np.tile(np.array([0, 0, 0, 0, 0], dtype=np.float32), (len(seen), 1))

    result = robofin.evaluate(press, suite, seeds=range(3), time_limit=0.4)
    assert result.policy == "press" and result.values.shape == (3, len(result.names))
    mean, low, high = result.mean("removed_volume")
    assert low <= mean <= high and mean > 0.0
    assert "press on grinding/train/easy, 3 episodes" in result._repr_html_()


def test_a_difference_is_taken_episode_by_episode_and_only_between_the_same_episodes(suite: robofin.Suite) -> None:
    drawn = {"grit-dulling.dulling_volume": (100e-9, 1e-6)}
    one, other, third = (robofin.evaluate(name, suite, seeds=seeds, time_limit=1.0, randomise=drawn)
                         for name, seeds in (("raster", range(6)), ("nothing", range(6)), ("raster", range(1, 7))))
    mean, low, high = one.difference(other, "removed_volume")
    assert mean == pytest.approx(one["removed_volume"].mean() - other["removed_volume"].mean()) and low <= mean <= high
    assert one.difference(one, "left") == (0.0, 0.0, 0.0) < one.mean("left")
    with pytest.raises(robofin.WrongUse, match=r"seeds 0 to 5 \(6 of them\).*seeds 1 to 6 \(6 of them\)"):
        one.difference(third, "left")


def test_a_baseline_is_a_function_of_observations(suite: robofin.Suite) -> None:
    named = robofin.evaluate("oracle", suite, seeds=range(2), time_limit=1.0)
    given = robofin.evaluate(robofin.baseline("oracle"), suite, seeds=range(2), time_limit=1.0)
    assert np.array_equal(named.values, given.values)
    with pytest.raises(robofin.WrongUse, match="'nothing', 'raster', 'oracle'"):
        robofin.baseline("guess")


@pytest.mark.parametrize("split", ["train", "held-out"])
def test_hard_welds_are_longer_and_wider_than_easy_ones_on_all_parts(split: str) -> None:
    easy, hard = (robofin.suite("grinding", split, difficulty, count=2).tasks for difficulty in ("easy", "hard"))
    for simple, difficult in zip(easy, hard, strict=True):
        assert difficult.width == pytest.approx(10e-3) and simple.width == pytest.approx(6e-3)
        assert 0.07 <= difficult.length <= 0.11 + 1e-3 and difficult.volume > 2.0 * simple.volume


def test_the_held_out_parts_are_others_and_what_is_unknown_is_refused() -> None:
    held = robofin.suite("grinding", "held-out", count=1)
    assert held.tasks[0].volume > 0.0
    with pytest.raises(robofin.WrongUse, match="'nothing', 'raster', 'oracle'"):
        robofin.evaluate("guess", held)
    with pytest.raises(robofin.WrongUse, match="held-out"):
        robofin.suite("grinding", "test")
    with pytest.raises(robofin.WrongUse, match="no seeds"):
        robofin.evaluate("raster", held, seeds=[])
