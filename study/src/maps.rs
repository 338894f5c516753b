//! Maps, sections and volumes of the report: every scan compared with the base model and with the model with effects.

use super::measurements::Data;
use super::track::{Ground, Volume, line_of};
use crate::{Direction, ExposureMaps, HeightMaps, Maps, PassTiles, PassVolume, ScanComparison, ScanSection};
use lab::Simulated;
use lab::{ExposureView, HeightView, ScanEvidence, ScanView, Split};
use trials::trial::Role;

/// Default sections across, as shares of the map's length.
const ACROSS: [f64; 3] = [1.0 / 7.0, 0.5, 6.0 / 7.0];
/// Number of scans with default sections.
const SECTIONED: usize = 2;

/// Simulations of all scans with both models.
pub struct Seen<'a> {
    /// The scans.
    pub evidence: &'a ScanEvidence<'a>,
    /// The base model.
    pub base: &'a Simulated,
    /// The model with effects, if there is one.
    pub found: Option<&'a Simulated>,
    /// Requested sections.
    pub lines: &'a [Direction],
}

/// Name of a scan's pass.
pub fn name(evidence: &ScanEvidence, view: &ScanView) -> String {
    format!("{}, pass {}", evidence.simulation.trials()[view.trial].trial.name, view.pass + 1)
}

/// Role of a scan's pass.
pub fn role(view: &ScanView) -> Role {
    match view.split {
        Split::Calibration => Role::Calibration,
        Split::Evaluation => Role::Evaluation,
    }
}

/// Volume that a pass removed, from the scans up to it and a model; `None` when sanding.
///
/// - `ground`: comparison of a scan with the model
pub fn pass_volume<'a>(
    evidence: &'a ScanEvidence,
    view: &'a ScanView,
    ground: &dyn Fn(&'a ScanView) -> Option<Ground<'a>>,
) -> Option<Volume> {
    let before = &evidence.simulation.trials()[view.trial].trial.scans.before;
    let up_to = |view: &'a ScanView| Some(ground(view)?.volume(before));
    let all = up_to(view)?;
    let is_earlier = |other: &&ScanView| other.trial == view.trial && other.pass + 1 == view.pass;
    let Some(earlier) = evidence.views.iter().find(is_earlier).and_then(up_to) else { return Some(all) };
    Some(Volume {
        measured: all.measured - earlier.measured,
        uncertainty: all.uncertainty.hypot(earlier.uncertainty),
        simulated: all.simulated - earlier.simulated,
    })
}

impl<'a> Seen<'a> {
    /// The scans with their simulations; `None` for a table.
    pub fn of(data: &'a Data, simulated: Option<&'a [Simulated]>) -> Option<Self> {
        let ((_, evidence), simulated) = data.scans().zip(simulated)?;
        Some(Self { evidence, base: &simulated[0], found: simulated.get(1), lines: &[] })
    }
}

impl Seen<'_> {
    /// Residuals and covariates of all tiles, with the last model.
    pub fn tiles(&self) -> Vec<PassTiles> {
        PassTiles::all(self.evidence, self.found.unwrap_or(self.base))
    }

    /// Comparison of all scans with both models.
    pub fn scans(&self) -> Vec<ScanComparison> {
        let compare = |view: &ScanView| {
            let heights = || Some(Maps::Heights(self.heights(view, view.data.as_heights()?)?));
            let exposure = || Some(Maps::Exposure(self.exposure(view, view.data.as_exposure()?)));
            let maps = heights().or_else(exposure)?;
            Some(ScanComparison { pass: name(self.evidence, view), role: role(view), maps })
        };
        self.evidence.views.iter().filter_map(compare).collect()
    }

    fn exposure(&self, view: &ScanView, data: &ExposureView) -> ExposureMaps {
        ExposureMaps {
            pixels: data.measured.pixels,
            measured: data.measured.exposed.clone(),
            base: self.base.exposed(view),
            with_effect: self.found.map(|found| found.exposed(view)),
        }
    }

    fn heights(&self, view: &ScanView, data: &HeightView) -> Option<HeightMaps> {
        let left = |simulated: &Simulated| Some(Ground::new(view, simulated)?.left);
        let mut judged = vec![false; data.measured.heights.len()];
        data.judged.pixels().for_each(|(_, at)| judged[at] = true);
        Some(HeightMaps {
            pixels: data.measured.pixels,
            base: left(self.base)?,
            with_effect: self.found.and_then(left),
            judged,
            judged_as: "near the tool".to_owned(),
            noise_floor: self.evidence.noise[view.trial].floor.rms,
        })
    }

    /// The requested sections through all scans, or default ones through the last scans.
    pub fn sections(&self) -> Vec<ScanSection> {
        let count = if self.lines.is_empty() { SECTIONED } else { self.evidence.views.len() };
        let mut views: Vec<&ScanView> = self.evidence.views.iter().rev().take(count).collect();
        if !self.lines.is_empty() {
            views.reverse();
        }
        views.into_iter().flat_map(|view| self.sections_of(view).unwrap_or_default()).collect()
    }

    fn sections_of(&self, view: &ScanView) -> Option<Vec<ScanSection>> {
        let ground = Ground::new(view, self.base)?;
        let found = self.found.and_then(|found| Some(Ground::new(view, found)?.heights().1));
        let (pixels, (measured, base)) = (ground.seen.pixels, ground.heights());
        let section = |&direction: &Direction| {
            let line = line_of(pixels, direction);
            let start = if matches!(direction, Direction::Across(_)) { pixels.origin.y } else { pixels.origin.x };
            let of = |heights: &[f64]| line.iter().map(|&at| heights[at]).collect::<Vec<f64>>();
            ScanSection {
                pass: name(self.evidence, view),
                direction,
                position: (0..line.len()).map(|k| start + pixels.pitch * k as f64).collect(),
                measured: of(&measured),
                base: of(&base),
                with_effect: found.as_deref().map(of),
                noise_floor: self.evidence.noise[view.trial].floor.rms,
            }
        };
        let across = |share: &f64| Direction::Across(pixels.origin.x + share * pixels.pitch * (pixels.nx - 1) as f64);
        let usual: Vec<Direction> = ACROSS.iter().map(across).chain([Direction::AlongCrest]).collect();
        Some(if self.lines.is_empty() { &usual } else { self.lines }.iter().map(section).collect())
    }

    /// Volume that each pass removed.
    pub fn volumes(&self) -> Vec<PassVolume> {
        let volume = |view: &ScanView| {
            let of = |simulated: &Simulated| pass_volume(self.evidence, view, &|view| Ground::new(view, simulated));
            let (base, found) = (of(self.base)?, self.found.and_then(of));
            Some(PassVolume {
                pass: name(self.evidence, view),
                measured: base.measured,
                uncertainty: base.uncertainty,
                base: base.simulated,
                with_effect: found.map(|found| found.simulated),
            })
        };
        self.evidence.views.iter().filter_map(volume).collect()
    }
}
