"""Lets Gwyddion, surfalize, SurfaceTopography and GDAL read what our tests wrote, and compares heights.

First `cargo run -p robofin-instruments --example samples FOLDER`, then this with the folder.
"""

import sys
from pathlib import Path

import gwyddion
import gwyfile
import numpy as np
import rasterio
import SurfaceTopography
from shape import NX, NY, PITCH_X, PITCH_Y, heights
from surfalize import Surface

FOLDER = Path(sys.argv[1])


def by_gwyddion(file):
    data = gwyddion.load(file)
    copy = file.with_suffix(file.suffix + ".gwy")
    gwyddion.save(data, copy, "gwyfile")
    channels = gwyfile.load(str(copy))
    first = min(int(key.split("/")[1]) for key in channels if key.endswith("/data"))
    field = channels[f"/{first}/data"]
    values = np.array(field["data"]).reshape(field["yres"], field["xres"])
    if f"/{first}/mask" in channels:
        values = np.where(np.array(channels[f"/{first}/mask"]["data"]).reshape(values.shape) > 0, np.nan, values)
    return values, field["xreal"] / field["xres"], field["yreal"] / field["yres"]


def by_surfalize(file):
    surface = Surface.load(file)
    return surface.data * 1e-6, surface.step_x * 1e-6, surface.step_y * 1e-6


def by_topography(file):
    topography = SurfaceTopography.read_topography(str(file)).to_unit("m")
    size = topography.pixel_size
    return np.ma.filled(topography.heights(), np.nan).T, size[0], size[1]


def by_gdal(file):
    with rasterio.open(file) as grid:
        values = np.where(grid.read(1) == grid.nodata, np.nan, grid.read(1)) * 1e-3
        return values, grid.res[0] * 1e-3, grid.res[1] * 1e-3


def compare(file, program, read):
    try:
        values, x, y = read(file)
    except Exception as error:
        print(f"{file.name:12} {program:18} not read: {type(error).__name__} {str(error)[:90]}")
        return
    truth = heights()
    for name, expected in [("first row highest y", truth[::-1]), ("first row lowest y", truth)]:
        both = np.isfinite(values) & np.isfinite(expected)
        worst = np.abs(values - expected)[both].max()
        if worst < 1e-7:
            missing = np.isnan(values).sum()
            print(f"{file.name:12} {program:18} {name}: differs by {worst:.1e} m, {missing} of "
                  f"{np.isnan(truth).sum()} missing, pitch {x * 1e6:.6f} x {y * 1e6:.6f} um")
            return
    print(f"{file.name:12} {program:18} DIFFERENT")


assert heights().shape == (NY, NX) and PITCH_X > PITCH_Y
for name in ["map.sur", "map.x3p", "map.asc", "map.plux", "map.vk4", "map.vk6", "map.zon", "packed.zon"]:
    for program, read in [("Gwyddion 2.62", by_gwyddion), ("surfalize", by_surfalize),
                          ("SurfaceTopography", by_topography), ("GDAL", by_gdal)]:
        if program != "GDAL" or name == "map.asc":
            compare(FOLDER / name, program, read)
