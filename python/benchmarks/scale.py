"""Figures behind the plan of a million assets on a cluster: rates, memory of the driver, requests, bytes.

    python benchmarks/scale.py benchmarks/scale.json

Needs `pip install "./python[ray]" s3fs "moto[server]" psutil`. Nodes are simulated on this machine: their workers sleep
as long as an asset takes. `python benchmarks/scale_figure.py` draws the file.
"""

from __future__ import annotations

import json
import logging
import os
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import psutil
import ray
from ray.cluster_utils import Cluster

import robofin
from robofin import _items, cluster

PART = Path(__file__).parents[2] / "data/bracket.obj"
#: Assets of each measured set, and the workers that share them.
ASSETS, WORKERS = 16, (1, 2, 4)
#: Nodes of a simulated cluster, workers of each, and items for each worker.
NODES, WORKERS_OF_NODE, ITEMS_OF_WORKER = (1, 2, 4, 8), 8, 10
#: Sleep that stands for an asset [s]: the CPU time of one, by docs/datasets.md.
ASSET_SECONDS = 0.86
#: Items without work, for the rate and the memory of the driver.
EMPTY_ITEMS = 20_000


def main() -> None:
    """Measures, and writes the file."""
    os.environ |= {"RAY_worker_niceness": "0", "RAY_AUTH_MODE": "disabled"}
    found: dict[str, Any] = {"cores": os.cpu_count(), "ray": ray.__version__, "asset_seconds": ASSET_SECONDS}
    found["assets"] = [real(workers) for workers in WORKERS]
    found["address"] = address()
    found["simulated"] = [simulated(nodes) for nodes in NODES]
    found["driver"] = [driver(window) for window in (_items.WINDOW, EMPTY_ITEMS)]
    found["load"] = os.getloadavg()[2]
    Path(sys.argv[1]).write_text(json.dumps(found, indent=1) + "\n")


def flags(count: int) -> list[str]:
    """Flags of a set of this many assets."""
    return ["--per-part", str(count), "--seed", "7", "--difficulty", "easy"]


def real(workers: int) -> dict[str, float]:
    """Assets on workers of this machine, in a folder: wall time, their rate, and the time of a call that makes nothing."""
    with tempfile.TemporaryDirectory() as place:
        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
        out = Path(place) / "set"
        first = timed(lambda: cluster.assets(PART, out=out, flags=flags(ASSETS), shards=ASSETS))
        again = timed(lambda: robofin.run("dataset", PART, "--out", out, *flags(ASSETS), "--resume"))
        ray.shutdown()
        files = [path for path in (out / "assets").rglob("*") if path.is_file()]
        size = sum(path.stat().st_size for path in files)
    return {"workers": workers, "assets": ASSETS, "seconds": first, "again_seconds": again,
            "bytes": size / ASSETS, "files": len(files) / ASSETS}


def address() -> dict[str, Any]:
    """Assets at an address of a server on this machine, by two workers: wall time, and its requests by kind."""
    from moto.server import ThreadedMotoServer

    counted: Counter[str] = Counter()

    class Count(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            counted.update(re.findall(r"(GET|HEAD|PUT|POST|DELETE) /", record.getMessage()))

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    log = logging.getLogger("werkzeug")
    log.addHandler(Count())
    log.setLevel(logging.INFO)
    log.propagate = False
    host, port = server.get_host_and_port()
    os.environ |= {"AWS_ENDPOINT_URL": f"http://{host}:{port}", "AWS_ACCESS_KEY_ID": "x", "AWS_SECRET_ACCESS_KEY": "x"}
    import fsspec

    fsspec.filesystem("s3").mkdir("sets")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    found: dict[str, Any] = {"workers": 2, "assets": ASSETS}
    for name in ("", "again_"):
        counted.clear()
        found[f"{name}seconds"] = timed(lambda: cluster.assets(PART, out="s3://sets/one", flags=flags(ASSETS)))
        found[f"{name}requests"] = dict(sorted(counted.items()))
    ray.shutdown()
    server.stop()
    return found


def simulated(nodes: int) -> dict[str, float]:
    """Items that sleep on a cluster of simulated nodes: their rate, and that of workers without overhead."""
    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": 80_000_000}
    made = Cluster(initialize_head=True, head_node_args=head)
    for _ in range(nodes):
        made.add_node(num_cpus=WORKERS_OF_NODE, object_store_memory=80_000_000)
    ray.init(made.address, log_to_driver=False)
    workers = nodes * WORKERS_OF_NODE
    sleep(workers * 2)
    seconds = timed(lambda: sleep(workers * ITEMS_OF_WORKER))
    ray.shutdown()
    made.shutdown()
    return {"nodes": nodes, "workers": workers, "items_per_second": workers * ITEMS_OF_WORKER / seconds,
            "ideal_items_per_second": workers / ASSET_SECONDS}


def sleep(items: int) -> None:
    """Runs items that sleep as long as an asset takes."""
    pause = ASSET_SECONDS
    cluster.run_items(lambda _: time.sleep(pause), [str(item) for item in range(items)])


def driver(window: int) -> dict[str, float]:
    """Items without work: rate of one driver, and growth of its memory, with at most `window` items in Ray."""
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    cluster.run_items(lambda _: None, ["warm", "up"])
    _items.WINDOW, kept = window, _items.WINDOW
    process, most = psutil.Process(), 0
    before = process.memory_info().rss

    def watch(ended: int, of: int) -> None:
        nonlocal most
        if ended % 500 == 0:
            most = max(most, process.memory_info().rss)

    items = [str(item) for item in range(EMPTY_ITEMS)]
    cpu = sum(process.cpu_times()[:2])
    seconds = timed(lambda: cluster.run_items(lambda _: None, items, progress=watch))
    cpu = sum(process.cpu_times()[:2]) - cpu
    _items.WINDOW = kept
    ray.shutdown()
    return {"window": window, "items": EMPTY_ITEMS, "items_per_second": EMPTY_ITEMS / seconds,
            "driver_cpu_seconds_per_item": cpu / EMPTY_ITEMS, "driver_bytes": max(most - before, 0)}


def timed(work: Any) -> float:
    """Wall time of a call [s]."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


if __name__ == "__main__":
    main()
