"""Traces geodesics with potpourri3d: reads `positions`, `triangles`, `starts` (f64) of a folder, writes `ends`.

A start is a triangle, three weights and a heading as long as the way. Two numbers are printed: the least CPU seconds
of five runs for preparing the mesh and for all traces.
"""

import sys
import time
from pathlib import Path

import numpy
import potpourri3d

RUNS = 5


def least(work):
    best = float("inf")
    for _ in range(RUNS):
        started = time.process_time()
        made = work()
        best = min(best, time.process_time() - started)
    return best, made


def main():
    folder = Path(sys.argv[1])
    read = lambda name, width: numpy.fromfile(folder / name).reshape(-1, width)
    positions, triangles, starts = read("positions", 3), read("triangles", 3).astype(int), read("starts", 7)
    build, tracer = least(lambda: potpourri3d.GeodesicTracer(positions, triangles))
    trace = lambda row: tracer.trace_geodesic_from_face(int(row[0]), row[1:4], row[4:7])[-1]
    traced, ends = least(lambda: [trace(row) for row in starts])
    numpy.array(ends, dtype=float).tofile(folder / "ends")
    print(build, traced)


if __name__ == "__main__":
    main()
