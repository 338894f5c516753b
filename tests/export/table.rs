//! Every file of an asset, listed by the table of exporters.

use std::fs;
use std::path::{Path, PathBuf};

use files::folder::StagedFolder;
use robofin::asset::{
    self, EXPORTS, Export, Extras, FileRecord, MANIFEST_FILE, Manifest, USD_FILE, UsdMode, write_json,
};
use robofin::console::Console;
use robofin::part::Part;
use robofin::validate::validate;
use robofin::workpiece::{Fineness, WeldSettings, WeldingOptions, Workpiece, weld_part};
use sdf_bake::SignChoice;

use crate::outside::python;

/// Makes a welded bracket with coarse voxels.
fn workpiece() -> (Workpiece, WeldingOptions) {
    let options = WeldingOptions {
        seed: 3,
        fineness: Fineness::Diagonal(64),
        band_voxels: 3.0,
        sign: SignChoice::Auto,
        wishes: WeldSettings::default(),
    };
    let part = Part::bundled().expect("the bundled part");
    (weld_part(part, &options, &Console::silent()).expect("a welded part"), options)
}

fn written(folder: &Path, (workpiece, options): &(Workpiece, WeldingOptions), usd: UsdMode) -> PathBuf {
    let staged = StagedFolder::fresh(folder).expect("a folder");
    let extras = Extras { density: Some(2700.0), models: true, vdb: true, usd, preview: (32, 24), samples_per_side: 1 };
    asset::write(workpiece, options, staged, extras, &Console::silent()).expect("an asset")
}

/// Lists the failed checks that name a file.
fn faults(asset: &Path, file: &str, usd: UsdMode) -> Vec<String> {
    let checks = validate(asset, usd).expect("a manifest").checks;
    let failed = checks.into_iter().filter(|check| !check.passed);
    let named = failed.filter(|check| check.file == file || check.found.contains(file));
    named.map(|check| format!("{}: {} ({})", check.file, check.rule, check.found)).collect()
}

/// Truncates a file to half, and updates its hash in the manifest.
fn cut(asset: &Path, file: &str) {
    let whole = fs::read(asset.join(file)).expect("a file");
    fs::write(asset.join(file), &whole[..whole.len() / 2]).expect("written");
    let mut manifest = Manifest::read(asset).expect("a manifest");
    manifest.files.insert(file.to_owned(), FileRecord::of_bytes(&whole[..whole.len() / 2]));
    write_json(&asset.join(MANIFEST_FILE), &manifest).expect("a manifest");
}

#[test]
fn every_export_is_listed_documented_the_same_twice_and_missed_when_it_is_cut() {
    let usd = if python("welded.usdc among the exports").is_some() { UsdMode::Require } else { UsdMode::Off };
    let (place, welded) = (tempfile::tempdir().expect("a temporary folder"), workpiece());
    let [one, two] = ["one", "two"].map(|name| written(&place.path().join(name), &welded, usd));
    let manifest = Manifest::read(&one).expect("a manifest");
    let made: Vec<&Export> =
        EXPORTS.iter().filter(|export| export.file != USD_FILE || usd == UsdMode::Require).collect();
    let mut names: Vec<&str> = made.iter().map(|export| export.file).collect();
    names.sort_unstable();
    assert!(manifest.files.keys().eq(&names), "{:?}, {names:?} are in the table", manifest.files.keys());
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/assets.md")).expect("the page");
    for Export { file, media_type, .. } in made {
        assert!(page.contains(&format!("| `{file}` |")), "{file} has no row in docs/assets.md");
        assert_eq!(media_type.matches('/').count(), 1, "{file}: {media_type}");
        let content = fs::read(one.join(file)).expect("a file");
        assert!(content == fs::read(two.join(file)).expect("a file"), "{file} differs between two runs");
        assert_eq!(faults(&one, file, usd), [""; 0], "{file}");
        cut(&two, file);
        assert_ne!(faults(&two, file, usd), [""; 0], "half of {file} is taken for a whole one");
        fs::write(two.join(file), content).expect("written");
        fs::copy(one.join(MANIFEST_FILE), two.join(MANIFEST_FILE)).expect("a manifest");
    }
}
