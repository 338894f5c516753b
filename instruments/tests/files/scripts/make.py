"""Makes the sample files beside this folder with programs of others. See the README there."""

import json
from pathlib import Path

import gwyfile.objects as gwy
import gwyddion
import numpy as np
import plyfile
import pye57
import pypcd4
import rasterio
import rasterio.shutil
import tifffile
from shape import NX, NY, PITCH_X, PITCH_Y, heights
from surfalize import Surface

FOLDER = Path(__file__).parent.parent
Z = heights()
FULL = heights(holes=False)


def at(name):
    return str(FOLDER / name)


def make_gwyddion():
    """A file of the package gwyfile, and what Gwyddion makes of it; images begin with the highest y."""

    def field(values, unit):
        values = np.ascontiguousarray(values[::-1], dtype=float)
        return gwy.GwyDataField(
            values, xreal=NX * PITCH_X, yreal=NY * PITCH_Y, si_unit_xy="m", si_unit_z=unit
        )

    channels = gwy.GwyContainer()
    channels["/0/data"] = field(np.cos(FULL * 1e6), "V")
    channels["/0/data/title"] = "Phase"
    channels["/3/data"] = field(FULL, "m")
    channels["/3/data/title"] = "Height"
    channels["/3/mask"] = field(np.isnan(Z), "")
    channels.tofile(at("gwyfile.gwy"))
    del channels["/0/data"], channels["/0/data/title"]
    channels["/0/data"] = channels.pop("/3/data")
    channels["/0/mask"] = channels.pop("/3/mask")
    channels["/0/data/title"] = channels.pop("/3/data/title")
    channels.tofile(at("heights.tmp.gwy"))
    gwyddion.setting("/module/asciiexport/add-comment", True)
    data = gwyddion.load(at("heights.tmp.gwy"))
    for name, function in [
        ("gwyddion.gwy", "gwyfile"),
        ("gwyddion.sur", "surffile"),
        ("gwyddion.sdf", "sdfile-txt"),
        ("gwyddion.txt", "asciiexport"),
        ("gwyddion.xyz", "xyzexport"),
    ]:
        gwyddion.save(data, at(name), function)
    Path(at("heights.tmp.gwy")).unlink()


def make_surfalize():
    """Files of surfalize, which takes the first row of an array to be the top of the picture."""
    surface = Surface(Z[::-1] * 1e6, PITCH_X * 1e6, PITCH_Y * 1e6)
    surface.save(at("surfalize.sur"))
    surface.save(at("surfalize_packed.sur"), compressed=True)
    surface.save(at("surfalize.x3p"))
    surface.save(at("surfalize_binary.sdf"))
    surface.save(at("surfalize_text.sdf"), binary=False)


def points():
    """x, y, z [mm] of all pixels, row by row."""
    x, y = np.meshgrid(np.arange(NX) * PITCH_X, np.arange(NY) * PITCH_Y)
    return np.column_stack([x.ravel(), y.ravel(), Z.ravel()]) * 1e3


def make_lists():
    """Lists of points of NumPy, with several separators, units and words for a missing height."""
    every = points()
    seen = every[np.isfinite(every[:, 2])]
    number = "%.17g"
    np.savetxt(at("points_comma.csv"), seen, fmt=number, delimiter=",")
    np.savetxt(at("points_blank.xyz"), every, fmt=number, delimiter=" ")
    np.savetxt(at("points_header.txt"), seen * 1e3, fmt=number, delimiter="\t", header="X [um]\tY [um]\tZ [um]")
    np.savetxt(at("points_mixed.csv"), seen * [1, 1, 1e6], fmt=number, delimiter=",", comments="",
               header="x (mm),y (mm),height (nm)")
    with open(at("points_decimal_comma.txt"), "w", encoding="utf-8") as file:
        for x, y, z in every:
            text = "***" if np.isnan(z) else f"{z:.17g}"
            file.write(f"{x:.17g};{y:.17g};{text}\n".replace(".", ","))
    rng = np.random.default_rng(1)
    np.savetxt(at("points_shuffled.csv"), rng.permutation(seen), fmt=number, delimiter=",")


def make_arrays():
    np.save(at("c_order.npy"), Z * 1e3)
    np.save(at("fortran_big_endian.npy"), np.asfortranarray(Z * 1e3, dtype=">f8"))
    np.savez_compressed(at("several.npz"), heights=Z * 1e3, mask=np.isnan(Z))
    np.save(at("points.npy"), points())


def make_images():
    """TIFF images, whose first row is the top."""
    statement = {"z_unit": "um", "xy_unit": "um", "pitch_x": PITCH_X * 1e6, "pitch_y": PITCH_Y * 1e6}
    tifffile.imwrite(at("float.tif"), (Z[::-1] * 1e6).astype(np.float32),
                     description=json.dumps(statement), metadata=None)
    steps = np.where(np.isnan(Z), 9999, np.round(FULL * 1e9 / 2) + 20000)[::-1].astype(np.uint16)
    tifffile.imwrite(
        at("imagej_16_bit.tif"), steps, resolution=(1 / (PITCH_X * 1e6), 1 / (PITCH_Y * 1e6)), resolutionunit=1,
        description="ImageJ=1.53k\nunit=\\u00B5m\ncf=0\nc0=-40000\nc1=2\nvunit=nm\n", compression="zlib", metadata=None,
    )


def make_clouds():
    every = points()
    seen = every[np.isfinite(every[:, 2])]
    with pye57.E57(at("pye57.e57"), mode="w") as file:
        columns = dict(zip(["cartesianX", "cartesianY", "cartesianZ"], (seen * 1e-3).T))
        file.write_scan_raw({name: np.ascontiguousarray(column) for name, column in columns.items()})
    fields, kinds = ("x", "y", "z"), (np.float64,) * 3
    for name, encoding in [("ascii", "ASCII"), ("binary", "BINARY"), ("packed", "BINARY_COMPRESSED")]:
        cloud = pypcd4.PointCloud.from_points(every, fields, kinds)
        cloud.save(at(f"pypcd4_{name}.pcd"), encoding=getattr(pypcd4.Encoding, encoding))
    table = np.array([tuple(row) + (7,) for row in seen], dtype=[(n, "f8") for n in fields] + [("quality", "u1")])
    vertices = plyfile.PlyElement.describe(table, "vertex")
    for name, text, order in [("text", True, "="), ("little", False, "<"), ("big", False, ">")]:
        plyfile.PlyData([vertices], text=text, byte_order=order).write(at(f"plyfile_{name}.ply"))


def make_grid():
    """An ASCII grid of GDAL, whose first row is the north, in millimetres."""
    values = np.where(np.isnan(Z), -9999.0, Z * 1e3)[::-1]
    corner = rasterio.transform.from_origin(1.0, 2.0 + NY * PITCH_X * 1e3, PITCH_X * 1e3, PITCH_X * 1e3)
    # GDAL copies into this format, so that the grid is made in memory first.
    with rasterio.MemoryFile() as memory:
        with memory.open(driver="GTiff", width=NX, height=NY, count=1, dtype="float64", transform=corner,
                         nodata=-9999.0) as grid:
            grid.write(values, 1)
        with memory.open() as grid:
            rasterio.shutil.copy(grid, at("gdal.asc"), driver="AAIGrid", SIGNIFICANT_DIGITS="17")
    for left in FOLDER.glob("gdal.*"):
        if left.suffix != ".asc":
            left.unlink()


if __name__ == "__main__":
    make_gwyddion()
    make_surfalize()
    make_lists()
    make_arrays()
    make_images()
    make_clouds()
    make_grid()
