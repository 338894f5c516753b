"""Writes welded.usdc from welded.glb and welds.json in asset folders, and checks what it wrote.

    python export_usd.py JOB.json        JOB: {"generator": "RoboFin 0.1.0", "assets": ["DIR", ...]}

Prints one line of JSON: {"files": [{"path", "prims", "bbox", "errors"}, ...]} in the job's order. An asset that fails
has its reason in `errors` and does not stop the others. Same input, same bytes. Layout: docs/usd.md.
"""

import json
import os
import sys

import numpy
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, Vt

import check_usd
import glb

STEEL_DENSITY = 7850.0  # kg/m^3


def export(folder, generator):
    """Writes one asset's stage and returns the report on it."""
    path = os.path.join(folder, "welded.usdc")
    unfinished = os.path.join(folder, "welded.unfinished.usdc")
    try:
        parts = glb.read(os.path.join(folder, "welded.glb"))
        with open(os.path.join(folder, "welds.json"), encoding="utf-8") as file:
            welds = json.load(file)["welds"]
        stage = build(parts, welds, generator)
        stage.GetRootLayer().Export(unfinished)
    except Exception as error:  # whatever is wrong with one asset, the others are still written
        return check_usd.report(path, errors=[f"{type(error).__name__}: {error}"])
    os.replace(unfinished, path)
    return check_usd.check(path)


def build(parts, welds, generator):
    """The stage of one welded workpiece: m, kg, z up."""
    stage = Usd.Stage.CreateInMemory("welded.usdc")
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/workpiece").GetPrim()
    stage.SetDefaultPrim(root)
    stage.GetRootLayer().customLayerData = {"generator": generator}
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    UsdPhysics.RigidBodyAPI.Apply(root)
    UsdPhysics.MassAPI.Apply(root).CreateDensityAttr(STEEL_DENSITY)
    label(root, "workpiece")
    materials = define_materials(stage, parts)
    for part in parts:
        define_part(stage, part, materials[part.material["name"]])
    for weld in welds:
        define_centreline(stage, weld)
    return stage


def define_materials(stage, parts):
    """One UsdPreviewSurface material for each glTF material in use, by name."""
    UsdGeom.Scope.Define(stage, "/workpiece/materials")
    materials = {}
    for source in {part.material["name"]: part.material for part in parts}.values():
        material = UsdShade.Material.Define(stage, f"/workpiece/materials/{source['name']}")
        shader = UsdShade.Shader.Define(stage, f"{material.GetPath()}/surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        look = source["pbrMetallicRoughness"]
        inputs = [
            ("diffuseColor", Sdf.ValueTypeNames.Color3f, Gf.Vec3f(look["baseColorFactor"][:3])),
            ("metallic", Sdf.ValueTypeNames.Float, look["metallicFactor"]),
            ("roughness", Sdf.ValueTypeNames.Float, look["roughnessFactor"]),
        ]
        for name, kind, value in inputs:
            shader.CreateInput(name, kind).Set(value)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        materials[source["name"]] = material
    return materials


def define_part(stage, part, material):
    """A closed mesh with shared points, normals per corner and the weld's number per face."""
    points, triangles = part.merged()
    mesh = UsdGeom.Mesh.Define(stage, f"/workpiece/{Tf.MakeValidIdentifier(part.name)}")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(triangles), 3))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.reshape(-1).astype(numpy.int32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(part.normals[part.triangles.reshape(-1)]))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    weld_id = primvars.CreatePrimvar("weldId", Sdf.ValueTypeNames.IntArray, UsdGeom.Tokens.uniform)
    weld_id.Set(Vt.IntArray.FromNumpy(part.weld_ids[part.triangles[:, 0]]))
    mesh.CreateDisplayColorAttr([Gf.Vec3f(part.material["pbrMetallicRoughness"]["baseColorFactor"][:3])])
    prim = mesh.GetPrim()
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    UsdPhysics.CollisionAPI.Apply(prim)
    collision = UsdPhysics.MeshCollisionAPI.Apply(prim)
    collision.CreateApproximationAttr(UsdPhysics.Tokens.convexDecomposition)
    label(prim, part.material["name"])


def define_centreline(stage, weld):
    """The weld's centreline as a guide: shown on request, never rendered, outside the default bounding box."""
    positions = numpy.asarray(weld["curve"]["position"], dtype=numpy.float32).reshape(-1, 3)
    if len(positions) < 2:
        raise ValueError(f"weld {weld['id']} has a curve of {len(positions)} points, at least 2 are needed")
    curves = UsdGeom.BasisCurves.Define(stage, f"/workpiece/weld_{int(weld['id'])}_centreline")
    curves.CreateTypeAttr(UsdGeom.Tokens.linear)
    curves.CreatePurposeAttr(UsdGeom.Tokens.guide)
    curves.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(positions))
    curves.CreateCurveVertexCountsAttr([len(positions)])
    curves.CreateWidthsAttr([weld["width_mm"] / 1000.0])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    primvars = UsdGeom.PrimvarsAPI(curves)
    weld_id = primvars.CreatePrimvar("weldId", Sdf.ValueTypeNames.Int, UsdGeom.Tokens.constant)
    weld_id.Set(int(weld["id"]))
    arc_length = primvars.CreatePrimvar("arcLength", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
    arc_length.Set([float(s) for s in weld["curve"]["arc_length"]])
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(curves, Usd.TimeCode.Default())
    curves.CreateExtentAttr(extent)
    label(curves.GetPrim(), "weld_centreline")


def label(prim, name):
    """The semantic class, by the official schema and by the attributes that Isaac Sim read before it."""
    UsdSemantics.LabelsAPI.Apply(prim, "class").CreateLabelsAttr([name])
    prim.AddAppliedSchema("SemanticsAPI:Semantics")
    for field, value in [("semanticType", "class"), ("semanticData", name)]:
        attribute = f"semantic:Semantics:params:{field}"
        prim.CreateAttribute(attribute, Sdf.ValueTypeNames.String, custom=False).Set(value)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        job = json.load(file)
    print(json.dumps({"files": [export(folder, job["generator"]) for folder in job["assets"]]}))


if __name__ == "__main__":
    main()
