use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use export::usd;

use crate::outside::python;
use crate::solids::{asset, bead, plate};

const WHAT: &str = "USD files under usd-core";

/// Script that prints a simulator's view of a stage, one JSON value a line.
const READER: &str = r#"
import json, sys
from pxr import Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade
stage = Usd.Stage.Open(sys.argv[1])
root = stage.GetDefaultPrim()
show = lambda *values: print(json.dumps(values))
show(str(root.GetPath()), UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage))
mass = UsdPhysics.MassAPI(root)
show(root.HasAPI(UsdPhysics.RigidBodyAPI), mass.GetDensityAttr().Get(), mass.GetMassAttr().Get())
show(list(mass.GetCenterOfMassAttr().Get()), list(mass.GetDiagonalInertiaAttr().Get()), mass.GetPrincipalAxesAttr().Get().GetReal())
data = stage.GetRootLayer().customLayerData
show(data["source"], data["seed"])
for name in ["base", "weld_1"]:
    prim = root.GetChild(name)
    mesh, weld_id = UsdGeom.Mesh(prim), UsdGeom.PrimvarsAPI(prim).GetPrimvar("weldId")
    show(len(mesh.GetPointsAttr().Get()), len(mesh.GetFaceVertexCountsAttr().Get()), mesh.GetSubdivisionSchemeAttr().Get())
    show(weld_id.GetInterpolation(), weld_id.GetTypeName().cppTypeName, len(weld_id.Get()), sorted(set(weld_id.Get())))
    show(str(UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath()))
    show(prim.HasAPI(UsdPhysics.CollisionAPI), UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get())
    show(list(UsdSemantics.LabelsAPI(prim, "instance").GetLabelsAttr().Get()))
    show(list(UsdSemantics.LabelsAPI(prim, "class").GetLabelsAttr().Get()), prim.GetAttribute("semantic:Semantics:params:semanticData").Get())
steel = UsdPhysics.MaterialAPI(stage.GetPrimAtPath("/workpiece/materials/base"))
show([round(a.Get(), 6) for a in (steel.GetStaticFrictionAttr(), steel.GetDynamicFrictionAttr(), steel.GetRestitutionAttr())])
curve = UsdGeom.BasisCurves(root.GetChild("weld_1_centreline"))
show(curve.GetTypeAttr().Get(), list(curve.GetCurveVertexCountsAttr().Get()), [round(w, 6) for w in curve.GetWidthsAttr().Get()])
show([round(s, 6) for s in UsdGeom.PrimvarsAPI(curve).GetPrimvar("arcLength").Get()][-1], curve.GetPurposeAttr().Get())
"#;

const EXPECTED: &str = r#"["/workpiece", "Z", 1.0]
[true, 2000.0, 4.0]
[[0.0, 0.0, -0.5], [1.0, 2.0, 2.5], 0.5]
["bracket.obj", "18446744073709551615"]
[8, 12, "none"]
["uniform", "VtArray<int>", 12, [0]]
["/workpiece/materials/base"]
[true, "convexDecomposition"]
[["base"]]
[["base"], "base"]
[1106, 2208, "none"]
["uniform", "VtArray<int>", 2208, [1]]
["/workpiece/materials/weld"]
[true, "convexDecomposition"]
[["weld-1"]]
[["weld"], "weld"]
[[0.6, 0.4, 0.3]]
["linear", [21], [0.006]]
[0.04, "guide"]
"#;

fn origin() -> BTreeMap<&'static str, String> {
    BTreeMap::from([("source", "bracket.obj".to_owned()), ("seed", u64::MAX.to_string())])
}

#[test]
fn a_stage_carries_what_simulators_read() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = asset(folder.path(), "bracket");
    let mass = r#"{"density":2000,"mass":4,"centre":[0,0,-0.5],"principal_moments":[1,2,2.5],"principal_axes":[0.5,0.5,0.5,0.5]}"#;
    fs::write(asset.join("mass.json"), mass).expect("it can be written");
    usd::export(std::slice::from_ref(&asset), &origin(), &python).expect("the export runs");
    let mut command = Command::new(python.executable());
    let done = command.args(["-c", READER]).arg(asset.join("welded.usdc")).output().expect("Python runs");
    assert_eq!(String::from_utf8_lossy(&done.stdout), EXPECTED, "{}", String::from_utf8_lossy(&done.stderr));
}

fn write_text_stage(folder: &Path, name: &str, faces: &str, weld_ids: &str) -> PathBuf {
    let path = folder.join(name);
    let text = format!(
        r#"#usda 1.0
(
    defaultPrim = "workpiece"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "workpiece"
{{
    def Mesh "base"
    {{
        float3[] extent = [(0, 0, 0), (1, 1, 0)]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
        int[] faceVertexCounts = [3, 3]
        int[] faceVertexIndices = {faces}
        int[] primvars:weldId = {weld_ids} (interpolation = "uniform")
    }}
}}
"#
    );
    fs::write(&path, text).expect("the stage can be written");
    path
}

#[test]
fn a_welded_workpiece_is_clean_and_as_large_as_its_meshes() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = asset(folder.path(), "bracket");
    let reports = usd::export(std::slice::from_ref(&asset), &origin(), &python).expect("the export runs");
    assert_eq!(reports.len(), 1);
    assert_eq!(reports[0].errors, Vec::<String>::new());
    assert_eq!(reports[0].path, asset.join("welded.usdc"));
    // workpiece, materials, 2 materials with two shaders each, 2 meshes, 1 centreline.
    assert_eq!(reports[0].prims, 11);
    let mut whole = plate();
    whole.append(&bead());
    let (low, high) = whole.bounds().expect("it has vertices");
    let found = reports[0].bbox.expect("something is drawn").map(glam::DVec3::from);
    for (corner, expected) in found.into_iter().zip([low, high]) {
        // They differ only by the cast to single precision; JSON may lose the last bit of a double.
        assert!(corner.abs_diff_eq(expected.as_vec3().as_dvec3(), 1e-15), "{corner}, expected {expected}");
    }
    assert_eq!(usd::check(&[asset.join("welded.usdc")], &python).expect("the check runs"), reports);
    assert_eq!(fs::read_dir(&asset).expect("the asset").count(), 3, "nothing unfinished is left behind");
}

#[test]
fn the_same_asset_gives_the_same_usd_bytes_in_another_process() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let assets = ["one", "two", "three"].map(|name| asset(folder.path(), name));
    // One process writes two stages, another writes one and the first again.
    usd::export(&assets[..2], &origin(), &python).expect("the export runs");
    let stages = || assets.each_ref().map(|asset| fs::read(asset.join("welded.usdc")).unwrap_or_default());
    let before = stages();
    usd::export(&[assets[2].clone(), assets[0].clone()], &origin(), &python).expect("the export runs");
    let after = stages();
    assert!(!before[0].is_empty());
    assert!(before[0] == before[1] && before[0] == after[0] && before[0] == after[2], "bytes differ");
}

#[test]
fn an_asset_that_cannot_be_exported_says_why_and_does_not_stop_the_next() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let assets = ["unnamed", "cut", "sound"].map(|name| asset(folder.path(), name));
    fs::remove_file(assets[0].join("welds.json")).expect("it was there");
    fs::write(assets[1].join("welded.glb"), b"glTF").expect("it can be overwritten");
    let reports = usd::export(&assets, &origin(), &python).expect("the export runs");
    assert!(reports[0].errors[0].contains("welds.json"), "{:?}", reports[0].errors);
    assert_eq!(reports[1].errors.len(), 1);
    assert_eq!(reports[2].errors, Vec::<String>::new());
    assert!(!assets[1].join("welded.usdc").exists());
}

#[test]
fn faults_that_the_validators_overlook_are_found() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    fs::write(path.join("cut.usdc"), b"PXR-USDC").expect("it can be written");
    let sound = write_text_stage(path, "sound.usda", "[0, 1, 2, 2, 1, 3]", "[0, 0]");
    let unreal = path.join("unreal.usda");
    let text = fs::read_to_string(&sound).expect("it was written");
    fs::write(&unreal, text.replace("(1, 1, 0)]", "(1, nan, 0)]")).expect("it can be written");
    let files = [
        sound,
        unreal,
        write_text_stage(path, "index.usda", "[0, 1, 2, 2, 1, 9]", "[0, 0]"),
        write_text_stage(path, "length.usda", "[0, 1, 2, 2, 1, 3]", "[0, 0, 0]"),
        path.join("cut.usdc"),
        path.join("absent.usdc"),
    ];
    let reports = usd::check(&files, &python).expect("the check runs");
    let first = |i: usize| reports[i].errors.first().map(String::as_str).unwrap_or_default();
    assert_eq!(reports[0].errors, Vec::<String>::new());
    assert!(first(1).contains("not finite"), "{:?}", reports[1]);
    assert!(first(2).contains("topology"), "{:?}", reports[2]);
    assert!(first(3).contains("weldId has 3 values, uniform needs 2"), "{:?}", reports[3]);
    assert!(first(4).contains("cannot be opened"), "{:?}", reports[4]);
    assert!(first(5).contains("cannot be opened"), "{:?}", reports[5]);
}
