"""Items shared by the machines of a Ray cluster: data sets of assets, labelled images, studies, episodes of a policy.

    pip install "./python[ray]"

    import ray
    from robofin import cluster

    ray.init()                                                      # this machine, or address="auto" for a cluster
    cluster.assets("/share/parts", out="/share/set", flags=["--per-part", "10", "--seed", "7"])

Every machine has the package, and reads and writes the same folder. An item follows from its seed and its name alone, so
the files are those that one machine would write, byte for byte. An item is complete or absent: what a killed worker was
making is made again, and the same call again goes on where an earlier one was interrupted.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ._evaluation import Evaluation, Policy, baseline, evaluate
from ._program import Word, run
from ._robofin import Batch, RoboFinError, WrongUse
from ._suites import suite

try:
    import ray
except ImportError as error:
    raise ImportError('robofin.cluster needs Ray: pip install "robofin[ray]"') from error

#: Times that an item is made again after the death of its worker.
RETRIES = 10
#: Shards of a data set: many for each worker, so that a slow one delays little.
SHARDS = 32
#: The recipe of a folder of episodes.
RECIPE = "evaluation.json"


def run_items(make: Callable[[str], None], items: Sequence[str]) -> dict[str, str]:
    """Calls `make` for every item, each as a Ray task of one core, and waits for all. Returns reasons of those that failed.

    `make` must leave an item complete or absent: it is called again if its worker dies. Without `ray.init` before, Ray
    starts on this machine.
    """
    def robofin_item(item: str) -> None:
        make(item)

    task = ray.remote(num_cpus=1, max_retries=RETRIES)(robofin_item)
    waiting = {task.remote(item): item for item in items}
    failed: dict[str, str] = {}
    while waiting:
        (ended, *_), _ = ray.wait(list(waiting), num_returns=1)
        item = waiting.pop(ended)
        try:
            ray.get(ended)
        except ray.exceptions.RayTaskError as error:
            failed[item] = str(error.cause)
        except ray.exceptions.RayError as error:
            failed[item] = f"its worker died {RETRIES + 1} times: {error}"
    return failed


def assets(*sources: Word, out: Word, flags: Sequence[str] = (), shards: int = SHARDS) -> Any:
    """A data set of welded parts, as `robofin dataset` makes it, in shards. Returns its answer.

    `flags` are those of the verb without `--out`, `--shard`, `--jobs` and `--resume`. What shards could not make is tried
    once more at the end, and then refused with the program's message.
    """
    if shards < 1:
        raise WrongUse(f"shards is {shards}, and 1 or more is accepted")
    _own(flags, "--out", "--shard", "--jobs", "--resume", "--dry-run")
    words = ["dataset", *map(_shared, sources), "--out", _shared(out), *flags, "--resume", "--jobs", "1"]
    run_items(partial(_run_with, words, "--shard"), [f"{number}/{shards}" for number in range(1, shards + 1)])
    return run(*words)


def images(out: Word, *, flags: Sequence[str] = (), limit: int | None = None) -> Any:
    """Labelled images, as `robofin dataset images` makes them, one by one. Returns its answer.

    `flags` are those of the verb without `--out`, `--limit`, `--quick`, `--only`, `--jobs` and `--resume`.
    """
    _own(flags, "--out", "--limit", "--quick", "--only", "--jobs", "--resume", "--dry-run")
    words = ["dataset", "images", "--out", _shared(out), *flags, "--resume", "--jobs", "1"]
    limited = [*words, *([] if limit is None else ["--limit", str(limit)])]
    planned = run(*limited, "--dry-run")
    lines = planned if isinstance(planned, list) else [planned]
    run_items(partial(_run_with, words, "--only"), [line["task"] for line in lines if not line["is_there"]])
    return run(*limited)


def studies(campaigns: Sequence[Word], out: Word, *, flags: Sequence[str] = ()) -> list[Path]:
    """Studies of campaigns in folders of their names below `out`. Returns the folders.

    `flags` are those of `robofin study` without `--out`, `--resume`, `--step` and `--force`.
    """
    _own(flags, "--out", "--resume", "--step", "--force")
    folders = {Path(_shared(campaign)).name: _shared(campaign) for campaign in campaigns}
    if len(folders) < len(campaigns):
        raise WrongUse(f"{len(campaigns)} campaigns have {len(folders)} names; folders of different names are accepted")
    place = Path(_shared(out))
    place.mkdir(parents=True, exist_ok=True)
    _check(run_items(partial(_study, folders, place, list(flags)), list(folders)), "studies")
    return [place / name for name in folders]


def episodes(policy: str | Callable[[], Policy], welds: Mapping[str, Any], seeds: Sequence[int], out: Word,
             **keywords: Any) -> Evaluation:
    """Figures of a policy, as `robofin.evaluate` finds them, one episode for each seed, kept in the folder `out`.

    - `policy`: the name of a baseline, or a function without arguments that returns a fresh policy
    - `welds`: arguments of `robofin.suite`, such as `{"split": "held-out", "count": 16}`
    - `keywords`: those of `robofin.evaluate`, as far as JSON can hold them
    """
    name = policy if isinstance(policy, str) else getattr(policy, "__name__", type(policy).__name__)
    folder, chosen = Path(_shared(out)), [int(seed) for seed in seeds]
    if not chosen:
        raise WrongUse("no seeds; at least one is accepted")
    _keep_recipe(folder, {"policy": name, "welds": dict(welds), "keywords": keywords})
    missing = [str(seed) for seed in chosen if not _episode(folder, seed).is_file()]
    _check(run_items(partial(_run_episode, policy, dict(welds), keywords, folder), missing), "episodes")
    values = np.array([json.loads(_episode(folder, seed).read_text()) for seed in chosen])
    return Evaluation(name, suite(**welds).name, tuple(Batch.metric_names()), values, tuple(chosen))


def _run_with(words: Sequence[str], flag: str, item: str) -> None:
    """Runs the program for a part of its work."""
    run(*words, flag, item)


def _study(folders: Mapping[str, str], place: Path, flags: Sequence[str], name: str) -> None:
    """Makes a study beside its place and moves it there, unless it is there."""
    if (place / name).is_dir():
        return
    with TemporaryDirectory(prefix=f".{name}-", dir=place) as draft:
        run("study", folders[name], "--out", str(Path(draft) / name), *flags)
        (Path(draft) / name).rename(place / name)


def _run_episode(policy: str | Callable[[], Policy], welds: Mapping[str, Any], keywords: Mapping[str, Any], folder: Path,
                 seed: str) -> None:
    """Writes the figures of an episode."""
    act = baseline(policy) if isinstance(policy, str) else policy()
    found = evaluate(act, suite(**welds), [int(seed)], **keywords)
    _write(_episode(folder, int(seed)), json.dumps(found.values[0].tolist()))


def _keep_recipe(folder: Path, recipe: Mapping[str, Any]) -> None:
    """Writes what decides the episodes of a folder, or refuses a folder with others."""
    text, place = json.dumps(recipe, indent=2, sort_keys=True) + "\n", folder / RECIPE
    folder.mkdir(parents=True, exist_ok=True)
    if place.is_file() and place.read_text() != text:
        raise WrongUse(f"{place} is of {' '.join(place.read_text().split())}, and {' '.join(text.split())} is asked for; "
                       "another folder is accepted")
    _write(place, text)


def _episode(folder: Path, seed: int) -> Path:
    return folder / f"episode-{seed:010d}.json"


def _write(place: Path, text: str) -> None:
    """Writes a file whole or not at all."""
    draft = place.with_name(f".{place.name}.{os.getpid()}")
    draft.write_text(text)
    draft.replace(place)


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
