"""Makes data/bracket.obj: a bracket of plates, a tube and a flange, in millimetres.

    pip install numpy==2.4.6 manifold3d==3.5.4
    python data/make_bracket.py

Base plate 160 x 110 x 10 with two holes, an upright plate with two holes along its back edge, a gusset between them, and
a tube with a flange ring. In front of the upright, 98 x 90 mm of the base plate are flat, for weld beads.
The origin is at the middle of the base plate's underside, z up, the long side along x. Lines are sorted, so that the same
geometry always gives the same bytes.
"""

from pathlib import Path

import numpy as np
from manifold3d import CrossSection, Manifold

BASE = (160.0, 110.0, 10.0)
UPRIGHT_THICKNESS, UPRIGHT_HEIGHT = 8.0, 60.0
GUSSET_X, GUSSET_THICKNESS, GUSSET_LEG = -70.0, 6.0, 36.0
TUBE_X, TUBE_Y = 53.0, 0.0
TUBE_OUTER, TUBE_INNER, TUBE_HEIGHT = 17.0, 13.0, 40.0
FLANGE_RADIUS, FLANGE_THICKNESS = 26.0, 6.0
BOLT_CIRCLE, BOLT_RADIUS = 21.5, 2.25
BASE_HOLES, BASE_HOLE_RADIUS = [(-68.0, -43.0), (68.0, -43.0)], 4.5
UPRIGHT_HOLES, UPRIGHT_HOLE_RADIUS = [(-30.0, 45.0), (30.0, 45.0)], 6.0
TUBE_SEGMENTS, HOLE_SEGMENTS = 96, 48
EDGE_LENGTH = 18.0


def cylinder(radius, low, high, x=0.0, y=0.0, segments=TUBE_SEGMENTS):
    return Manifold.cylinder(high - low, radius, radius, segments).translate((x, y, low))


def box(size, low):
    return Manifold.cube(size).translate(low)


def bracket():
    length, width, top = BASE
    back = width / 2 - UPRIGHT_THICKNESS
    base = box(BASE, (-length / 2, -width / 2, 0.0))
    upright = box((length, UPRIGHT_THICKNESS, UPRIGHT_HEIGHT), (-length / 2, back, top))
    # The gusset is drawn in (y, z) and stood up along x.
    outline = CrossSection([[(back, top), (back, top + GUSSET_LEG), (back - GUSSET_LEG, top)]])
    gusset = outline.extrude(GUSSET_THICKNESS).rotate((90.0, 0.0, 90.0)).translate((GUSSET_X, 0.0, 0.0))
    tube = cylinder(TUBE_OUTER, top, top + TUBE_HEIGHT, TUBE_X, TUBE_Y)
    low, high = top + TUBE_HEIGHT, top + TUBE_HEIGHT + FLANGE_THICKNESS
    flange = cylinder(FLANGE_RADIUS, low, high, TUBE_X, TUBE_Y)
    part = base + upright + gusset + tube + flange
    part -= cylinder(TUBE_INNER, -1.0, high + 1.0, TUBE_X, TUBE_Y)
    for x, y in BASE_HOLES:
        part -= cylinder(BASE_HOLE_RADIUS, -1.0, top + 1.0, x, y, HOLE_SEGMENTS)
    for x, z in UPRIGHT_HOLES:
        bore = cylinder(UPRIGHT_HOLE_RADIUS, -1.0, UPRIGHT_THICKNESS + 1.0, segments=HOLE_SEGMENTS)
        part -= bore.rotate((-90.0, 0.0, 0.0)).translate((x, back, z))
    for angle in np.deg2rad([45.0, 135.0, 225.0, 315.0]):
        x, y = TUBE_X + BOLT_CIRCLE * np.cos(angle), TUBE_Y + BOLT_CIRCLE * np.sin(angle)
        part -= cylinder(BOLT_RADIUS, low - 1.0, high + 1.0, x, y, HOLE_SEGMENTS)
    # Shorter edges, so that few triangles are long needles across a plate.
    return part.refine_to_length(EDGE_LENGTH)


def obj_lines(part):
    """Vertices sorted by coordinates, faces turned to start at their smallest index and sorted."""
    mesh = part.to_mesh64() if hasattr(part, "to_mesh64") else part.to_mesh()
    positions = np.round(np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3], 4) + 0.0
    unique, index = np.unique(positions, axis=0, return_inverse=True)
    faces = index.reshape(-1)[np.asarray(mesh.tri_verts)]
    start = np.argmin(faces, axis=1)
    faces = np.stack([faces[np.arange(len(faces)), (start + k) % 3] for k in range(3)], axis=1)
    faces = faces[np.lexsort(faces.T[::-1])] + 1
    return [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in unique] + [f"f {a} {b} {c}" for a, b, c in faces]


def main():
    part = bracket()
    assert len(part.decompose()) == 1, "the bracket is one body"
    path = Path(__file__).with_name("bracket.obj")
    path.write_text("\n".join(obj_lines(part)) + "\n", encoding="ascii")
    print(f"{path.name}: {part.num_tri()} triangles, {part.volume():.1f} mm3, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
