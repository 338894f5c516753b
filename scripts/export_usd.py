"""Writes welded.usdc from welded.glb and welds.json in asset folders, and checks what it wrote.

    python export_usd.py JOB.json        JOB: {"generator": "RoboFin 0.1.0", "origin": {...}, "assets": ["DIR", ...]}

Prints one line of JSON: {"files": [{"path", "prims", "bbox", "errors"}, ...]} in the job's order. An asset that fails
has its reason in `errors` and does not stop the others. Same input, same bytes. `origin` maps names to texts for the
layer's custom data. Mass and inertia come from mass.json, if the folder has it. Layout: docs/usd.md.
"""

import json
import os
import sys

import numpy
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, UsdVol, Vt

import check_usd
import glb

STEEL_DENSITY = 7850.0  # kg/m^3
VDB_FILE = "fields.vdb"
# Dry steel on steel, Coulomb friction; restitution of a slow impact.
STATIC_FRICTION, DYNAMIC_FRICTION, RESTITUTION = 0.6, 0.4, 0.3


def export(folder, custom_data):
    """Writes one asset's stage and returns the report on it."""
    path = os.path.join(folder, "welded.usdc")
    unfinished = os.path.join(folder, "welded.unfinished.usdc")
    try:
        parts = glb.read(os.path.join(folder, "welded.glb"))
        with open(os.path.join(folder, "welds.json"), encoding="utf-8") as file:
            welds = json.load(file)["welds"]
        stage = build(parts, welds, read_mass(folder))
        if os.path.exists(os.path.join(folder, VDB_FILE)):
            define_volume(stage)
        stage.GetRootLayer().customLayerData = custom_data
        stage.GetRootLayer().Export(unfinished)
    except Exception as error:  # whatever is wrong with one asset, the others are still written
        return check_usd.report(path, errors=[f"{type(error).__name__}: {error}"])
    os.replace(unfinished, path)
    return check_usd.check(path)


def read_mass(folder):
    """The mass properties of an asset, or None."""
    path = os.path.join(folder, "mass.json")
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def build(parts, welds, mass):
    """The stage of one welded workpiece: m, kg, z up."""
    stage = Usd.Stage.CreateInMemory("welded.usdc")
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/workpiece").GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    UsdPhysics.RigidBodyAPI.Apply(root)
    define_mass(root, mass)
    label(root, "workpiece")
    materials = define_materials(stage, parts)
    for part in parts:
        define_part(stage, part, materials[part.material["name"]])
    for weld in welds:
        define_centreline(stage, weld)
    return stage


def define_mass(prim, mass):
    """Density and, if known, mass, centre, principal moments and axes; a simulator then computes none of them."""
    api = UsdPhysics.MassAPI.Apply(prim)
    api.CreateDensityAttr(mass["density"] if mass else STEEL_DENSITY)
    if mass:
        x, y, z, w = mass["principal_axes"]
        api.CreateMassAttr(mass["mass"])
        api.CreateCenterOfMassAttr(Gf.Vec3f(mass["centre"]))
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(mass["principal_moments"]))
        api.CreatePrincipalAxesAttr(Gf.Quatf(w, x, y, z))


def define_materials(stage, parts):
    """One material for each glTF material in use, by name: for previews, for MaterialX, and of steel for physics."""
    UsdGeom.Scope.Define(stage, "/workpiece/materials")
    materials = {}
    for source in {part.material["name"]: part.material for part in parts}.values():
        material = UsdShade.Material.Define(stage, f"/workpiece/materials/{source['name']}")
        look = source["pbrMetallicRoughness"]
        values = (Gf.Vec3f(look["baseColorFactor"][:3]), look["metallicFactor"], look["roughnessFactor"])
        define_preview(stage, material, values)
        define_materialx(stage, material, values)
        physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        physics.CreateStaticFrictionAttr(STATIC_FRICTION)
        physics.CreateDynamicFrictionAttr(DYNAMIC_FRICTION)
        physics.CreateRestitutionAttr(RESTITUTION)
        materials[source["name"]] = material
    return materials


def define_preview(stage, material, values):
    """Colour, metalness and roughness as a UsdPreviewSurface."""
    shader = define_shader(stage, f"{material.GetPath()}/surface", "UsdPreviewSurface")
    set_inputs(shader, ("diffuseColor", "metallic", "roughness"), values)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")


def define_materialx(stage, material, values):
    """The same as a Standard Surface of MaterialX."""
    shader = define_shader(stage, f"{material.GetPath()}/standard_surface", check_usd.STANDARD_SURFACE)
    shader.CreateInput("base", Sdf.ValueTypeNames.Float).Set(1.0)
    set_inputs(shader, ("base_color", "metalness", "specular_roughness"), values)
    output = shader.CreateOutput("out", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(output)


def define_shader(stage, path, kind):
    """A shader node of a registered kind."""
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(kind)
    return shader


def set_inputs(shader, names, values):
    """Sets a colour and two numbers."""
    kinds = (Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Float)
    for name, kind, value in zip(names, kinds, values):
        shader.CreateInput(name, kind).Set(value)


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
    UsdSemantics.LabelsAPI.Apply(prim, "instance").CreateLabelsAttr([part.name])


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


def define_volume(stage):
    """The fields as a guide, like the centrelines: the meshes are what is rendered."""
    volume = UsdVol.Volume.Define(stage, "/workpiece/fields")
    volume.CreatePurposeAttr(UsdGeom.Tokens.guide)
    boxes = [UsdGeom.Mesh(prim).GetExtentAttr().Get() for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    volume.CreateExtentAttr(
        Vt.Vec3fArray.FromNumpy(numpy.stack([numpy.min(boxes, axis=(0, 1)), numpy.max(boxes, axis=(0, 1))]))
    )
    for name, kind in [("phi", "levelSet"), ("target", "levelSet"), ("weld_share", "fogVolume")]:
        field = UsdVol.OpenVDBAsset.Define(stage, f"/workpiece/fields/{name}")
        field.CreateFilePathAttr(Sdf.AssetPath(f"./{VDB_FILE}"))
        field.CreateFieldNameAttr(name)
        field.CreateFieldClassAttr(kind)
        field.CreateFieldDataTypeAttr("float")
        volume.CreateFieldRelationship(name, field.GetPath())
    label(volume.GetPrim(), "fields")


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
    custom_data = {"generator": job["generator"], **job["origin"]}
    print(json.dumps({"files": [export(folder, custom_data) for folder in job["assets"]]}))


if __name__ == "__main__":
    main()
