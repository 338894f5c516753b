//! Waterfall of the error of scans: as read, registered on the untouched surface, with each model, and the noise floor.

use rayon::prelude::*;
use sdf_bake::HeightMap;

use super::maps::{name, pass_volume};
use super::track::{Ground, alignment, exposure};
use crate::{Misfit, Waterfall, WaterfallStep};
use lab::Simulated;
use lab::{Agreement, ScanEvidence, ScanView, Split};
use trials::measure::Registration;

/// Registration of measured heights on the simulated ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pose {
    /// None: as in the file.
    AsRead,
    /// On the scan before, over the untouched surface.
    Registered,
    /// Height and tilt from the untouched surface, and the best-fitting shift.
    Held,
}

/// A model in the waterfall.
pub struct Step<'a> {
    /// Name, such as `base model` or `+ grit-dulling`.
    pub name: String,
    /// Its passes.
    pub simulated: &'a Simulated,
}

/// All scans with their registrations.
pub struct Scans<'a> {
    /// The scans.
    pub evidence: &'a ScanEvidence<'a>,
    /// True if the errors of models use the best-fitting poses, as a diagnosis does.
    free: bool,
    /// Registration of each scan on the scan before the first pass, and its levelled heights.
    alignments: Vec<Option<(Registration, HeightMap)>>,
}

impl<'a> Scans<'a> {
    /// Registers every scan on the untouched surface.
    ///
    /// - `free`: true to compute the errors of models at the best-fitting poses, as a diagnosis does
    pub fn new(evidence: &'a ScanEvidence<'a>, free: bool) -> Self {
        Self { evidence, free, alignments: evidence.views.par_iter().map(|view| alignment(evidence, view)).collect() }
    }

    /// Registration of a scan on the scan before the first pass.
    pub fn alignment(&self, view: &ScanView) -> Option<Registration> {
        Some(self.of(view)?.0)
    }

    fn of(&self, view: &ScanView) -> Option<&(Registration, HeightMap)> {
        let same = |other: &ScanView| (other.trial, other.pass) == (view.trial, view.pass);
        self.alignments[self.evidence.views.iter().position(same)?].as_ref()
    }

    fn ground(&self, view: &'a ScanView, simulated: &Simulated, pose: Pose) -> Option<Ground<'a>> {
        let held = Ground::new(view, simulated)?;
        let data = view.data.as_heights()?;
        match pose {
            Pose::AsRead => Some(held.against(&data.measured)),
            Pose::Registered => Some(held.against(&self.of(view)?.1)),
            Pose::Held => Some(held),
        }
    }

    /// The waterfall from `start`, which is shown as read and as registered, over the models to the floor. Shares refer
    /// to the first model's excess over the floor.
    pub fn waterfall(&self, start: &Simulated, models: &[Step]) -> Waterfall {
        let views = &self.evidence.views;
        let ground = views.iter().any(|view| view.data.as_heights().is_some());
        let mut steps = Vec::new();
        if ground {
            steps.push(self.step("raw", start, Pose::AsRead));
            steps.push(self.step("registered", start, Pose::Registered));
        }
        let first = steps.len();
        steps.extend(models.iter().map(|model| self.step(&model.name, model.simulated, Pose::Held)));
        let floor = models.first().map(|model| self.floor(model.simulated)).unwrap_or_default();
        let least = floor.calibration.or(floor.evaluation).unwrap_or(0.0);
        let excess = |step: &WaterfallStep| {
            let rms = step.calibration.or(step.evaluation).unwrap_or(0.0);
            (rms * rms - least * least).max(0.0)
        };
        let whole = steps.get(first).map_or(0.0, excess);
        let shares: Vec<f64> = steps.iter().map(|step| excess(step) / whole).collect();
        if models.len() > 1 && whole > 0.0 {
            steps.iter_mut().zip(shares).skip(first).for_each(|(step, share)| step.unexplained = Some(share));
        }
        steps.push(floor);
        let misfit = if ground {
            Misfit::heights()
        } else {
            Misfit { name: "distance between the borders, mean".to_owned(), ..Misfit::heights() }
        };
        let passes = if ground { views.iter().map(|view| name(self.evidence, view)).collect() } else { Vec::new() };
        Waterfall { misfit, passes, steps, notes: Vec::new() }
    }

    fn step(&self, name: &str, simulated: &Simulated, pose: Pose) -> WaterfallStep {
        let views = &self.evidence.views;
        let misfit = |view: &'a ScanView| match self.ground(view, simulated, pose) {
            Some(ground) if !self.free || pose != Pose::Held => Some(ground.rms()),
            None if view.data.as_heights().is_some() => None,
            _ => Some(self.agreement(view, simulated).rms),
        };
        let volume = |view: &'a ScanView| {
            let volume = pass_volume(self.evidence, view, &|view| self.ground(view, simulated, pose))?;
            of_measured(volume.measured, [volume.simulated - volume.measured, volume.uncertainty])
        };
        let slope = |view: &'a ScanView| {
            let [measured, simulated] = self.plateau(view, simulated, pose)?.slopes;
            Some(measured - simulated)
        };
        let overlaps: Vec<f64> = views.iter().filter_map(|view| Some(exposure(view, simulated)?.overlap)).collect();
        WaterfallStep {
            name: name.to_owned(),
            calibration: self.rms(Split::Calibration, misfit),
            evaluation: self.rms(Split::Evaluation, misfit),
            volume_errors: views.iter().map(volume).collect(),
            plateau_slope: rms(views.iter().filter_map(slope)),
            overlap: (!overlaps.is_empty()).then(|| overlaps.iter().sum::<f64>() / overlaps.len() as f64),
            unexplained: None,
        }
    }

    fn agreement(&self, view: &ScanView, simulated: &Simulated) -> Agreement {
        view.data.agreement(simulated.predicted(view), self.evidence.untouched(view))
    }

    /// Noise floor of each figure.
    fn floor(&self, simulated: &Simulated) -> WaterfallStep {
        let views = &self.evidence.views;
        let misfit = |view: &'a ScanView| Some(self.agreement(view, simulated).floor);
        let volume = |view: &'a ScanView| {
            let volume = pass_volume(self.evidence, view, &|view| self.ground(view, simulated, Pose::Held))?;
            of_measured(volume.measured, [0.0, volume.uncertainty])
        };
        let slope = |view: &'a ScanView| Some(self.plateau(view, simulated, Pose::Held)?.slope_uncertainty);
        WaterfallStep {
            name: "noise floor".to_owned(),
            calibration: self.rms(Split::Calibration, misfit),
            evaluation: self.rms(Split::Evaluation, misfit),
            volume_errors: views.iter().map(volume).collect(),
            plateau_slope: rms(views.iter().filter_map(slope)),
            ..WaterfallStep::default()
        }
    }

    fn plateau(&self, view: &'a ScanView, simulated: &Simulated, pose: Pose) -> Option<super::track::PlateauFigures> {
        let trial = self.evidence.simulation.trials()[view.trial].trial;
        let ground = self.ground(view, simulated, pose)?;
        let plateau =
            ground.plateau(&trial.scans.before, &trial.passes[view.pass], self.evidence.noise[view.trial].floor.rms);
        ground.figures(&plateau)
    }

    fn rms(&self, split: Split, misfit: impl Fn(&'a ScanView) -> Option<f64>) -> Option<f64> {
        rms(self.evidence.of(split).filter_map(misfit))
    }
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// An error of a volume and its uncertainty as shares of the measured volume; `None` where none was removed.
pub(crate) fn of_measured(measured: f64, [error, uncertainty]: [f64; 2]) -> Option<(f64, f64)> {
    (measured != 0.0).then(|| (error / measured.abs(), uncertainty / measured.abs()))
}
