"""Compares fields.vdb with the NanoVDB files of an asset folder, voxel by voxel, in Blender's own OpenVDB.

    python check_vdb.py FOLDER

Prints one line of JSON per grid: {"grid", "class", "voxels", "differ", "active", "inactive", "voxel_m"}. `voxels` are compared,
`differ` of them have another value. Then Blender imports the file as a volume object. Exit code 1 for any
difference. Needs bpy 4.5 (Python 3.11), warp-lang and numpy; warp reads the NanoVDB side.
"""

import json
import os
import sys

import bpy
import numpy
import warp

# The wheel of bpy keeps the module beside Blender's own Python.
sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python/lib/python3.11/site-packages"))
import openvdb

SIDE = 200


@warp.kernel
def look_up_float(volume: warp.uint64, at: warp.array(dtype=warp.vec3i), values: warp.array(dtype=float)):
    i = warp.tid()
    values[i] = warp.volume_lookup_f(volume, at[i][0], at[i][1], at[i][2])


@warp.kernel
def look_up_int(volume: warp.uint64, at: warp.array(dtype=warp.vec3i), values: warp.array(dtype=int)):
    i = warp.tid()
    values[i] = warp.volume_lookup_i(volume, at[i][0], at[i][1], at[i][2])


def nano_values(volume, at, kind):
    values = warp.zeros(len(at), dtype=kind, device="cpu")
    kernel = look_up_float if kind is float else look_up_int
    warp.launch(kernel, len(at), [volume.id, warp.array(at, dtype=warp.vec3i, device="cpu"), values], device="cpu")
    return values.numpy()


def compare(name, grid, volume):
    kind = int if "int32" in grid.valueTypeName else float
    low, high = [numpy.array(corner) for corner in grid.evalActiveVoxelBoundingBox()]
    rng = numpy.random.default_rng(1)
    at = rng.integers(low - 20, high + 21, size=(SIDE**2, 3)).astype(numpy.int32)
    accessor = grid.getConstAccessor()
    probed = [accessor.probeValue(tuple(int(x) for x in place)) for place in at]
    values = numpy.array([value for value, _ in probed], dtype=numpy.float32 if kind is float else numpy.int32)
    expected = nano_values(volume, at, kind)
    active = sum(state for _, state in probed)
    differ = int((values != expected).sum())
    print(json.dumps({"grid": name, "class": grid.gridClass, "voxels": len(at), "differ": differ, "active": active,
                      "inactive": len(at) - active, "voxel_m": grid.transform.voxelSize()[0]}))
    return differ


def main():
    folder = sys.argv[1]
    path = os.path.join(folder, "fields.vdb")
    volumes = {}
    for name in ("phi.nvdb", "weld.nvdb"):
        volume = warp.Volume.load_from_nvdb(open(os.path.join(folder, name), "rb"), device="cpu")
        while volume is not None:
            volumes[volume.get_grid_info().name] = volume
            volume = volume.load_next_grid()
    grids, _ = openvdb.readAll(path)
    differ = sum(compare(grid.name, grid, volumes[grid.name]) for grid in grids)
    bpy.ops.object.volume_import(filepath=path)
    volume = bpy.context.object.data
    volume.grids.load()
    names = sorted(grid.name for grid in volume.grids)
    print(json.dumps({"blender": names}))
    sys.exit(int(differ > 0 or names != sorted(volumes)))


if __name__ == "__main__":
    main()
