//! Trials planned by a user or a study, run after those of the laboratory's own plan.

use effects::{CompiledModel, Reset, States};
use glam::DVec2;
use sim::TOOL_CELLS;

use super::answer::TrueTrial;
use super::experiment_error::ExperimentError;
use super::motion::Route;
use super::trial_build::{PassCommand, TrialBuild};
use super::{Experiment, MakeError};
use trials::trial::{Pass, Trial};

impl Experiment {
    /// Makes the trials of [`Experiment::then`]; their true results are not recorded. A tool that is not fresh keeps
    /// its states from the trial before.
    pub(super) fn make_planned(
        &self,
        model: &CompiledModel,
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<(Trial, TrueTrial)>, MakeError> {
        let mut made = Vec::new();
        if self.then.is_empty() {
            return Ok(made);
        }
        let mut states = States::new(model, TOOL_CELLS);
        let settings = self.plan.settings(self.trials);
        if let Some(last) = self.trials.checked_sub(1) {
            self.run_one(model, (&settings, last), &mut states, &|| {})?;
        }
        let mut row = settings.iter().map(Vec::len).sum();
        for stages in &self.then {
            let mut build = TrialBuild::new(self, model, self.trials + made.len())?;
            for stage in stages {
                build.goes_on_as(format!("trial-{}", self.trials + made.len() + 1));
                let trial = build.follow(stage, (&mut states, row), done)?;
                row += trial.passes.len();
                made.push((trial, TrueTrial::default()));
            }
        }
        Ok(made)
    }
}

impl TrialBuild<'_> {
    /// Runs a planned trial with a tool of given `states`.
    ///
    /// - `row`: number of earlier passes of the campaign
    fn follow(
        &mut self,
        planned: &Trial,
        (states, row): (&mut States, usize),
        done: &(dyn Fn() + Sync),
    ) -> Result<Trial, ExperimentError> {
        let scans = self.scans()?;
        if planned.fresh {
            states.reset(self.model(), Reset::FreshTool);
        }
        states.reset(self.model(), Reset::Trial);
        let (mut passes, mut end): (Vec<Pass>, Option<[f64; 2]>) = (Vec::new(), None);
        for (number, pass) in planned.passes.iter().enumerate() {
            let at = (number + 1, row + number);
            let order = ordered(pass);
            let rows = &pass.log.rows;
            let (first, last) = (rows[0].time, rows[rows.len() - 1].time);
            // A clock that is reset gives no pause.
            let pause = end.map_or(0.0, |[planned, _]| f64::max(first - planned, 0.0));
            if pause > 0.0 {
                self.pause((&order, pause), states, at)?;
            }
            let (mut made, _) = self.made(&order, states, at)?;
            if let Some([_, end]) = end.filter(|_| pause > 0.0) {
                made.log.rows.iter_mut().for_each(|row| row.time += end + pause);
            }
            end = made.log.rows.last().map(|row| [last, row.time]);
            passes.push(made);
            done();
        }
        Ok(Trial { fresh: planned.fresh, ..self.trial(scans, passes) })
    }
}

/// Command for a planned pass: the route of its rows in contact.
fn ordered(pass: &Pass) -> PassCommand {
    let pressed = pass.log.rows.iter().filter(|row| row.force > 0.0);
    let places: Vec<(f64, DVec2)> = pressed.map(|row| (row.time, row.position.truncate())).collect();
    PassCommand { way: Route::logged(&places), force_setpoint: pass.force_setpoint, spindle_speed: pass.spindle_speed }
}
