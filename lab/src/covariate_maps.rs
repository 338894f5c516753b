//! Covariates of a pass as CSV maps over the pixels of the trial's scan.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use files::FileError;
use sdf_bake::PixelGrid;
use sim::Covariates;

/// Writes `passN_NAME_UNIT.csv` for each covariate: a row per y, a cell per x, empty where the tool never was.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, pass: usize, covariates: &Covariates, pixels: &PixelGrid) -> Result<(), FileError> {
    for (name, values, scale) in [
        ("pressure_time_mpa_s", &covariates.pressure_time, 1e-6),
        ("mean_pressure_mpa", &covariates.mean_pressure(), 1e-6),
        ("peak_pressure_mpa", &covariates.peak_pressure, 1e-6),
        ("contact_time_s", &covariates.contact_time, 1.0),
        ("mean_slip_speed_m_s", &covariates.mean_slip_speed(), 1.0),
        ("sliding_distance_m", &covariates.slip_way, 1.0),
        ("removed_um", &covariates.removed, 1e6),
        ("dose", &covariates.dose, 1.0),
        ("first_contact_s", &covariates.first_contact, 1.0),
    ] {
        let file = folder.join(format!("pass{pass}_{name}.csv"));
        let text = map_csv(pixels.nx, &covariates.at(pixels, values), scale);
        fs::write(&file, text).map_err(FileError::at(&file, "cannot write this file"))?;
    }
    Ok(())
}

fn map_csv(nx: usize, values: &[f64], scale: f64) -> String {
    let mut text = String::new();
    for row in values.chunks(nx) {
        for (i, value) in row.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let written = match value * scale {
                value if value.is_nan() => write!(text, "{comma}"),
                0.0 => write!(text, "{comma}0"),
                value => write!(text, "{comma}{value:.6e}"),
            };
            written.expect("a string takes all");
        }
        text.push('\n');
    }
    text
}
