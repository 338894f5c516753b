"""Makes data/bracket.obj: a bracket of base plate, upright plate, gusset, tube and flange, as one closed solid.

    python -m venv .venv && .venv/bin/pip install -r scripts/requirements.txt
    .venv/bin/python data/make_bracket.py data/bracket.obj

Units are millimetres, z is up. The same versions of manifold3d and numpy give the same bytes.
"""

import sys

import numpy as np
from manifold3d import CrossSection, Manifold

SEGMENTS = 96
"""Sides of the round features."""
LONGEST_EDGE = 30.0
"""Longest edge of a triangle [mm]: even triangles suit curves traced over them."""


def box(low, high):
    low, high = np.array(low, float), np.array(high, float)
    return Manifold.cube(high - low).translate(low)


def drum(radius, bottom, top, centre=(0.0, 0.0)):
    return Manifold.cylinder(top - bottom, radius, radius, SEGMENTS).translate((*centre, bottom))


def bracket():
    """Base plate with four holes; upright plate with a gusset; tube with flange on the base."""
    plate = box((-80, -45, 0), (80, 45, 10))
    for x in (-68, 68):
        for y in (-34, 34):
            plate -= drum(4.5, -1, 11, (x, y))
    upright = box((-80, 12, 10), (-70, 45, 60))
    gusset = CrossSection([[(0, 0), (32, 0), (0, 32)]]).extrude(8).rotate((90, 0, 0)).translate((-70, 33, 10))
    tube = drum(19, 9, 52, (44, 16))
    flange = drum(28, 46, 52, (44, 16))
    bore = drum(15, 4, 53, (44, 16))
    solid = plate + upright + gusset + tube + flange - bore
    for turn in range(6):
        angle = np.pi / 3 * turn
        solid -= drum(2.2, 45, 53, (44 + 23.5 * np.cos(angle), 16 + 23.5 * np.sin(angle)))
    return solid.refine_to_length(LONGEST_EDGE)


def write_obj(solid, path):
    mesh = solid.to_mesh()
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write("# RoboFin bracket, millimetres, z up; made by data/make_bracket.py\n")
        for x, y, z in mesh.vert_properties[:, :3].astype(float):
            file.write(f"v {x:.4f} {y:.4f} {z:.4f}\n")
        for a, b, c in mesh.tri_verts + 1:
            file.write(f"f {a} {b} {c}\n")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: make_bracket.py OUT.obj")
    solid = bracket()
    print(f"{solid.num_tri()} triangles, volume {solid.volume():.1f} mm3, genus {solid.genus()}, {solid.status()}")
    write_obj(solid, sys.argv[1])


if __name__ == "__main__":
    main()
