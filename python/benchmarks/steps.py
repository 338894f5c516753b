"""How many environment steps a second, what Python adds, and how long a snapshot takes.

    python benchmarks/steps.py [environments] [steps]

Wall time on a machine that others use says little: the figures are also given by CPU time, of all threads together.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import robofin
from robofin._gymnasium import FinishingVectorEnv


def main() -> None:
    """Measures and prints."""
    given = [int(word) for word in sys.argv[1:]]
    count, steps = (*given, *(64, 200)[len(given):])
    tasks = robofin.suite("grinding", difficulty="easy", count=2)
    environments = FinishingVectorEnv(count, tasks=tasks)
    print(f"{count} environments, {tasks.tasks[0].nbytes / 1e6:.1f} and {tasks.tasks[-1].nbytes / 1e6:.1f} MB of field")
    random = np.random.default_rng(0)
    steady = np.tile(np.array([0.5, 0, 0, 0, 0], dtype=np.float32), (steps, count, 1))
    for name, actions in [("steady feed", steady), ("random", random.uniform(-1, 1, steady.shape).astype(np.float32))]:
        measure(name, environments, actions)
    moments(environments)


def measure(name: str, environments: FinishingVectorEnv, actions: np.ndarray) -> None:
    """Steps a second under actions, and the share of Python in the time."""
    environments.reset(seed=0)
    inside, inner = 0.0, environments.batch.step

    class Timed:
        def __getattr__(self, attribute: str) -> object:
            return getattr(batch, attribute)

        def step(self, *arrays: np.ndarray) -> None:
            nonlocal inside
            begun = time.perf_counter()
            inner(*arrays)
            inside += time.perf_counter() - begun

    batch, environments.batch = environments.batch, Timed()
    begun, cpu = time.perf_counter(), time.process_time()
    for action in actions:
        environments.step(action)
    wall, cpu = time.perf_counter() - begun, time.process_time() - cpu
    environments.batch = batch
    total = len(actions) * environments.num_envs
    print(f"{name}: {total / wall:.0f} steps a second of wall time, {2 * total / cpu:.0f} of two whole cores; "
          f"{1e6 * cpu / total:.0f} µs of CPU time a step, Python {100 * (1 - inside / wall):.1f} % of the time")


def moments(environments: FinishingVectorEnv) -> None:
    """Time of a snapshot, of putting it back, and of the copy that the step after makes."""
    batch, taken, put_back = environments.batch, [], []
    for _ in range(50):
        begun = time.perf_counter()
        moment = batch.snapshot(0)
        taken.append(time.perf_counter() - begun)
        begun = time.perf_counter()
        batch.restore(0, moment)
        put_back.append(time.perf_counter() - begun)
    print(f"snapshot {1e6 * np.median(taken):.0f} µs, restore {1e6 * np.median(put_back):.0f} µs (medians of 50)")


if __name__ == "__main__":
    main()
