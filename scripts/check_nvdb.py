#!/usr/bin/env python3
"""Opens a .nvdb file with NVIDIA Warp, an independent reader, on the CPU, and samples every grid.

    pip install warp-lang numpy
    python scripts/check_nvdb.py phi.nvdb [--points N] [--seed S] [--expect FILE]

Prints one JSON line per grid. For a level set (float, negative somewhere, its background above 0) it checks that no value
exceeds the band, at random voxels in and around the grid too, and that the gradient of the field as Warp samples it is 1 on
average near the surface.

FILE holds lines "grid i j k value": the value Warp must find at voxel (i, j, k), to the last bit. With a decimal point in
i, j and k it is a place between voxels, where Warp's trilinear sample must be within 1e-5 of the grid's range.

Exit code 0: all checks hold; 1: one does not; 2: wrong use or Warp is missing.
"""

import argparse
import contextlib
import json
import sys
from collections import defaultdict

try:
    import numpy as np
    import warp as wp
except ImportError as error:
    sys.exit(print(f"{error}; pip install warp-lang numpy", file=sys.stderr) or 2)


@wp.kernel
def lookup_float(volume: wp.uint64, voxels: wp.array2d(dtype=wp.int32), out: wp.array(dtype=wp.float32)):
    i = wp.tid()
    out[i] = wp.volume_lookup_f(volume, voxels[i, 0], voxels[i, 1], voxels[i, 2])


@wp.kernel
def lookup_int(volume: wp.uint64, voxels: wp.array2d(dtype=wp.int32), out: wp.array(dtype=wp.int32)):
    i = wp.tid()
    out[i] = wp.volume_lookup_i(volume, voxels[i, 0], voxels[i, 1], voxels[i, 2])


@wp.kernel
def sample_float(volume: wp.uint64, at: wp.array(dtype=wp.vec3), out: wp.array(dtype=wp.float32)):
    i = wp.tid()
    out[i] = wp.volume_sample_f(volume, at[i], wp.Volume.LINEAR)


@wp.kernel
def sample_gradient(volume: wp.uint64, at: wp.array(dtype=wp.vec3), out: wp.array(dtype=wp.float32)):
    i = wp.tid()
    gradient = wp.vec3()
    wp.volume_sample_grad_f(volume, at[i], wp.Volume.LINEAR, gradient)
    out[i] = wp.length(gradient)


def lookup(volume, voxels):
    """Values at voxels [n, 3]."""
    kernel, dtype = (lookup_float, wp.float32) if volume.dtype == wp.float32 else (lookup_int, wp.int32)
    out = wp.zeros(len(voxels), dtype=dtype, device="cpu")
    voxels = wp.array(voxels, dtype=wp.int32, device="cpu")
    wp.launch(kernel, len(voxels), inputs=[volume.id, voxels], outputs=[out], device="cpu")
    return out.numpy()


def grids(path):
    """All grids of a file, with their names."""
    with open(path, "rb") as file:
        volume = wp.Volume.load_from_nvdb(file, device="cpu")
    while volume is not None:
        yield volume.get_grid_info().name, volume
        volume = volume.load_next_grid()


def check_level_set(volume, stored, values, background, points, rng):
    """Complaints about a level set, and figures."""
    complaints = []
    band = float(background)
    low, high = stored.min(axis=0) - 40, stored.max(axis=0) + 41
    found = lookup(volume, rng.integers(low, high, size=(points, 3)).astype(np.int32))
    if not (np.all(np.abs(values) <= band) and np.all(np.abs(found) <= band)):
        complaints.append("a value exceeds the band")
    near = stored[np.abs(values) < 0.4 * band]
    slope = 0.0
    if len(near):
        near = near[rng.integers(0, len(near), size=points)]
        out = wp.zeros(points, dtype=wp.float32, device="cpu")
        at = wp.array(near + rng.random((points, 3)), dtype=wp.vec3, device="cpu")
        wp.launch(sample_gradient, points, inputs=[volume.id, at], outputs=[out], device="cpu")
        slope = float(np.mean(out.numpy()) / volume.get_voxel_size()[0])
        if not 0.9 < slope < 1.1:
            complaints.append(f"the gradient is {slope:.3f} on average")
    figures = {"inside": int((found < 0).sum()), "outside": int((found > 0).sum()), "mean_gradient": round(slope, 4)}
    return complaints, figures


def check_expected(volume, rows, reach):
    """Complaints about values that differ from the expected ones, and figures; reach is the grid's largest value."""
    exact = [row for row in rows if row[4]]
    between = [row for row in rows if not row[4]]
    complaints, figures = [], {"expected": len(rows)}
    if exact:
        found = lookup(volume, np.array([row[:3] for row in exact], dtype=np.int32))
        expected = np.array([row[3] for row in exact], dtype=np.float64).astype(found.dtype)
        differing = int((found != expected).sum())
        figures |= {"differing": differing, "largest_difference": largest_difference(found, expected)}
        if differing:
            complaints.append(f"{differing} values differ, by up to {figures['largest_difference']}")
    if between:
        places = wp.array([row[:3] for row in between], dtype=wp.vec3, device="cpu")
        out = wp.zeros(len(between), dtype=wp.float32, device="cpu")
        wp.launch(sample_float, len(between), inputs=[volume.id, places], outputs=[out], device="cpu")
        figures["sampled_within"] = largest_difference(out.numpy(), np.array([row[3] for row in between]))
        if not figures["sampled_within"] <= 1e-5 * reach:
            complaints.append(f"samples between voxels differ by up to {figures['sampled_within']}")
    return complaints, figures


def largest_difference(found, expected):
    return float(np.abs(found.astype(np.float64) - expected.astype(np.float64)).max())


def read_expected(path):
    """Rows (i, j, k, value, whether at a voxel) for each grid's name."""
    rows = defaultdict(list)
    if path:
        with open(path, encoding="utf-8") as file:
            for line in file:
                name, i, j, k, value = line.split()
                rows[name].append((float(i), float(j), float(k), float(value), "." not in i))
    return rows


def check(name, volume, expected, points, rng):
    """Complaints about one grid, and figures."""
    info = volume.get_grid_info()
    report = {"name": name, "type": info.type_str, "bytes": info.size_in_bytes, "voxel_m": volume.get_voxel_size()[0]}
    if volume.dtype not in (wp.float32, wp.int32):
        return [f"value type {info.type_str}; float and int32 are checked"], report
    stored = volume.get_voxels().numpy()
    report["stored_voxels"] = len(stored)
    complaints = []
    values = lookup(volume, stored) if len(stored) else np.zeros(0)
    if not np.all(np.isfinite(values)):
        complaints.append("a value is not finite")
    far = np.array([[2**20, 2**20, 2**20]], dtype=np.int32)
    background = lookup(volume, far)[0]
    report["background"] = float(background)
    if len(values):
        report["range"] = [float(values.min()), float(values.max())]
        if values.min() < 0 < background:
            more, figures = check_level_set(volume, stored, values, background, points, rng)
            complaints += more
            report |= figures
    if expected:
        more, figures = check_expected(volume, expected, float(np.abs(values).max()) if len(values) else 0.0)
        complaints += more
        report |= figures
    return complaints, report


def main():
    """Checks all grids of the file on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--expect", metavar="FILE")
    options = parser.parse_args()
    expected = read_expected(options.expect)
    reports = []
    # Warp greets on standard output, which is for the JSON lines alone.
    with contextlib.redirect_stdout(sys.stderr):
        wp.init()
        for name, volume in grids(options.file):
            rng = np.random.default_rng(options.seed)
            complaints, report = check(name, volume, expected.get(name), options.points, rng)
            reports.append(report | {"ok": not complaints, "complaints": complaints})
    for name in sorted(set(expected) - {report["name"] for report in reports}):
        reports.append({"name": name, "ok": False, "complaints": ["expected, but not in the file"]})
    for report in reports:
        print(json.dumps(report))
    return 0 if all(report["ok"] for report in reports) else 1


if __name__ == "__main__":
    sys.exit(main())
