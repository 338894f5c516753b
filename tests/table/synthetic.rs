//! Tables made by independent formulas, with one hidden effect.

use std::fs;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;

/// Number of rows in a table.
pub(crate) const ROWS: usize = 90;
/// Rate constant [m/(Pa s)]: 0.002 mm/(MPa s).
pub(crate) const RATE: f64 = 2e-12;
/// Area of the contact [m²].
pub(crate) const AREA: f64 = 1e-4;
/// Relative standard deviation of a row's removal.
pub(crate) const NOISE: f64 = 0.02;
/// Volume after which a tool is dull to 1/e [m³].
pub(crate) const DULLING: f64 = 350e-9;
/// Exponents of pressure and speed.
pub(crate) const PRESSURE_EXPONENT: f64 = 0.8;
pub(crate) const SPEED_EXPONENT: f64 = 0.6;

/// Hidden effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hidden {
    Nothing,
    /// The rate falls with the volume that the tool has ground.
    Dulling,
    Pressure,
    Speed,
    /// The rate falls with a wear given by a column.
    Usage,
}

/// One row of the table, in SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    pub(crate) force: f64,
    pub(crate) speed: f64,
    pub(crate) duration: f64,
    /// Wear in the column [m³].
    pub(crate) wear: f64,
    pub(crate) depth: f64,
}

/// Makes rows with a hidden effect and noise of a relative standard deviation.
pub(crate) fn work(hidden: Hidden, noise: f64, seed: u64) -> Vec<Work> {
    let mut random = Pcg64::seed_from_u64(seed);
    let (mut ground, mut wear) = (0.0, 0.0);
    let one = |_| {
        let force = 10.0 * random.random_range(1..=6) as f64;
        let speed = 20.0 + 5.0 * random.random_range(0..=4) as f64;
        let duration = 20.0 + 10.0 * random.random_range(0..=4) as f64;
        wear += 1e-9 * random.random_range(0.0..12.0);
        let pressure = force / AREA;
        let plain = RATE * pressure * duration;
        let depth = match hidden {
            Hidden::Nothing => plain,
            // dV/dt = R exp(-V/Vs), solved in closed form.
            Hidden::Dulling => {
                let before = ground;
                ground = DULLING * (f64::exp(before / DULLING) + plain * AREA / DULLING).ln();
                (ground - before) / AREA
            }
            Hidden::Pressure => RATE * 3e5 * (pressure / 3e5).powf(PRESSURE_EXPONENT) * duration,
            Hidden::Speed => plain * (speed / 30.0).powf(SPEED_EXPONENT),
            Hidden::Usage => plain * f64::exp(-wear / DULLING),
        };
        let error: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum();
        Work { force, speed, duration, wear, depth: depth * (noise * error).exp() }
    };
    (0..ROWS).map(one).collect()
}

/// Returns the CSV of rows: load [N], belt [m/s], t [s], wear [mm³], depth [µm].
pub(crate) fn csv(rows: &[Work]) -> String {
    let line = |row: &Work| {
        let (wear, depth) = (row.wear * 1e9, row.depth * 1e6);
        format!("{},{},{},{wear:.4},{depth:.6}\n", row.force, row.speed, row.duration)
    };
    let lines: String = rows.iter().map(line).collect();
    format!("load,belt,t,wear,depth\n{lines}")
}

/// Manifest for [`csv`].
pub(crate) const MANIFEST: &str = r#"format = "finishing-table/1"
name = "synthetic"
process = "grinding"
csv = "rows.csv"

[columns]
force = { column = "load", unit = "N", area_mm2 = 100 }
speed = { column = "belt", unit = "m/s" }
duration = { column = "t", unit = "s" }
removed = { column = "depth", unit = "um" }
"#;

/// Line that makes the wear a state.
pub(crate) const USAGE: &str = "usage = { column = \"wear\", unit = \"mm^3\" }\n";

/// Writes a folder with a manifest and a CSV.
pub(crate) fn folder(manifest: &str, csv: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), manifest, csv);
    folder
}

pub(crate) fn write(folder: &Path, manifest: &str, csv: &str) {
    fs::write(folder.join("table.toml"), manifest).unwrap();
    fs::write(folder.join("rows.csv"), csv).unwrap();
}
