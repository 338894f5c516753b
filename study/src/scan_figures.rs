//! Figures of one scan: error, volume, plateau, exposed area, sections.

use serde::Serialize;

use super::maps::{name, pass_volume, role};
use super::track::{Ground, exposure, line_of};
use crate::Direction;
use lab::Simulated;
use lab::{ScanEvidence, ScanView};
use trials::measure::Plateau;
use trials::trial::Role;

/// Figures of a section.
#[derive(Clone, Debug, Serialize)]
pub struct SectionFigures {
    /// Position, such as `x = 20 mm`.
    pub place: String,
    /// Root mean square of measured minus simulated along it [µm].
    pub rms_um: f64,
    /// Mean of measured minus simulated over its plateau [µm]; absent where the section has none.
    pub plateau_height_error_um: Option<f64>,
}

/// Figures of one scan.
#[derive(Clone, Debug, Serialize)]
pub struct ScanFigures {
    /// Trial and pass.
    pub pass: String,
    /// Role of the pass: calibration or evaluation.
    pub role: Role,
    /// Root mean square error near the tool [µm]; when sanding, the mean distance of the borders.
    pub rms_um: f64,
    /// Noise floor of `rms_um`: the error that a perfect model would leave [µm].
    pub noise_floor_um: f64,
    /// Volume that the pass removed: measured, its standard uncertainty, simulated [mm³]; absent when sanding.
    pub volume_mm3: Option<[f64; 3]>,
    /// Mean of measured minus simulated height of the plateau, and its standard uncertainty [µm].
    pub plateau_height_error_um: Option<[f64; 2]>,
    /// Slope of the plateau across the path: measured, its standard uncertainty, simulated [mrad].
    pub plateau_slope_mrad: Option<[f64; 3]>,
    /// Exposed area, measured and simulated [mm²]; absent when grinding.
    pub exposed_mm2: Option<[f64; 2]>,
    /// Intersection over union of the exposed area.
    pub intersection_over_union: Option<f64>,
    /// Requested sections.
    pub sections: Vec<SectionFigures>,
}

/// Computes the figures of a section.
fn section(ground: &Ground, plateau: &Plateau, line: Direction) -> SectionFigures {
    let pixels = line_of(ground.seen.pixels, line);
    let left: Vec<f64> = pixels.iter().map(|&at| ground.left[at]).filter(|left| left.is_finite()).collect();
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len().max(1) as f64;
    let squares: Vec<f64> = left.iter().map(|left| left * left).collect();
    let flat: Vec<f64> =
        pixels.iter().filter(|&&at| plateau.holds(at)).map(|&at| ground.left[at]).filter(|l| l.is_finite()).collect();
    let place = match line {
        Direction::Across(x) => format!("x = {} mm", x * 1e3),
        Direction::Along(y) => format!("y = {} mm", y * 1e3),
        Direction::AlongCrest => "along the crest".to_owned(),
    };
    SectionFigures {
        place,
        rms_um: 1e6 * mean(&squares).sqrt(),
        plateau_height_error_um: (!flat.is_empty()).then(|| 1e6 * mean(&flat)),
    }
}

/// Computes the figures of a scan.
///
/// - `lines`: requested sections
pub(super) fn figures(
    evidence: &ScanEvidence,
    view: &ScanView,
    simulated: &Simulated,
    lines: &[Direction],
) -> ScanFigures {
    let trial = evidence.simulation.trials()[view.trial].trial;
    let (before, noise) = (&trial.scans.before, evidence.noise[view.trial].floor.rms);
    let ground = Ground::new(view, simulated);
    let plateau = ground.as_ref().map(|ground| ground.plateau(before, &trial.passes[view.pass], noise));
    let on_plateau = ground.as_ref().zip(plateau.as_ref()).and_then(|(ground, plateau)| ground.figures(plateau));
    let volume = pass_volume(evidence, view, &|view| Ground::new(view, simulated));
    let exposed = exposure(view, simulated);
    let agreement = view.data.agreement(simulated.predicted(view), evidence.untouched(view));
    let (rms, floor) = (ground.as_ref().map_or(agreement.rms, Ground::rms), agreement.floor);
    let section = |line: &Direction| Some(section(ground.as_ref()?, plateau.as_ref()?, *line));
    ScanFigures {
        pass: name(evidence, view),
        role: role(view),
        rms_um: 1e6 * rms,
        noise_floor_um: 1e6 * floor,
        volume_mm3: volume.map(|v| [v.measured, v.uncertainty, v.simulated].map(|volume| 1e9 * volume)),
        plateau_height_error_um: on_plateau.map(|p| [p.height_error, p.height_uncertainty].map(|height| 1e6 * height)),
        plateau_slope_mrad: on_plateau.map(|p| [p.slopes[0], p.slope_uncertainty, p.slopes[1]].map(|s| 1e3 * s)),
        exposed_mm2: exposed.map(|exposed| exposed.areas.map(|area| 1e6 * area)),
        intersection_over_union: exposed.map(|exposed| exposed.overlap),
        sections: lines.iter().filter_map(section).collect(),
    }
}
