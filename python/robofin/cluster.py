"""Items shared by the machines of a Ray cluster: data sets of assets, labelled images, studies, episodes of a policy.

    pip install "./python[ray]"

    import ray
    from robofin import cluster

    ray.init()                                                      # this machine, or address="auto" for a cluster
    cluster.assets("/share/parts", out="/share/set", flags=["--per-part", "10", "--seed", "7"])
    cluster.assets("/share/parts", out="s3://bucket/set", flags=["--per-part", "10", "--seed", "7"])

Every machine has the package and reads the same sources. Results go to a folder that all machines share, or to an
address that fsspec opens. An item follows from its seed and its name alone, so the files are those that one machine
would write, byte for byte. An item is complete or absent: what a killed worker was making is made again, and the same
call again goes on where an earlier one was interrupted.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from . import _remote
from ._evaluation import Evaluation, Policy, baseline, evaluate
from ._items import RETRIES, ClusterLost, Progress, cores, run_items
from ._program import Word, answers, run
from ._robofin import Batch, RoboFinError, WrongUse
from ._storage import Place, is_address, open_place
from ._suites import suite

__all__ = ["RETRIES", "SHARDS", "ClusterLost", "assets", "episodes", "images", "run_items", "studies"]

#: Least number of shards of a data set in a folder, and shards for each core: many, so that a slow one delays little.
SHARDS, SHARDS_OF_CORE = 32, 4
#: The recipe of a folder of episodes.
RECIPE = "evaluation.json"
#: The file of a study that is put to an address last.
STUDY = "study.json"


def assets(*sources: Word, out: Word, flags: Sequence[str] = (), shards: int | None = None,
           progress: Progress | None = None) -> Any:
    """A data set of welded parts, as `robofin dataset` makes it. Returns its answer.

    In a folder, workers make shards, by default 4 for each core and at least 32; at an address, single items. What
    workers could not make is tried once more at the end, and then refused with the program's message.

    - `flags`: those of the verb without `--out`, `--shard`, `--jobs` and `--resume`
    - `progress`: is called with the number of ended shards or items and that of all
    """
    if shards is not None and shards < 1:
        raise WrongUse(f"shards is {shards}, and 1 or more is accepted")
    _own(flags, "--out", "--shard", "--jobs", "--resume", "--dry-run")
    places = [str(Path(source).absolute()) for source in sources]
    if is_address(out):
        return _remote.assets(places, str(out), flags, progress)
    words = ["dataset", *places, "--out", _shared(out), *flags, "--resume", "--jobs", "1"]
    of = shards or max(SHARDS, SHARDS_OF_CORE * cores())
    items = [f"{number}/{of}" for number in range(1, of + 1)]
    run_items(partial(_run_with, words, "--shard"), items, progress=progress)
    return run(*words)


def images(out: Word, *, flags: Sequence[str] = (), limit: int | None = None, progress: Progress | None = None) -> Any:
    """Labelled images, as `robofin dataset images` makes them, one by one. Returns its answer.

    `flags` are those of the verb without `--out`, `--limit`, `--quick`, `--only`, `--jobs` and `--resume`. Workpieces,
    simulations and views are items, too. `progress` is called with the number of ended items and that of all.
    """
    _own(flags, "--out", "--limit", "--quick", "--only", "--jobs", "--resume", "--dry-run")
    limits = [] if limit is None else ["--limit", str(limit)]
    if is_address(out):
        return _remote.images(str(out), flags, limits, progress)
    words = ["dataset", "images", "--out", _shared(out), *flags, "--resume", "--jobs", "1"]
    missing = [line for line in answers(run(*words, *limits, "--dry-run")) if not line["is_there"]]
    needs = {line["task"]: line["needs"] for line in missing}
    run_items(partial(_run_with, words, "--only"), list(needs), needs=needs, progress=progress)
    return run(*words, *limits)


def studies(campaigns: Sequence[Word], out: Word, *, flags: Sequence[str] = (),
            progress: Progress | None = None) -> list[Path] | list[str]:
    """Studies of campaigns in folders of their names below `out`. Returns the folders, or their addresses.

    `flags` are those of `robofin study` without `--out`, `--resume`, `--step` and `--force`. `progress` is called with
    the number of ended studies and that of all.
    """
    _own(flags, "--out", "--resume", "--step", "--force")
    folders = {Path(campaign).name: str(Path(campaign).absolute()) for campaign in campaigns}
    if len(folders) < len(campaigns):
        raise WrongUse(f"{len(campaigns)} campaigns have {len(folders)} names; folders of different names are accepted")
    place = open_place(out)
    make = partial(_study, folders, place, list(flags))
    _check(run_items(make, list(folders), progress=progress), "studies")
    return [place.folder / name for name in folders] if place.folder else [f"{out}/{name}" for name in folders]


def episodes(policy: str | Callable[[], Policy], welds: Mapping[str, Any], seeds: Sequence[int], out: Word,
             progress: Progress | None = None, **keywords: Any) -> Evaluation:
    """Figures of a policy, as `robofin.evaluate` finds them, one episode for each seed, kept in the folder `out`.

    - `policy`: the name of a baseline, or a function without arguments that returns a fresh policy
    - `welds`: arguments of `robofin.suite`, such as `{"split": "held-out", "count": 16}`
    - `out`: a folder or an address
    - `progress`: is called with the number of ended episodes and that of all
    - `keywords`: those of `robofin.evaluate`, as far as JSON can hold them
    """
    name = policy if isinstance(policy, str) else getattr(policy, "__name__", type(policy).__name__)
    chosen = [int(seed) for seed in seeds]
    if not chosen:
        raise WrongUse("no seeds; at least one is accepted")
    place = open_place(out)
    _keep_recipe(place, {"policy": name, "welds": dict(welds), "keywords": keywords})
    missing = [str(seed) for seed in chosen if place.read(_episode(seed)) is None]
    make = partial(_run_episode, policy, dict(welds), keywords, place)
    _check(run_items(make, missing, progress=progress), "episodes")
    values = np.array([json.loads(place.read(_episode(seed)) or "") for seed in chosen])
    return Evaluation(name, suite(**welds).name, tuple(Batch.metric_names()), values, tuple(chosen))


def _run_with(words: Sequence[str], flag: str, item: str) -> None:
    """Runs the program for a part of its work."""
    run(*words, flag, item)


def _study(folders: Mapping[str, str], place: Place, flags: Sequence[str], name: str) -> None:
    """Makes a study in a hidden folder and moves it to its place, unless it is there."""
    if place.read(f"{name}/{STUDY}") is not None:
        return
    with TemporaryDirectory(prefix=f".{name}-", dir=place.folder) as draft:
        run("study", folders[name], "--out", str(Path(draft) / name), *flags)
        place.publish(Path(draft), name, STUDY)


def _run_episode(policy: str | Callable[[], Policy], welds: Mapping[str, Any], keywords: Mapping[str, Any],
                 place: Place, seed: str) -> None:
    """Writes the figures of an episode."""
    act = baseline(policy) if isinstance(policy, str) else policy()
    found = evaluate(act, suite(**welds), [int(seed)], **keywords)
    place.write(_episode(int(seed)), json.dumps(found.values[0].tolist()))


def _keep_recipe(place: Place, recipe: Mapping[str, Any]) -> None:
    """Writes what decides the episodes of a folder, or refuses a folder with others."""
    text = json.dumps(recipe, indent=2, sort_keys=True) + "\n"
    kept = place.read(RECIPE)
    if kept is not None and kept != text:
        raise WrongUse(f"{RECIPE} in {place.name} is of {' '.join(kept.split())}, and {' '.join(text.split())} is asked "
                       "for; another folder is accepted")
    place.write(RECIPE, text)


def _episode(seed: int) -> str:
    return f"episode-{seed:010d}.json"


def _shared(place: Word) -> str:
    """The absolute path of a place, since workers have folders of their own."""
    return str(Path(place).absolute())


def _own(flags: Sequence[str], *own: str) -> None:
    """Refuses flags that this module sets itself."""
    if taken := [flag for flag in flags if flag.partition("=")[0] in own]:
        raise WrongUse(f"flags has {', '.join(taken)}; {', '.join(own)} are set by the cluster or by arguments")


def _check(failed: Mapping[str, str], what: str) -> None:
    """Raises the first reason of items that failed."""
    if failed:
        item, reason = min(failed.items())
        raise RoboFinError(f"{len(failed)} {what} failed, among them {item}: {reason}; the same call tries them again")
