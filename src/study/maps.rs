//! Maps, sections and volumes of the report: every scan against the base model and the model with what was found.

use sdf_bake::HeightMap;
use sim::effect::CompiledModel;

use crate::laboratory::{EvidenceError, HeightView, ScanData, ScanEvidence, ScanView, Split};
use crate::study_report::{Direction, ExposureMaps, HeightMaps, Maps, PassVolume, ScanComparison, ScanSection};
use crate::trial::{PassScan, Role};
use crate::twin::SimulatedPass;

/// Sections across, as shares of the map's length.
const ACROSS: [f64; 3] = [0.25, 0.5, 0.75];
/// Scans from which sections are shown.
const SECTIONED: usize = 2;

/// What both models make of all scans.
pub struct Seen<'a> {
    evidence: &'a ScanEvidence<'a>,
    base: Simulated,
    found: Option<Simulated>,
}

struct Simulated {
    model: CompiledModel,
    calibration: Vec<Vec<SimulatedPass>>,
    evaluation: Vec<Vec<SimulatedPass>>,
}

impl Simulated {
    fn new(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Self, EvidenceError> {
        Ok(Self {
            model: model.clone(),
            calibration: evidence.simulate(model, Split::Calibration)?,
            evaluation: evidence.simulate(model, Split::Evaluation)?,
        })
    }

    fn pass(&self, view: &ScanView) -> &SimulatedPass {
        let passes = if view.split == Split::Calibration { &self.calibration } else { &self.evaluation };
        &passes[view.trial][view.pass]
    }

    fn heights(&self, evidence: &ScanEvidence, view: &ScanView) -> Option<HeightMap> {
        match &self.pass(view).scan {
            PassScan::Heights(map) => Some(evidence.seen(view, map, evidence.blur.unwrap_or(0.0))),
            PassScan::Exposure(_) => None,
        }
    }

    fn exposed(&self, view: &ScanView) -> Vec<bool> {
        let margin = self.pass(view).surface.dose_margin(&self.model).ok().flatten().unwrap_or_default();
        margin.iter().map(|margin| *margin >= 0.0).collect()
    }
}

impl<'a> Seen<'a> {
    /// Simulates all scans with the base model and, where something was found, with that.
    ///
    /// # Errors
    /// When a model cannot be simulated.
    pub fn new(
        evidence: &'a ScanEvidence<'a>,
        base: &CompiledModel,
        found: Option<&CompiledModel>,
    ) -> Result<Self, EvidenceError> {
        let found = found.map(|model| Simulated::new(evidence, model)).transpose()?;
        Ok(Self { evidence, base: Simulated::new(evidence, base)?, found })
    }

    /// Name of a scan's pass.
    pub fn name(&self, view: &ScanView) -> String {
        format!("{}, pass {}", self.evidence.twin.trials[view.trial].trial.name, view.pass + 1)
    }

    /// Role of a scan's pass.
    pub fn role(view: &ScanView) -> Role {
        match view.split {
            Split::Calibration => Role::Calibration,
            Split::Evaluation => Role::Evaluation,
        }
    }

    /// All scans against both models.
    pub fn scans(&self) -> Vec<ScanComparison> {
        let compare = |view: &ScanView| {
            let maps = match &view.data {
                ScanData::Heights(data) => Maps::Heights(self.heights(view, data)?),
                ScanData::Exposure(data) => Maps::Exposure(ExposureMaps {
                    pixels: data.measured.pixels,
                    measured: data.measured.exposed.clone(),
                    base: self.base.exposed(view),
                    with_effect: self.found.as_ref().map(|found| found.exposed(view)),
                }),
            };
            Some(ScanComparison { pass: self.name(view), role: Self::role(view), maps })
        };
        self.evidence.views.iter().filter_map(compare).collect()
    }

    fn heights(&self, view: &ScanView, data: &HeightView) -> Option<HeightMaps> {
        let left = |simulated: &Simulated| Some(data.left(&simulated.heights(self.evidence, view)?));
        let mut judged = vec![false; data.measured.heights.len()];
        data.tiles.pixels().for_each(|(_, at)| judged[at] = true);
        Some(HeightMaps {
            pixels: data.measured.pixels,
            base: left(&self.base)?,
            with_effect: self.found.as_ref().and_then(left),
            judged,
            judged_as: "near the tool".to_owned(),
            noise_floor: self.evidence.noise[view.trial].rms,
        })
    }

    /// Sections through the last scans, across and along.
    pub fn sections(&self) -> Vec<ScanSection> {
        let views = self.evidence.views.iter().rev().take(SECTIONED);
        views.flat_map(|view| self.sections_of(view).unwrap_or_default()).collect()
    }

    fn sections_of(&self, view: &ScanView) -> Option<Vec<ScanSection>> {
        let ScanData::Heights(data) = &view.data else { return None };
        let base = self.base.heights(self.evidence, view)?;
        let found = self.found.as_ref().and_then(|found| found.heights(self.evidence, view));
        let pixels = data.measured.pixels;
        let levelled: Vec<f64> = data.left(&base).iter().zip(&base.heights).map(|(left, base)| left + base).collect();
        let section = |direction: Direction, line: Vec<usize>| {
            let of = |heights: &[f64]| line.iter().map(|&at| heights[at]).collect::<Vec<f64>>();
            let place = |k: usize| match direction {
                Direction::Across(_) => pixels.origin.y + pixels.pitch * k as f64,
                Direction::AlongCrest => pixels.origin.x + pixels.pitch * k as f64,
            };
            ScanSection {
                pass: self.name(view),
                direction,
                position: (0..line.len()).map(place).collect(),
                measured: of(&levelled),
                base: of(&base.heights),
                with_effect: found.as_ref().map(|found| of(&found.heights)),
                noise_floor: self.evidence.noise[view.trial].rms,
            }
        };
        let across = |share: &f64| {
            let i = (share * pixels.nx as f64) as usize;
            let x = pixels.origin.x + pixels.pitch * i as f64;
            section(Direction::Across(x), (0..pixels.ny).map(|j| pixels.at(i, j)).collect())
        };
        let along = section(Direction::AlongCrest, (0..pixels.nx).map(|i| pixels.at(i, pixels.ny / 2)).collect());
        Some(ACROSS.iter().map(across).chain([along]).collect())
    }

    /// Volume removed up to each scan.
    pub fn volumes(&self) -> Vec<PassVolume> {
        self.evidence.views.iter().filter_map(|view| self.volume(view)).collect()
    }

    fn volume(&self, view: &ScanView) -> Option<PassVolume> {
        let ScanData::Heights(data) = &view.data else { return None };
        let before = &self.evidence.twin.trials[view.trial].trial.scans.before;
        let area = data.measured.pixels.pitch.powi(2);
        let simulated = |simulated: &Simulated| {
            let map = simulated.heights(self.evidence, view)?;
            let removed = |at: usize| Some(before.heights[at] - map.heights[at]).filter(|depth| depth.is_finite());
            let sum: f64 = data.tiles.pixels().filter_map(|(_, at)| removed(at)).sum();
            Some((sum * area, map))
        };
        let (base, map) = simulated(&self.base)?;
        let left = data.left(&map);
        let left: f64 = data.tiles.pixels().map(|(_, at)| left[at]).filter(|left| left.is_finite()).sum();
        Some(PassVolume {
            pass: self.name(view),
            measured: base - left * area,
            uncertainty: data.volume_sigma(),
            base,
            with_effect: self.found.as_ref().and_then(simulated).map(|(volume, _)| volume),
        })
    }
}
