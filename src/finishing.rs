//! Grinding the weld of an asset: planned passes along its centreline, and what they leave.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Codec, GridRef};
use serde::Serialize;
use sim::{CurvePoint, GrindSettings, LogRow, PassRecord, Wheel, grind};

use crate::asset::{AssetFields, MANIFEST_FILE, Manifest, WeldTruth, Welds, write_json};
use crate::console::Console;
use crate::folder::StagedFolder;
use crate::part::{Source, sha256};
use crate::picture::{grinding, to_png};
use crate::report::grinding_page;

/// Name of the result file in a grinding folder.
pub const GRIND_FILE: &str = "grind.json";
/// Name of the page in a grinding folder.
pub const PAGE_FILE: &str = "index.html";
/// Value of the `format` key.
pub const GRIND_FORMAT: &str = "robofin-grind/1";

/// Steps that a pass may take; a step takes some milliseconds.
const MOST_STEPS: f64 = 2e4;

/// A weld that has been ground.
pub struct Ground {
    /// Source of the part.
    pub source: Source,
    /// SHA-256 of the asset's manifest.
    pub asset_sha256: String,
    /// The weld.
    pub weld: WeldTruth,
    /// The wheel.
    pub wheel: Wheel,
    /// The process.
    pub settings: GrindSettings,
    /// The workpiece as welded.
    pub before: BrickGrid,
    /// The workpiece as ground.
    pub after: BrickGrid,
    /// One record for each pass.
    pub passes: Vec<PassRecord>,
    /// Weld metal that still stands above the part [m³].
    pub weld_left: f64,
    /// Base metal that was ground away [m³]: what was removed less what the weld lost; rounding below zero is cut.
    pub base_removed: f64,
    /// Time the simulation took [s].
    pub seconds: f64,
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
    settings: GrindSettings,
    /// Volume lost by the field in each pass [mm³].
    pub removed_mm3: Vec<f64>,
    /// Volume that Eq. (1) asks for, integrated over the contact [mm³].
    pub removed_by_law_mm3: Vec<f64>,
    /// ∫ F dt of each pass [N s].
    pub impulse_ns: Vec<f64>,
    /// Root mean square of force minus setpoint in contact [N].
    pub force_rms_error_n: Vec<f64>,
    /// Highest pressure of each pass [MPa].
    pub pressure_max_mpa: Vec<f64>,
    /// Simulated time of each pass [s].
    pub duration_s: Vec<f64>,
    /// Steps of all passes.
    pub steps: usize,
    /// Weld metal above the part before grinding [mm³].
    pub weld_mm3: f64,
    /// Weld metal above the part after grinding [mm³].
    pub weld_left_mm3: f64,
    /// Base metal ground away [mm³].
    pub base_removed_mm3: f64,
}

/// Grinds the first weld of an asset along its centreline, pass after pass to and fro.
///
/// # Errors
/// When the asset cannot be read, or a setting does not fit it.
pub fn grind_asset(asset: &Path, wheel: Wheel, settings: GrindSettings, console: &Console) -> Result<Ground> {
    let manifest = Manifest::read(asset)?;
    let asset_sha256 = sha256(&fs::read(asset.join(MANIFEST_FILE))?);
    let weld = Welds::read(asset)?.welds.into_iter().next().context("the asset has no weld to grind")?;
    let AssetFields { welded: before, target, .. } = AssetFields::open(asset)?;
    if 1e-3 * weld.width_mm > wheel.width {
        console.step("wheel", format!("narrower than the bead ({:.1} mm): one track will not cover it", weld.width_mm));
    }
    check_wheel(&wheel, before.voxel)?;
    let started = Instant::now();
    let mut after = before.clone();
    let passes = run_passes(&mut after, &weld, wheel, settings, console)?;
    let seconds = started.elapsed().as_secs_f64();
    let removed: f64 = passes.iter().map(|pass| pass.removed_volume).sum();
    let (weld_before, weld_left) = (before.difference_volume(&target), after.difference_volume(&target));
    Ok(Ground {
        source: manifest.source,
        asset_sha256,
        weld_left,
        base_removed: (removed - (weld_before - weld_left)).max(0.0),
        weld,
        wheel,
        settings,
        before,
        after,
        passes,
        seconds,
    })
}

/// A wheel smaller than a voxel falls between the voxels.
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

/// Refuses a pass that would take too long.
fn check_steps(path: &sim::Path, settings: &GrindSettings, voxel: f64) -> Result<()> {
    let steps = settings.steps(path, voxel);
    ensure!(
        steps <= MOST_STEPS,
        "a pass of {:.3e} s over {:.3e} mm takes {steps:.1e} steps, and {MOST_STEPS:.0e} are accepted: use a faster \
         --feed-mm-s, or a smaller --grind-rate or --stiffness (k K is {:.1e} 1/s)",
        path.duration(),
        path.length() * 1e3,
        settings.grind_rate * settings.stiffness
    );
    Ok(())
}

fn run_passes(
    grid: &mut BrickGrid,
    weld: &WeldTruth,
    wheel: Wheel,
    settings: GrindSettings,
    console: &Console,
) -> Result<Vec<PassRecord>> {
    let points = weld.curve.position.iter().zip(&weld.curve.normal);
    let curve: Vec<CurvePoint> = points.map(|(&position, &normal)| CurvePoint { position, normal }).collect();
    let forth = sim::Path::along(&curve, settings.feed)?;
    check_steps(&forth, &settings, grid.voxel)?;
    let back = forth.reversed();
    let mut passes = Vec::new();
    for pass in 1..=settings.passes {
        let path = if pass % 2 == 1 { &forth } else { &back };
        let bar = console.bar(&format!("pass {pass}"), 100);
        let record = grind(grid, path, &wheel, &settings, &mut |at| {
            bar.set_position((100 * at.step / at.steps.max(1)) as u64);
        })?;
        bar.finish_and_clear();
        if record.steps_in_air == record.steps {
            bail!("pass {pass}: the wheel never touched the part; is the weld within reach of the wheel?");
        }
        console.step(&format!("pass {pass}"), describe(&record));
        passes.push(record);
    }
    Ok(passes)
}

fn describe(record: &PassRecord) -> String {
    format!(
        "{:.2} mm³ removed in {:.1} s ({} steps), force off by {:.2e} N rms, peak pressure {:.2} MPa",
        record.removed_volume * 1e9,
        record.duration,
        record.steps,
        record.force_rms_error,
        record.pressure_max * 1e-6
    )
}

/// What a run left of the weld and took of the part, for people.
pub fn describe_rest(ground: &Ground) -> String {
    format!(
        "{:.2} of {:.2} mm³ of weld metal left, {:.3} mm³ of base metal ground away",
        ground.weld_left * 1e9,
        ground.weld.volume_mm3,
        ground.base_removed * 1e9
    )
}

impl Ground {
    /// Simulated time by the time that the simulation took.
    pub fn real_time_factor(&self) -> f64 {
        self.passes.iter().map(|pass| pass.duration).sum::<f64>() / self.seconds
    }

    /// The figures of the run; they do not depend on the machine.
    pub fn summary(&self) -> GrindSummary {
        let each = |figure: fn(&PassRecord) -> f64| self.passes.iter().map(figure).collect();
        GrindSummary {
            format: GRIND_FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            source: self.source.clone(),
            asset_sha256: self.asset_sha256.clone(),
            weld_id: self.weld.id,
            wheel: self.wheel,
            settings: self.settings,
            removed_mm3: each(|pass| pass.removed_volume * 1e9),
            removed_by_law_mm3: each(|pass| pass.removed_volume_by_law * 1e9),
            impulse_ns: each(|pass| pass.impulse),
            force_rms_error_n: each(|pass| pass.force_rms_error),
            pressure_max_mpa: each(|pass| pass.pressure_max * 1e-6),
            duration_s: each(|pass| pass.duration),
            steps: self.passes.iter().map(|pass| pass.steps).sum(),
            weld_mm3: self.weld.volume_mm3,
            weld_left_mm3: self.weld_left * 1e9,
            base_removed_mm3: self.base_removed * 1e9,
        }
    }
}

/// Writes a grinding folder: the field, a log for each pass, pictures, figures, the page. Returns the page.
///
/// # Errors
/// When a file cannot be written.
pub fn write(ground: &Ground, asset: &Path, staged: StagedFolder, console: &Console) -> Result<String> {
    let place = |name: &str| staged.path().join(name);
    let grids = [
        GridRef::LevelSet { name: "phi", grid: &ground.after },
        GridRef::Labels { name: "weld_id", grid: &ground.after },
    ];
    fs::write(place("ground.nvdb"), nvdb::write(&grids, Codec::Zip)?)?;
    for (pass, record) in ground.passes.iter().enumerate() {
        fs::write(place(&format!("pass-{}.csv", pass + 1)), log_csv(&record.log))?;
    }
    let title = format!("{}, weld {}", ground.source.file, ground.weld.id);
    let pictures = grinding(&ground.before, &ground.after, &ground.weld, &title);
    for (name, picture) in [
        ("before", &pictures.before),
        ("after", &pictures.after),
        ("removed", &pictures.removed),
        ("sheet", &pictures.sheet),
    ] {
        fs::write(place(&format!("{name}.png")), to_png(picture)?)?;
    }
    write_json(&place(GRIND_FILE), &ground.summary())?;
    let page = grinding_page(asset, ground, &pictures)?;
    fs::write(place(PAGE_FILE), &page)?;
    staged.commit()?;
    console.step("ground", "field, logs and pictures written");
    Ok(page)
}

/// A pass log in the columns of the trial format, with the approach axis.
fn log_csv(rows: &[LogRow]) -> String {
    let mut text = String::from("t_s,x_mm,y_mm,z_mm,force_n,spindle_rpm,nx,ny,nz\n");
    for row in rows {
        let (p, n) = (row.position * 1e3, row.approach);
        let rpm = row.spindle_speed * 60.0 / std::f64::consts::TAU;
        let _ = writeln!(
            text,
            "{:.4},{:.5},{:.5},{:.5},{:.4},{rpm:.1},{:.7},{:.7},{:.7}",
            row.time, p.x, p.y, p.z, row.force, n.x, n.y, n.z
        );
    }
    text
}
