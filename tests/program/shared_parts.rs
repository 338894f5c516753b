//! Real CAD parts from outside: each gives a valid asset, or is refused with a reason.

use std::path::{Path, PathBuf};

use export::manifold::{ManifoldError, added_volume_in_glb};
use robofin::asset::Welds;

use crate::outside::{gltf_validator, python, untested};
use crate::program::{Outcome, names, robofin, run};

/// Number of parts in the shared folder.
const PARTS: usize = 24;
/// Least number of parts that give assets.
const ASSETS: usize = 20;
/// The open part: refused unless guessing its inside is allowed.
const OPEN_PART: &str = "other_cmu_WP_outerface.STL";
/// Greatest relative difference between the volume in the field and manifold3d's.
const VOLUME_TOLERANCE: f64 = 0.02;

/// Returns the folder of the shared parts; `None` after reporting a skipped test.
pub(crate) fn shared(what: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let place = std::env::var_os("ROBOFIN_SHARED").map_or_else(beside, PathBuf::from).join("data/abc");
    if place.is_dir() {
        return Some(place);
    }
    untested(what, &format!("{} is no folder; set ROBOFIN_SHARED", place.display()));
    None
}

fn weld(part: &Path, out: &Path, resolution: &str, more: &[&str]) -> Outcome {
    let mut command = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", resolution]);
    run(command.args(more).arg(part).arg("--out").arg(out))
}

#[test]
fn every_shared_part_becomes_a_valid_asset_or_is_refused_for_a_reason() {
    let Some(parts) = shared("welding real parts") else { return };
    let files: Vec<String> = names(&parts).into_iter().filter(|name| name != "SOURCES.md").collect();
    assert_eq!(files.len(), PARTS);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut assets = Vec::new();
    for file in &files {
        let out = folder.path().join(file);
        let outcome = weld(&parts.join(file), &out, "128", &[]);
        if outcome.status.code() == Some(1) {
            let reason = outcome.is_refused(1, &[]);
            assert!(reason.len() > 40 && !out.exists(), "{file}: {reason}");
            eprintln!("{file}: {reason}");
            continue;
        }
        outcome.succeeds();
        let checked = run(robofin(["validate", "--usd", "off"]).arg(&out));
        assert_eq!(checked.status.code(), Some(0), "{file}: {}", checked.stderr);
        assets.push(out);
    }
    assert!(assets.len() >= ASSETS, "{} assets", assets.len());
    let made: Vec<&str> = assets.iter().filter_map(|asset| asset.file_name()?.to_str()).collect();
    assert_eq!(names(folder.path()), made, "nothing else is left");
    check_volumes(&parts, &assets);
    check_gltf(&assets);
}

/// Compares the field's volume with manifold3d's, if the meshes have a well-defined union.
fn check_volumes(parts: &Path, assets: &[PathBuf]) {
    let Some(python) = python("bead volumes of real parts by manifold3d") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut compared = 0;
    for asset in assets {
        let name = asset.file_name().expect("a name").to_string_lossy().into_owned();
        let exact = match added_volume_in_glb(&asset.join("welded.glb"), &python) {
            Ok(volume) => volume.added * 1e9,
            Err(ManifoldError::Unusable { status }) => {
                eprintln!("{name}: not compared: {status}");
                continue;
            }
            Err(error) => panic!("{name}: {error}"),
        };
        let mut apart = volume_of(asset) / exact - 1.0;
        eprintln!("{name}: {:+.3} % from manifold3d's {exact:.3} mm³ at a resolution of 128", 100.0 * apart);
        if apart.abs() > VOLUME_TOLERANCE {
            let fine = folder.path().join(&name);
            weld(&parts.join(&name), &fine, "256", &[]).succeeds();
            let exact = added_volume_in_glb(&fine.join("welded.glb"), &python).expect("it had a union").added * 1e9;
            apart = volume_of(&fine) / exact - 1.0;
            eprintln!("{name}: {:+.3} % from manifold3d's {exact:.3} mm³ at a resolution of 256", 100.0 * apart);
        }
        assert!(apart.abs() <= VOLUME_TOLERANCE, "{name}: {apart}");
        compared += 1;
    }
    assert!(compared >= 10, "only {compared} parts have a volume to compare");
}

fn volume_of(asset: &Path) -> f64 {
    Welds::read(asset).expect("a truth file").welds.iter().map(|weld| weld.volume_mm3).sum()
}

fn check_gltf(assets: &[PathBuf]) {
    let files: Vec<PathBuf> =
        assets.iter().flat_map(|asset| ["workpiece.glb", "welded.glb"].map(|name| asset.join(name))).collect();
    let Some(reports) = gltf_validator("glTF files of real parts", &files) else { return };
    for (file, report) in files.iter().zip(&reports) {
        assert!(report["errors"] == 0 && report["warnings"] == 0, "{}: {report}", file.display());
    }
}

#[test]
fn an_open_surface_is_refused_with_its_edges_and_the_flag_that_accepts_it() {
    let Some(parts) = shared("an open surface") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    let refused = weld(&parts.join(OPEN_PART), &out, "128", &[]);
    let reason = refused.is_refused(1, &["open surface", "boundary edges", "--sign winding"]);
    let edges = reason.split(" boundary edges").next().and_then(|text| text.rsplit(' ').next());
    assert!(edges.and_then(|count| count.parse::<u32>().ok()) > Some(0), "{reason}");
    assert_eq!(names(folder.path()), Vec::<String>::new());

    weld(&parts.join(OPEN_PART), &out, "128", &["--sign", "winding"]).succeeds();
    run(robofin(["validate", "--usd", "off"]).arg(&out)).succeeds();
}
