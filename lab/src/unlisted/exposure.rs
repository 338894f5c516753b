//! Exposure of each place to every variable: its mean weighted with the removal, pass by pass.
//!
//! The simulator itself evaluates the formulas: each is a state of the workpiece's cells that grows by removal times
//! value. At unchanged contact a rate that changes by `g(v)` changes the surface by `∫ r g(v) dt`, about `g` of that
//! mean times the removed depth (the weak form; equations in `docs/unlisted-effects.md`).

use std::sync::Arc;

use effects::{CompiledModel, Library, Model, Process, check_file};
use glam::DVec2;
use rayon::prelude::*;
use sdf_bake::PixelGrid;

use super::action::{ACTIONS, Action};
use super::columns::columns;
use super::variables::{Variable, known};
use crate::criteria::COLUMN_VARIABLES_MOST;
use crate::diagnose::with_values;
use crate::evidence::{Evidence, EvidenceError, Split};
use crate::fit::Fit;
use crate::scans::ScanEvidence;
use crate::simulated::Simulated;
use trial_simulation::SimulatedPass;

/// Name of the effect that accumulates sums and changes nothing.
const WATCH: &str = "exposure-sums";

/// A pass at the pixels of its trial's scan.
pub(crate) struct PassExposure {
    /// Depth [m], or dose, that each of [`ACTIONS`] removes per typical size.
    pub removed: Vec<Vec<f64>>,
    /// Mean of each of [`Exposures::variables`] over the removal [SI], NaN where nothing was removed.
    pub means: Vec<Vec<f64>>,
}

/// All passes of a campaign, by trial.
pub(crate) struct Exposures {
    /// Passes of each trial.
    pub passes: Vec<Vec<PassExposure>>,
    /// All variables: the common ones, and the columns of this campaign.
    pub variables: Vec<Arc<Variable>>,
    /// The model's simulation.
    pub simulated: Simulated,
}

impl Exposures {
    /// Simulates a fitted model once and accumulates all formulas.
    ///
    /// Returns `None` for a model whose laws are not the library's, or that has too many states of its own for the
    /// sums.
    ///
    /// # Errors
    /// If it cannot be simulated.
    pub(crate) fn new(
        evidence: &ScanEvidence,
        (model, fit): (&Model, &Fit),
        library: &Library,
    ) -> Result<Option<Self>, EvidenceError> {
        let variables = variables(evidence);
        let file = (format!("{WATCH}.toml"), watch(evidence.process(), &variables));
        let Ok(library) = library.with(&[file]) else { return Ok(None) };
        let model = with_values(model, fit).with(WATCH);
        let Ok(model) = CompiledModel::new(&model, &library, evidence.rows()) else { return Ok(None) };
        let simulated = Simulated::all(evidence, &[&model])?.remove(0);
        let trials = simulated.passes.par_iter().enumerate();
        let passes = trials
            .map(|(trial, passes)| passes.iter().map(|pass| exposure((evidence, trial), pass, &variables)).collect());
        Ok(Some(Self { passes: passes.collect(), variables: variables.clone(), simulated }))
    }
}

/// The common variables and the columns of this campaign, as many as fit into one simulation.
fn variables(evidence: &ScanEvidence) -> Vec<Arc<Variable>> {
    let is_readable = |column: &Variable| {
        let text = watch(evidence.process(), &[Arc::new(column.clone())]);
        check_file(&format!("{WATCH}.toml"), &text).is_ok()
    };
    let columns = columns(evidence).into_iter().filter(is_readable).take(COLUMN_VARIABLES_MOST);
    known().into_iter().chain(columns.map(Arc::new)).collect()
}

/// Formulas that are summed: the removal by each action's typical size, then the removal times each variable.
fn sums(process: Process, variables: &[Arc<Variable>]) -> Vec<String> {
    let removal = Action::Rate.sensitivity(process).expect("the contact removes");
    let actions = ACTIONS.iter().map(|action| action.sensitivity(process).unwrap_or_else(|| format!("0 * {removal}")));
    actions.chain(variables.iter().map(|variable| format!("{removal} * ({})", variable.formula))).collect()
}

/// The effect file of the sums.
fn watch(process: Process, variables: &[Arc<Variable>]) -> String {
    let rate = Action::Rate.sensitivity(process).expect("the contact removes");
    let sum = |(number, formula): (usize, &String)| {
        format!("[state.sum_{number}]\nper = \"workpiece_cell\"\nrate = \"{formula}\"\n")
    };
    let states: String = variables.iter().map(|variable| &*variable.state).collect();
    let sums: String = sums(process, variables).iter().enumerate().map(sum).collect();
    format!(
        "name = \"{WATCH}\"\ntitle = \"Sums of what each place meets\"\nsource = \"none\"\nsignature = \"nothing\"\n\
         confused_with = []\n\n[parameters.none]\nsymbol = \"n\"\nunit = \"1\"\nnull = 0.0\nrange = [0.0, 1.0]\n\
         default = 0.0\nfree = false\nabout = \"nothing\"\n\n{states}{sums}\n[modify]\n{rate} = \"{rate} * (1 + none)\"\n"
    )
}

fn exposure(
    (evidence, trial): (&ScanEvidence, usize),
    pass: &SimulatedPass,
    variables: &[Arc<Variable>],
) -> PassExposure {
    let covariates = pass.covariates.as_ref().expect("the simulation is watched");
    let pixels = &evidence.simulation.trials()[trial].trial.scans.before.pixels;
    let known = |value: &f64| if value.is_finite() { *value } else { 0.0 };
    let summed = |sum: &Vec<f64>| -> Vec<f64> {
        covariates.at(pixels, &sum.iter().map(known).collect::<Vec<f64>>()).iter().map(known).collect()
    };
    let first = covariates.states.len() - variables.len();
    let mut removed: Vec<Vec<f64>> = covariates.states[first - ACTIONS.len()..first].iter().map(summed).collect();
    let total = removed[0].clone();
    let mean = |(sum, variable): (&Vec<f64>, &Arc<Variable>)| -> Vec<f64> {
        let place = |at: usize| pixels.position(at % pixels.nx, at / pixels.nx);
        match &*variable.formula {
            // The place is also known without removal.
            "x" => (0..pixels.len()).map(|at| place(at).x).collect(),
            "y" => (0..pixels.len()).map(|at| place(at).y).collect(),
            _ => summed(sum).iter().zip(&total).map(|(sum, total)| sum / total).collect(),
        }
    };
    let means: Vec<Vec<f64>> = covariates.states[first..].iter().zip(variables).map(mean).collect();
    for (action, removed) in ACTIONS.iter().zip(&mut removed) {
        let typical = action.typical();
        match action {
            Action::Offset => {
                let across = variables.iter().position(|variable| variable.formula == "tool_y").expect("a variable");
                *removed = moved(&total, &means[across], pixels).iter().map(|change| typical * change).collect();
            }
            Action::Height => removed.fill(-typical),
            _ => {}
        }
    }
    PassExposure { removed, means }
}

/// Change of the removal at each pixel per displacement [m] of the tool along its y axis: its slope over the place on
/// the tool.
///
/// - `across`: place along the tool's y axis at each pixel [m]
fn moved(removed: &[f64], across: &[f64], pixels: &PixelGrid) -> Vec<f64> {
    let slope = |of: &[f64], at: usize, step: usize| match (at.checked_sub(step), of.get(at + step)) {
        (Some(low), Some(high)) => (high - of[low]) / (2.0 * pixels.pitch),
        _ => 0.0,
    };
    let gradient = |of: &[f64], at: usize| DVec2::new(slope(of, at, 1), slope(of, at, pixels.nx));
    let along = |at: &usize| Some(gradient(across, *at)).filter(|way| way.is_finite());
    let axis = (0..pixels.len()).filter_map(|at| along(&at)).sum::<DVec2>().normalize_or_zero();
    (0..pixels.len()).map(|at| -gradient(removed, at).dot(axis)).collect()
}

/// Values of a variable in all passes of the calibration scans with the depth removed there, in ascending order of the
/// value.
pub(crate) fn distribution(evidence: &ScanEvidence, exposures: &Exposures, variable: usize) -> Vec<(f64, f64)> {
    let mut all = Vec::new();
    for view in evidence.of(Split::Calibration) {
        let pass = &exposures.passes[view.trial][view.pass];
        let pixels = view.data.tiles().pixels().map(|(_, at)| (pass.means[variable][at], pass.removed[0][at]));
        all.extend(pixels.filter(|(value, removed)| value.is_finite() && *removed > 0.0));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}
