//! Grinds the weld of an asset in planned passes along its centreline, and reports the result.

mod passes;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use effects::CompiledModel;
use files::input::{self, MOST_TEXT_BYTES};
use robot::Wheel;
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Codec, GridRef};
use serde::Serialize;
use sim::{Executor, PassRecord};

use crate::asset::{AssetFields, MANIFEST_FILE, Manifest, WeldTruth, Welds, write_json};
use crate::console::Console;
use crate::grinding_page::grinding_page;
use crate::part::{Source, sha256};
use crate::pass_run::PassRun;
use crate::picture::{grinding, to_png};
use files::folder::StagedFolder;
use files::output::FolderKind;
pub use passes::WeldPass;
use passes::WeldPasses;
pub use passes::followed;
use study::snapshot::{Keeping, STATE_NAMES};
use trials::trial::Log;

/// Name of the result file in a grinding folder.
pub const GRIND_FILE: &str = "grind.json";
/// Other files of a grinding folder.
pub const GROUND_NAMES: &[&str] =
    &["ground.nvdb", "pass-*.csv", "before.png", "after.png", "removed.png", "sheet.png", PAGE_FILE];
/// Kind of a grinding folder.
pub const GROUND: FolderKind =
    FolderKind { marker: GRIND_FILE, key: "asset_sha256", names: &[("", GROUND_NAMES), ("", STATE_NAMES)] };
/// Name of the page in a grinding folder.
pub const PAGE_FILE: &str = "index.html";
/// Value of the `format` key.
pub const GRIND_FORMAT: &str = "robofin-grind/1";

/// Passes along a weld.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Normal force that the controller holds [N].
    pub force_setpoint: f64,
    /// Speed along the weld [m/s].
    pub feed: f64,
    /// Number of passes, to and fro.
    pub passes: u32,
}

impl Default for Plan {
    fn default() -> Self {
        Self { force_setpoint: 15.0, feed: 5e-3, passes: 2 }
    }
}

/// Wheel, passes and model for grinding a weld.
pub struct Grinding {
    /// The wheel.
    pub wheel: Wheel,
    /// The passes.
    pub plan: Plan,
    /// Laws and effects of the grinding.
    pub model: CompiledModel,
}

/// Processor for passes, and the console for reports.
#[derive(Clone, Copy)]
pub struct Session<'a> {
    /// Processor that runs the passes.
    pub executor: Executor<'a>,
    /// Console for progress and results.
    pub console: &'a Console,
}

/// A ground weld.
pub struct Ground {
    /// Source of the part.
    pub source: Source,
    /// SHA-256 of the asset's manifest.
    pub asset_sha256: String,
    /// The weld.
    pub weld: WeldTruth,
    /// Wheel, passes and model.
    pub grinding: Grinding,
    /// The workpiece as welded.
    pub before: BrickGrid,
    /// The completed passes, and the workpiece after them.
    pub run: PassRun<WeldPass>,
    /// Weld metal left above the part [m³].
    pub weld_left: f64,
    /// Removed base metal [m³]: total removal minus the weld's loss, cut at zero because of rounding.
    pub base_removed: f64,
}

/// `grind.json`, and the answer of `simulate --json`.
#[derive(Clone, Debug, Serialize)]
pub struct GrindSummary {
    format: &'static str,
    version: &'static str,
    source: Source,
    asset_sha256: String,
    weld_id: u16,
    wheel: Wheel,
    plan: Plan,
    model: BTreeMap<String, String>,
    /// Volume lost by the field in each pass [mm³].
    pub removed_mm3: Vec<f64>,
    /// Volume removed by Eq. (1), integrated over the contact [mm³].
    pub removed_by_law_mm3: Vec<f64>,
    /// Impulse ∫ F dt of each pass [N s].
    pub impulse_ns: Vec<f64>,
    /// Load impulse ∫∫ p dA dt of each pass [N s]; without a threshold, k times this is removed.
    pub load_impulse_ns: Vec<f64>,
    /// Root mean square of force minus setpoint in contact [N].
    pub force_rms_error_n: Vec<f64>,
    /// Highest pressure of each pass [MPa].
    pub pressure_max_mpa: Vec<f64>,
    /// Simulated time of each pass [s].
    pub duration_s: Vec<f64>,
    /// Number of steps in all passes.
    pub steps: usize,
    /// Weld metal above the part before grinding [mm³].
    pub weld_mm3: f64,
    /// Weld metal above the part after grinding [mm³].
    pub weld_left_mm3: f64,
    /// Removed base metal [mm³].
    pub base_removed_mm3: f64,
    /// Reason why the run ended before its last pass; absent if it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<String>,
}

/// Grinds the first weld of an asset along its centreline, in passes to and fro.
///
/// - `keeping`, `folder`: states to keep, and their folder; see [`study::snapshot`]
///
/// # Errors
/// If the asset or a state cannot be read, a setting does not fit it, or the first pass fails. A later pass that fails
/// is not an error; it is in [`PassRun::stopped`].
pub fn grind_asset(
    asset: &Path,
    grinding: Grinding,
    keeping: &Keeping,
    folder: &Path,
    session: Session<'_>,
) -> Result<Ground> {
    let (Wheel { width, .. }, console) = (grinding.wheel, session.console);
    let manifest = Manifest::read(asset)?;
    let asset_sha256 = sha256(&input::read(&asset.join(MANIFEST_FILE), MOST_TEXT_BYTES)?);
    let weld = Welds::read(asset)?.welds.into_iter().next().context("the asset has no weld to grind")?;
    let AssetFields { welded: before, target, .. } = AssetFields::open(asset)?;
    if 1e-3 * weld.width_mm > width {
        console.step("wheel", format!("narrower than the bead ({:.1} mm): one track will not cover it", weld.width_mm));
    }
    check_wheel(&grinding.wheel, before.voxel)?;
    let passes = WeldPasses::new(&grinding, (&before, &asset_sha256), &weld, session.executor)?;
    let run = PassRun::new(&passes, (keeping, folder), console)?.begun()?;
    let after = &run.state.part;
    let (weld_before, weld_left) = (before.difference_volume(&target), after.difference_volume(&target));
    let removed = before.volume() - after.volume();
    let base_removed = (removed - (weld_before - weld_left)).max(0.0);
    Ok(Ground { source: manifest.source, asset_sha256, weld, grinding, before, run, weld_left, base_removed })
}

/// Checks the wheel's size: a wheel smaller than a voxel falls between the voxels.
fn check_wheel(wheel: &Wheel, voxel: f64) -> Result<()> {
    for (flag, size) in [("--wheel-radius-mm", wheel.radius), ("--wheel-width-mm", wheel.width)] {
        ensure!(
            size >= voxel,
            "{flag} {}: the field has a voxel of {:.4} mm, and a wheel of at least that size is accepted",
            size * 1e3,
            voxel * 1e3
        );
    }
    Ok(())
}

/// Lists the parameters of a model as `effect.parameter` and value with unit.
pub fn model_facts(model: &CompiledModel) -> Vec<(String, String)> {
    let value = |(i, slot): (usize, &effects::ParameterSlot)| {
        (slot.name(), format!("{} {}", slot.unit.from_si(model.value(i)), slot.unit_text))
    };
    model.parameters().iter().enumerate().map(value).collect()
}

/// Describes the remaining weld metal and the removed base metal.
pub fn describe_rest(ground: &Ground) -> String {
    format!(
        "{:.2} of {:.2} mm³ of weld metal left, {:.3} mm³ of base metal ground away",
        ground.weld_left * 1e9,
        ground.weld.volume_mm3,
        ground.base_removed * 1e9
    )
}

impl Ground {
    /// Returns the results of the run; they do not depend on the machine.
    pub fn summary(&self) -> GrindSummary {
        let passes = || self.run.passes.iter();
        let each = |figure: fn(&PassRecord) -> f64| passes().map(|pass| figure(&pass.record)).collect::<Vec<f64>>();
        GrindSummary {
            format: GRIND_FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            source: self.source.clone(),
            asset_sha256: self.asset_sha256.clone(),
            weld_id: self.weld.id,
            wheel: self.grinding.wheel,
            plan: self.grinding.plan,
            model: model_facts(&self.grinding.model).into_iter().collect(),
            removed_mm3: passes().map(|pass| pass.lost * 1e9).collect(),
            removed_by_law_mm3: each(|pass| pass.removed_volume * 1e9),
            impulse_ns: each(|pass| pass.impulse),
            load_impulse_ns: each(|pass| pass.load_impulse),
            force_rms_error_n: each(|pass| pass.force_rms_error),
            pressure_max_mpa: each(|pass| pass.pressure_max * 1e-6),
            duration_s: each(|pass| pass.duration),
            steps: passes().map(|pass| pass.record.steps).sum(),
            weld_mm3: self.weld.volume_mm3,
            weld_left_mm3: self.weld_left * 1e9,
            base_removed_mm3: self.base_removed * 1e9,
            stopped: self.run.stopped.as_ref().map(|error| format!("{error:#}")),
        }
    }
}

/// Writes a grinding folder: the field, a log for each pass, pictures, results, the page. Returns the page for a folder
/// above, with other links.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    ground: &Ground,
    asset: &Path,
    staged: StagedFolder,
    links: &[(String, String)],
    console: &Console,
) -> Result<String> {
    let place = |name: &str| staged.path().join(name);
    let after = &ground.run.state.part;
    let grids = [GridRef::LevelSet { name: "phi", grid: after }, GridRef::Labels { name: "weld_id", grid: after }];
    fs::write(place("ground.nvdb"), nvdb::write(&grids, Codec::Zip)?)?;
    for (i, pass) in ground.run.passes.iter().enumerate() {
        fs::write(place(&format!("pass-{}.csv", i + 1)), log_csv(&pass.record))?;
    }
    let title = format!("{}, weld {}", ground.source.file, ground.weld.id);
    let pictures = grinding(&ground.before, after, &ground.weld, &title);
    for (name, picture) in [
        ("before", &pictures.before),
        ("after", &pictures.after),
        ("removed", &pictures.removed),
        ("sheet", &pictures.sheet),
    ] {
        fs::write(place(&format!("{name}.png")), to_png(picture)?)?;
    }
    write_json(&place(GRIND_FILE), &ground.summary())?;
    let logs = (1..=ground.run.passes.len()).map(|i| (format!("pass-{i}.csv"), format!("log of pass {i}")));
    let others = [("ground.nvdb", "the ground field"), ("sheet.png", "the pictures"), (GRIND_FILE, "all figures")];
    let own: Vec<(String, String)> =
        others.map(|(name, words)| (name.to_owned(), words.to_owned())).into_iter().chain(logs).collect();
    fs::write(place(PAGE_FILE), grinding_page(asset, ground, &pictures, &own)?)?;
    let page = grinding_page(asset, ground, &pictures, links)?;
    staged.commit()?;
    console.step("ground", "field, logs and pictures written");
    Ok(page)
}

/// Returns the log of a simulated pass in the trial format, with the approach axis.
pub fn log_csv(record: &PassRecord) -> String {
    trials::trial::log_csv(&Log { rows: record.log.clone(), has_approach: true, ..Log::default() })
}
