"""Items on a Ray cluster of this machine: the bytes of one machine, whatever is killed."""

import importlib.util
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest

import robofin

if not importlib.util.find_spec("ray"):
    pytest.skip("items on a cluster are NOT TESTED: ray is missing", allow_module_level=True)

import ray
from cluster_checks import IMAGES, PART, ROOT, SET, assert_same, descendants, files

from robofin import cluster


@pytest.fixture(scope="module", autouse=True)
def two_cores() -> Iterator[None]:
    """A cluster of this machine. Its workers are as nice as the test: at Ray's usual 15 other work starves them."""
    os.environ["RAY_worker_niceness"] = "0"
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


def kill_when(chosen: Callable[[], list[int]]) -> Thread:
    """Kills the first process that is chosen and what it started, as soon as there is one."""
    def kill() -> None:
        end = time.monotonic() + 120.0
        while not (found := chosen()) and time.monotonic() < end:
            time.sleep(0.005)
        for process in descendants(found[0]):
            os.kill(process, signal.SIGKILL)

    thread = Thread(target=kill, daemon=True)
    thread.start()
    return thread


def workers_with_a_program() -> list[int]:
    """Ray workers of this machine that make an item with the program; Ray names them after their task."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            named = (folder / "cmdline").read_bytes().startswith(b"ray::robofin_item")
        except OSError:
            continue
        if named and len(descendants(int(folder.name))) > 2:
            found.append(int(folder.name))
    return found


def test_a_killed_worker_costs_only_its_item_which_is_made_again(tmp_path: Path) -> None:
    def make(item: str) -> None:
        (tmp_path / f"{item}-runs").open("a").write("x")
        if item == "b" and not (tmp_path / "worker").exists():
            (tmp_path / "draft").write_text(str(os.getpid()))
            (tmp_path / "draft").rename(tmp_path / "worker")
            time.sleep(600)
        (tmp_path / item).write_text(item)

    def started() -> list[int]:
        return [int((tmp_path / "worker").read_text())] if (tmp_path / "worker").exists() else []

    thread = kill_when(started)
    assert cluster.run_items(make, ["a", "b", "c"]) == {}
    thread.join()
    runs = [(tmp_path / f"{item}-runs").read_text() for item in "abc"]
    assert runs == ["x", "xx", "x"] and all((tmp_path / item).read_text() == item for item in "abc")


def test_an_item_that_fails_is_reported_with_its_reason_and_the_others_are_made(tmp_path: Path) -> None:
    def make(item: str) -> None:
        if item == "b":
            raise robofin.WrongUse("b is refused")
        (tmp_path / item).touch()

    assert cluster.run_items(make, ["a", "b", "c"]) == {"b": "b is refused"}
    assert (tmp_path / "a").exists() and (tmp_path / "c").exists()


def test_items_wait_for_those_that_they_need_and_fail_with_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robofin._items.WINDOW", 3)

    def make(item: str) -> None:
        if item == "broken":
            raise robofin.WrongUse("broken is refused")
        time.sleep(0.5 if item == "base" else 0.0)
        assert item == "base" or (tmp_path / "base").exists()
        (tmp_path / item).touch()

    items = ["base", "broken", *"abcde", "late"]
    needs = {item: ["base"] for item in "abcde"} | {"late": ["a", "broken"]}
    ended: list[tuple[int, int]] = []
    failed = cluster.run_items(make, items, needs=needs, progress=lambda *counts: ended.append(counts))
    assert failed == {"broken": "broken is refused", "late": "broken is refused"}
    assert ended == [(count, 8) for count in range(1, 9)]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "base", "c", "d", "e"]


def test_a_data_set_has_the_bytes_of_one_machine_although_a_worker_is_killed(tmp_path: Path) -> None:
    robofin.run("dataset", PART, "--out", tmp_path / "one", *SET)
    thread = kill_when(workers_with_a_program)
    cluster.assets(PART, out=tmp_path / "ray", flags=SET, shards=4)
    assert not thread.is_alive(), "a worker was killed while it made an item"
    assert_same(tmp_path / "one", tmp_path / "ray")
    before = {name: (tmp_path / "ray" / name).stat().st_mtime_ns for name in files(tmp_path / "ray")}
    cluster.assets(PART, out=tmp_path / "ray", flags=SET, shards=4)
    assert before == {name: (tmp_path / "ray" / name).stat().st_mtime_ns for name in files(tmp_path / "ray")}


def test_images_have_the_bytes_of_one_machine(tmp_path: Path) -> None:
    robofin.run("dataset", "images", "--out", tmp_path / "one", *IMAGES)
    cluster.images(tmp_path / "ray", flags=IMAGES)
    assert_same(tmp_path / "one", tmp_path / "ray")


def test_studies_have_the_bytes_of_one_machine(tmp_path: Path) -> None:
    tables = [ROOT / "data/tables/belt-sanding", ROOT / "data/tables/two-passes"]
    made = cluster.studies(tables, tmp_path / "ray")
    for table, folder in zip(tables, made, strict=True):
        robofin.Campaign(table).study(tmp_path / "one" / table.name)
        assert_same(tmp_path / "one" / table.name, folder)


def test_episodes_have_the_figures_of_one_machine_and_are_kept(tmp_path: Path) -> None:
    welds: dict[str, Any] = {"split": "held-out", "count": 1}
    found = cluster.episodes("raster", welds, [3, 1], tmp_path, time_limit=1.0)
    alone = robofin.evaluate("raster", robofin.suite(**welds), [3, 1], time_limit=1.0)
    assert np.array_equal(found.values, alone.values) and found.seeds == alone.seeds and found.policy == "raster"
    kept = tmp_path / "episode-0000000003.json"
    old = kept.stat().st_mtime_ns
    again = cluster.episodes("raster", welds, [1, 2, 3], tmp_path, time_limit=1.0)
    assert kept.stat().st_mtime_ns == old and np.array_equal(again.values[[2, 0]], found.values)
    with pytest.raises(robofin.WrongUse, match="another folder is accepted"):
        cluster.episodes("oracle", welds, [1], tmp_path, time_limit=1.0)


def test_a_function_that_makes_a_policy_runs_on_workers(tmp_path: Path) -> None:
    def lifted() -> robofin.Policy:
        return lambda seen: np.tile(np.array([0, 0, 0, 0, -1], dtype=np.float32), (len(seen), 1))

    found = cluster.episodes(lifted, {"count": 1}, [1], tmp_path, time_limit=0.4)
    assert found.policy == "lifted" and not found["removed_volume"].any()


def test_wrong_use_is_refused_before_anything_runs(tmp_path: Path) -> None:
    with pytest.raises(robofin.WrongUse, match="--jobs"):
        cluster.assets(tmp_path, out=tmp_path / "set", flags=["--jobs", "2"])
    with pytest.raises(robofin.WrongUse, match="shards is 0"):
        cluster.assets(tmp_path, out=tmp_path / "set", shards=0)
    with pytest.raises(robofin.WrongUse, match="folders of different names"):
        cluster.studies([tmp_path / "a/x", tmp_path / "b/x"], tmp_path / "out")
    with pytest.raises(robofin.WrongUse, match="no seeds"):
        cluster.episodes("raster", {}, [], tmp_path / "out")
    assert not (tmp_path / "set").exists() and not (tmp_path / "out").exists()
