"""Items as Ray tasks: retries, lost nodes, order, progress."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, islice
from typing import Any

from ._robofin import RoboFinError

try:
    import ray
except ImportError as error:
    raise ImportError('robofin.cluster needs Ray: pip install "robofin[ray]"') from error

try:
    from grpc import RpcError
except ImportError:
    RpcError = ConnectionError

#: Times that an item is made again after the death of its worker.
RETRIES = 10
#: Most items that Ray holds at a time: its memory is bounded, whatever the size of the set.
WINDOW = 4096

#: What Ray raises where the head of the cluster, or the connection to it, is gone.
LOST = (ConnectionError, RpcError, ray.exceptions.RaySystemError)

Progress = Callable[[int, int], None]


class ClusterLost(RoboFinError):
    """The connection to the cluster is gone. The same call makes what is missing, once a cluster is connected again."""


def run_items(make: Callable[[str], None], items: Sequence[str], *, needs: Mapping[str, Sequence[str]] | None = None,
              progress: Progress | None = None) -> dict[str, str]:
    """Calls `make` for every item, each as a Ray task of one core, and waits for all. Returns reasons of those that failed.

    `make` must leave an item complete or absent: it is called again if its worker dies. Without `ray.init` before, Ray
    starts on this machine. Raises `ClusterLost` if the head of the cluster is gone.

    - `needs`: for an item, those before it in `items` that must be made first; if one fails, the item fails, too
    - `progress`: is called with the number of ended items and that of all
    """
    def robofin_item(item: str, *_: None) -> None:
        make(item)

    task = ray.remote(num_cpus=1, max_retries=RETRIES)(robofin_item)
    failed: dict[str, str] = {}
    try:
        for ended, (item, made) in enumerate(_ended(task, items, needs or {}), start=1):
            if reason := _reason(made):
                failed[item] = reason
            if progress:
                progress(ended, len(items))
    except LOST as error:
        raise ClusterLost(f"the cluster is lost: {str(error).partition(chr(10))[0]}; connected again, the same call makes "
                          "what is missing") from error
    return failed


def cores() -> int:
    """Cores of the cluster; without `ray.init` before, Ray starts on this machine."""
    if not ray.is_initialized():
        ray.init()
    resources: Any = ray.cluster_resources
    return int(resources().get("CPU", 0))


def _ended(task: Any, items: Sequence[str], needs: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, Any]]:
    """Starts items in their order, at most `WINDOW` at a time, and yields each with its Ray reference as it ends."""
    needed = set(chain.from_iterable(needs.values()))
    kept: dict[str, Any] = {}
    waiting: dict[Any, str] = {}
    ahead = iter(items)
    while True:
        for item in islice(ahead, WINDOW - len(waiting)):
            made = task.remote(item, *(kept[each] for each in needs.get(item, ()) if each in kept))
            waiting[made] = item
            if item in needed:
                kept[item] = made
        if not waiting:
            return
        ray.wait(list(waiting), num_returns=1)
        ended, _ = ray.wait(list(waiting), num_returns=len(waiting), timeout=0)
        for made in ended:
            yield waiting.pop(made), made


def _reason(made: Any) -> str | None:
    """Why an item that has ended failed; `None` if it did not."""
    try:
        ray.get(made)
    except ray.exceptions.RayTaskError as error:
        return str(error.cause)
    except LOST:
        raise
    except ray.exceptions.RayError as error:
        return f"its worker died {RETRIES + 1} times: {error}"
    return None
