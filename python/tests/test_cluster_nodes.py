"""A Ray cluster of a head and two nodes on this machine, parts of which are killed while `robofin dataset --on` runs."""

import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import robofin

if missing := [name for name in ("ray", "grpc") if not importlib.util.find_spec(name)]:
    pytest.skip(f"lost nodes and heads are NOT TESTED: {', '.join(missing)} missing", allow_module_level=True)

from cluster_checks import PART, assert_same, descendants
from ray._private.node import Node
from ray.cluster_utils import Cluster

FLAGS = ["--per-part", "8", "--seed", "7", "--voxel-mm", "1", "--difficulty", "easy"]
#: Longest wait for a step of a test [s]; machines that others use are slow.
PATIENCE = 300.0


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("", 0))
        return int(found.getsockname()[1])


class Machines:
    """A head without cores and two nodes of one core."""

    def __init__(self) -> None:
        self.head: dict[str, Any] = {"num_cpus": 0, "include_dashboard": False, "gcs_server_port": free_port(),
                                     "ray_client_server_port": free_port(), "object_store_memory": 80_000_000}
        self.cluster = Cluster(initialize_head=True, head_node_args=self.head)
        self.address = str(self.cluster.address)
        self.client = f"ray://{self.address.partition(':')[0]}:{self.head['ray_client_server_port']}"
        self.nodes = [self.cluster.add_node(num_cpus=1, object_store_memory=80_000_000) for _ in range(2)]


@pytest.fixture
def machines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Machines]:
    """Machines whose head keeps its state in a folder, so that it can be started again; losses are seen within seconds."""
    if not hasattr(Node, "_is_rocksdb_gcs"):
        pytest.skip("lost nodes and heads are NOT TESTED: this Ray keeps no state of a head without Redis")
    settings = {"AUTH_MODE": "disabled", "gcs_storage": "rocksdb", "gcs_storage_path": str(tmp_path / "head"),
                "health_check_initial_delay_ms": "1000", "health_check_period_ms": "1000", "worker_niceness": "0"}
    for name, value in settings.items():
        monkeypatch.setenv(f"RAY_{name}", value)
    made = Machines()
    yield made
    made.cluster.shutdown()


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The set as one machine makes it."""
    folder = tmp_path_factory.mktemp("alone") / "set"
    robofin.run("dataset", PART, "--out", folder, *FLAGS)
    return folder


class Run:
    """`robofin dataset --on` as a process, observed: every folder that each asset has ever had."""

    def __init__(self, on: str, out: Path) -> None:
        self.out, self.seen = out, set[tuple[str, int]]()
        words = ["dataset", str(PART), "--on", on, "--out", str(out), *FLAGS]
        self.text = (out.parent / "driver.txt").open("w+")
        self.process = subprocess.Popen([sys.executable, "-m", "robofin", *words], stderr=self.text)

    def wait(self, until: Callable[[], bool]) -> None:
        """Observes until something holds, or the process ends."""
        end = time.monotonic() + PATIENCE
        while self.process.poll() is None and not until():
            assert time.monotonic() < end, self.output()
            for asset in (self.out / "assets").glob("[!.]*"):
                self.seen.add((asset.name, asset.stat().st_ino))
            time.sleep(0.02)

    def end(self) -> str:
        """Waits for success, with all assets made by workers, none by the driver; returns what the process said."""
        self.wait(lambda: False)
        assert self.process.returncode == 0 and '"made": 0, "there": 8' in self.output(), self.output()
        return self.output()

    def is_in_the_middle(self) -> bool:
        return 2 <= len(self.seen) < 8

    def output(self) -> str:
        self.text.seek(0)
        return self.text.read()

    def assert_complete(self, alone: Path) -> None:
        """The set has the bytes of one machine, and no asset was replaced by another attempt."""
        assert_same(alone, self.out)
        assert len({name for name, _ in self.seen}) == len(self.seen) == 8


def test_a_set_has_every_item_once_although_a_node_is_killed(machines: Machines, alone: Path, tmp_path: Path) -> None:
    run = Run(machines.address, tmp_path / "set")
    run.wait(run.is_in_the_middle)
    machines.cluster.remove_node(machines.nodes[1], allow_graceful=False)
    assert len(run.seen) < 8
    run.end()
    run.assert_complete(alone)


def test_a_worker_that_dies_alone_loses_nothing(machines: Machines, alone: Path, tmp_path: Path) -> None:
    run = Run(machines.address, tmp_path / "set")
    run.wait(run.is_in_the_middle)
    busy = [process for node in machines.nodes for process in workers_with_a_program(node)]
    while not busy:
        busy = [process for node in machines.nodes for process in workers_with_a_program(node)]
    os.kill(busy[0], signal.SIGKILL)
    run.end()
    run.assert_complete(alone)


def workers_with_a_program(node: Any) -> list[int]:
    """Workers of a node that run the program; Ray names them after their task."""
    (raylet,) = node.all_processes["raylet"]
    found = []
    for process in descendants(raylet.process.pid):
        try:
            named = Path(f"/proc/{process}/cmdline").read_bytes().startswith(b"ray::robofin_item")
        except OSError:
            continue
        if named and len(descendants(process)) > 2:
            found.append(process)
    return found


def test_the_driver_goes_on_when_the_service_of_the_head_is_started_again(machines: Machines, alone: Path,
                                                                         tmp_path: Path) -> None:
    run = Run(machines.address, tmp_path / "set")
    run.wait(run.is_in_the_middle)
    machines.cluster.head_node.kill_gcs_server(check_alive=False)
    time.sleep(1.0)
    machines.cluster.head_node.start_gcs_server()
    assert "lost" not in run.end()
    run.assert_complete(alone)


def test_a_client_connects_again_when_the_whole_head_is_started_again(machines: Machines, alone: Path,
                                                                     tmp_path: Path) -> None:
    run = Run(machines.client, tmp_path / "set")
    run.wait(run.is_in_the_middle)
    machines.cluster.remove_node(machines.cluster.head_node, allow_graceful=False)
    machines.cluster.add_node(**machines.head)
    assert "lost    the cluster is lost" in run.end()
    run.assert_complete(alone)


def test_wrong_use_of_a_cluster_is_refused_with_a_message(tmp_path: Path) -> None:
    def refused(*words: str) -> str:
        done = subprocess.run([sys.executable, "-m", "robofin", "dataset", *words], capture_output=True, text=True)
        assert done.returncode == 2, done.stderr
        return done.stderr

    out = ["--out", str(tmp_path / "set")]
    assert "--on ADDRESS and --out PLACE are needed" in refused(str(PART), "--on", "auto")
    assert "127.0.0.1:1 does not answer" in refused(str(PART), "--on", "ray://127.0.0.1:1", *out)
    assert not (tmp_path / "set").exists()
