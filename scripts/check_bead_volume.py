"""Volume that weld beads add to a part, by manifold3d's boolean: an opinion from outside.

    python check_bead_volume.py PART.obj BEAD.obj...      closed triangle meshes in metres (`v` and `f` lines)
    python check_bead_volume.py welded.glb                its mesh "base" is the part, the others are the beads

Prints one line of JSON: {"status", "added_mm3", "part_mm3", "beads_mm3"}. With a status other than "ok" (open or
not manifold input, a boolean that contradicts itself) every number is null.
"""

import json
import pathlib
import sys

import manifold3d
import numpy

import glb

MM_PER_M = 1000.0


class Unusable(Exception):
    """The input has no well-defined volume; the text is the status."""


def main(paths):
    try:
        part, beads = load(paths)
        answer = {"status": "ok"} | added_volume(part, beads)
    except Unusable as reason:
        answer = {"status": str(reason), "added_mm3": None, "part_mm3": None, "beads_mm3": None}
    print(json.dumps(answer))


def load(paths):
    if len(paths) == 1:
        parts = {part.name: part.merged() for part in glb.read(paths[0])}
        if "base" not in parts or len(parts) < 2:
            raise Unusable(f"empty: {paths[0]} has no mesh \"base\" with a bead beside it")
        return solid("base", *parts.pop("base")), [solid(name, *mesh) for name, mesh in parts.items()]
    part, *beads = [solid(pathlib.Path(path).stem, *read_obj(path)) for path in paths]
    return part, beads


def added_volume(part, beads):
    """Union minus part, confirmed by bead minus part: they differ when a mesh overlaps itself."""
    bead = manifold3d.Manifold.batch_boolean(beads, manifold3d.OpType.Add)
    added = (part + bead).volume() - part.volume()
    outside = (bead - part).volume()
    if not abs(added - outside) <= 1e-9 * part.volume() + 1e-3 * bead.volume():
        raise Unusable(f"ambiguous: the union adds {added:.6g} mm3 but {outside:.6g} mm3 of bead lie outside the "
                       "part; a mesh overlaps itself")
    return {"added_mm3": outside, "part_mm3": part.volume(), "beads_mm3": bead.volume()}


def solid(name, positions, triangles):
    """A manifold in mm, or the reason why the mesh is none."""
    if len(triangles) == 0:
        raise Unusable(f"empty: {name} has no triangles")
    if not numpy.isfinite(positions).all():
        raise Unusable(f"not finite: {name} has a vertex that is not a number")
    open_edges, crowded_edges = edge_faults(triangles)
    if open_edges:
        raise Unusable(f"open: {name} has {open_edges} boundary or inconsistently oriented edges")
    if crowded_edges:
        raise Unusable(f"not manifold: {name} has {crowded_edges} edges with more than two triangles")
    mesh = manifold3d.Mesh64(
        numpy.ascontiguousarray(positions, dtype=numpy.float64) * MM_PER_M,
        numpy.ascontiguousarray(triangles, dtype=numpy.uint64),
    )
    result = manifold3d.Manifold(mesh)
    if result.status() != manifold3d.Error.NoError or result.is_empty():
        raise Unusable(f"not manifold: {name}: manifold3d says {result.status().name}")
    if not result.volume() > 0.0:
        raise Unusable(f"inside out: {name} has a volume of {result.volume():.6g} mm3")
    return result


def edge_faults(triangles):
    """Numbers of directed edges without their opposite, and of edges used more than once in one direction."""
    vertices = int(triangles.max()) + 1
    start = triangles.reshape(-1).astype(numpy.int64)
    end = numpy.roll(triangles, -1, axis=1).reshape(-1).astype(numpy.int64)
    edges, uses = numpy.unique(start * vertices + end, return_counts=True)
    opposite = (edges % vertices) * vertices + edges // vertices
    return int((~numpy.isin(opposite, edges)).sum()), int((uses > 1).sum())


def read_obj(path):
    """Positions and triangles of the `v` and `f a b c` lines that our own writer makes."""
    positions, triangles = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            kind, *fields = line.split() or [""]
            if kind == "v":
                positions.append([float(x) for x in fields[:3]])
            elif kind == "f":
                if len(fields) != 3:
                    raise Unusable(f"not triangles: {path} has a face of {len(fields)} corners")
                triangles.append([int(field.split("/")[0]) - 1 for field in fields])
    return numpy.array(positions).reshape(-1, 3), numpy.array(triangles, dtype=numpy.int64).reshape(-1, 3)


if __name__ == "__main__":
    main(sys.argv[1:])
