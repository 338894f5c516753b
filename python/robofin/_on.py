"""`robofin dataset ... --on ADDRESS`: a data set made by a Ray cluster."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

from ._program import WRONG_USE
from ._robofin import RoboFinError, WrongUse

#: The flag that names the cluster.
ON = "--on"
#: Times that a lost cluster is connected again, and the pause before each [s]: a quarter of an hour to start its head.
ATTEMPTS, PAUSE = 90, 10.0
#: Flags that a cluster sets itself.
OWN = ("--resume",)


def is_meant(words: Sequence[str]) -> bool:
    """True if a command line of `robofin dataset` names a cluster."""
    return words[:1] == ["dataset"] and any(word.partition("=")[0] == ON for word in words)


def main(words: Sequence[str]) -> int:
    """Runs the command line, and again when the cluster was lost. Returns the exit code."""
    try:
        answer = _attempt(list(words))
    except (ImportError, RoboFinError) as error:
        _tell(f"error: {error}")
        return WRONG_USE if isinstance(error, WrongUse) else 1
    if "--json" in words:
        print(json.dumps(answer))
    _tell(f"done    {json.dumps(answer[-1] if isinstance(answer, list) else answer)}")
    return 0


def _attempt(words: list[str]) -> Any:
    """Connects and makes the set; waits for the head of a lost cluster to be started again."""
    on, out, limit = (_taken(words, flag) for flag in (ON, "--out", "--limit" if "images" in words[:2] else ""))
    if not on or not out:
        raise WrongUse("--on ADDRESS and --out PLACE are needed, for example --on ray://head:10001 --out s3://bucket/set")
    from .cluster import ClusterLost

    try:
        _connect(on)
    except ClusterLost as error:
        raise WrongUse(f"{error}; the address of a running cluster is accepted, or {ON} local") from error
    for attempt in range(ATTEMPTS):
        try:
            if attempt > 0:
                _connect(on)
            return _make(words, out, limit)
        except ClusterLost as error:
            _tell(f"lost    {error}; attempt {attempt + 1} of {ATTEMPTS} in {PAUSE:.0f} s")
            time.sleep(PAUSE)
    raise ClusterLost(f"{on} is lost; start its head and repeat the command, which makes only what is missing")


def _connect(on: str) -> None:
    """Connects to a cluster: `auto`, `ray://head:10001` or `head:6379`; `local` starts one on this machine."""
    import ray

    from ._items import LOST, ClusterLost

    ray.shutdown()
    try:
        ray.init(on, log_to_driver=False)
    except LOST as error:
        raise ClusterLost(f"{on} does not answer: {str(error).partition(chr(10))[0]}") from error
    except ValueError as error:
        raise WrongUse(f"{ON} {on}: {error}") from error


def _make(words: Sequence[str], out: str, limit: str | None) -> Any:
    """Makes the set: sources are the words between the verb and the first flag."""
    from . import cluster

    given = [word for word in words[1:] if word not in ("--json", *OWN)]
    if given[:1] == ["images"]:
        return cluster.images(out, flags=given[1:], limit=int(limit) if limit else None, progress=_progress)
    first = next((number for number, word in enumerate(given) if word.startswith("-")), len(given))
    if first == 0:
        raise WrongUse(f"with {ON}, parts are the words before the first flag: robofin dataset parts {ON} auto ...")
    return cluster.assets(*given[:first], out=out, flags=given[first:], progress=_progress)


def _taken(words: list[str], flag: str) -> str | None:
    """Removes a flag and returns its value; `None` if it is not given."""
    for number, word in enumerate(words):
        name, is_joined, value = word.partition("=")
        if name == flag and flag:
            del words[number]
            return value if is_joined else words.pop(number) if number < len(words) else None
    return None


def _progress(ended: int, of: int) -> None:
    _tell(f"items   {ended} of {of}")


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
