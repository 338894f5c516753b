"""Checks USD files as other programs will read them.

    python check_usd.py FILE...

Prints one line of JSON: {"files": [{"path", "prims", "bbox": [[x, y, z], [x, y, z]] in metres or null, "errors"}]}.
Runs every validator of UsdValidation, then what none of them looks at: mesh topology, lengths of primvars, extents,
finite numbers, unit normals.
"""

import json
import sys

import numpy
from pxr import Tf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation

STANDARD_SURFACE = "ND_standard_surface_surfaceshader"


def report(path, prims=0, bbox=None, errors=()):
    return {"path": path, "prims": prims, "bbox": bbox, "errors": list(errors)}


def check(path):
    """The report on one file, whatever it holds."""
    try:
        return inspect(path, Usd.Stage.Open(path))
    except Tf.ErrorException as error:
        return report(path, errors=[f"cannot be opened: {str(error).strip().splitlines()[-1]}"])
    except Exception as error:  # an oddity of one file must not hide the reports on the others
        return report(path, errors=[f"cannot be checked: {type(error).__name__}: {error}"])


def inspect(path, stage):
    prims = list(stage.Traverse())
    errors = metadata_errors(stage) + validator_errors(stage)
    for prim in prims:
        texts = shape_errors(prim) + primvar_errors(prim) + material_errors(prim)
        found = [f"{prim.GetPath()}: {text}" for text in texts]
        errors += found
    if not any(prim.IsA(UsdGeom.Mesh) for prim in prims):
        errors.append("no mesh")
    return report(path, len(prims), bounding_box(stage), errors)


def metadata_errors(stage):
    expected = [
        ("upAxis", UsdGeom.GetStageUpAxis(stage), UsdGeom.Tokens.z),
        ("metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage), 1.0),
        ("kilogramsPerUnit", UsdPhysics.GetStageKilogramsPerUnit(stage), 1.0),
        ("a default prim", stage.HasDefaultPrim(), True),
    ]
    return [f"{name} is {found}, expected {wanted}" for name, found, wanted in expected if found != wanted]


def validator_errors(stage):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(stage)
    serious = [UsdValidation.ValidationErrorType.Error, UsdValidation.ValidationErrorType.Warn]
    texts = sorted(error.GetErrorAsString() for error in found if error.GetType() in serious)
    # usd-core comes without the node definitions of MaterialX; `material_errors` checks the node's name.
    return [text for text in texts if f"shaderId '{STANDARD_SURFACE}'" not in text]


def material_errors(prim):
    """What a renderer of previews or of MaterialX lacks in a material."""
    if not prim.IsA(UsdShade.Material):
        return []
    material = UsdShade.Material(prim)
    wanted = {"": "UsdPreviewSurface", "mtlx": STANDARD_SURFACE}
    pairs = [(material.ComputeSurfaceSource(context)[0], kind) for context, kind in wanted.items()]
    found = [(shader.GetIdAttr().Get() if shader else None, kind) for shader, kind in pairs]
    return [f"its surface is {name}, expected {kind}" for name, kind in found if name != kind]


def shape_errors(prim):
    """What is wrong with the points of a mesh or of curves."""
    if not prim.IsA(UsdGeom.PointBased):
        return []
    shape = UsdGeom.PointBased(prim)
    points = numpy.asarray(shape.GetPointsAttr().Get() or [], dtype=numpy.float64).reshape(-1, 3)
    if len(points) == 0:
        return ["no points"]
    errors = [] if numpy.isfinite(points).all() else ["a point is not finite"]
    extent = shape.GetExtentAttr().Get()
    if extent is None:
        errors.append("no extent")
    elif prim.IsA(UsdGeom.Mesh) and not numpy.array_equal(numpy.asarray(extent), [points.min(0), points.max(0)]):
        errors.append("the extent is not that of the points")
    normals = shape.GetNormalsAttr().Get()
    if normals is not None:
        lengths = numpy.linalg.norm(numpy.asarray(normals, dtype=numpy.float64), axis=1)
        if not (abs(lengths - 1.0) < 1e-4).all():
            errors.append("a normal is not of unit length")
    if prim.IsA(UsdGeom.Mesh):
        errors += topology_errors(UsdGeom.Mesh(prim), len(points))
    return errors


def topology_errors(mesh, points):
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    if not counts or not indices:
        return ["no faces"]
    valid, reason = UsdGeom.Mesh.ValidateTopology(indices, counts, points)
    return [] if valid else [f"topology: {reason}"]


def primvar_errors(prim):
    """Values whose number does not follow from their interpolation."""
    if not prim.IsA(UsdGeom.Mesh) and not prim.IsA(UsdGeom.BasisCurves):
        return []
    sizes = mesh_sizes(UsdGeom.Mesh(prim)) if prim.IsA(UsdGeom.Mesh) else curve_sizes(UsdGeom.BasisCurves(prim))
    values = [(p.GetPrimvarName(), p.GetInterpolation(), p.GetElementSize(), p.ComputeFlattened())
              for p in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues() if p.GetTypeName().isArray]
    shape = UsdGeom.PointBased(prim)
    values.append(("normals", shape.GetNormalsInterpolation(), 1, shape.GetNormalsAttr().Get()))
    return [f"{name} has {len(value)} values, {interpolation} needs {size * sizes[interpolation]}"
            for name, interpolation, size, value in values
            if value is not None and len(value) != size * sizes[interpolation]]


def mesh_sizes(mesh):
    points, corners = len(mesh.GetPointsAttr().Get() or []), len(mesh.GetFaceVertexIndicesAttr().Get() or [])
    faces = len(mesh.GetFaceVertexCountsAttr().Get() or [])
    return {"constant": 1, "uniform": faces, "varying": points, "vertex": points, "faceVarying": corners}


def curve_sizes(curves):
    points, lines = len(curves.GetPointsAttr().Get() or []), len(curves.GetCurveVertexCountsAttr().Get() or [])
    return {"constant": 1, "uniform": lines, "varying": points, "vertex": points, "faceVarying": points}


def bounding_box(stage):
    """World box of everything drawn by default, in metres, or None if there is nothing."""
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_])
    box = boxes.ComputeWorldBound(stage.GetPseudoRoot()).ComputeAlignedRange()
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    corners = [[scale * x for x in corner] for corner in (box.GetMin(), box.GetMax())]
    return None if box.IsEmpty() or not numpy.isfinite(corners).all() else corners


if __name__ == "__main__":
    print(json.dumps({"files": [check(path) for path in sys.argv[1:]]}))
