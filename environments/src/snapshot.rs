//! State of an environment at one moment.

use std::sync::Arc;

use effects::{CompiledModel, States};
use sdf_bake::BrickGrid;
use sim::Underway;

use crate::action::Stance;
use crate::environment::Environment;
use crate::metrics::Metrics;
use crate::strip::Strip;
use crate::task::Task;

/// State of an environment at one moment; the workpiece is shared until it changes. Continuing from it gives the same
/// bytes.
pub struct Snapshot {
    task: Arc<Task>,
    model: Arc<CompiledModel>,
    part: Arc<BrickGrid>,
    strip: Strip,
    states: States,
    underway: Underway,
    stance: Stance,
    metrics: Metrics,
    /// Force, cost, time limit, time in the pass, integral of the squared force error.
    figures: [f64; 5],
    seed: u64,
    episode: u64,
    passes: usize,
}

impl Environment {
    /// Returns the current state.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            task: self.task.clone(),
            model: self.model.clone(),
            part: self.part.clone(),
            strip: self.strip.clone(),
            states: self.states.clone(),
            underway: self.underway.copy(),
            stance: self.stance,
            metrics: self.metrics,
            figures: [self.force, self.cost, self.time_limit, self.pass_time, self.squared_error],
            seed: self.seed,
            episode: self.episode,
            passes: self.passes,
        }
    }

    /// Restores a state.
    pub fn restore(&mut self, snapshot: &Snapshot) {
        self.task = snapshot.task.clone();
        self.model = snapshot.model.clone();
        self.part = snapshot.part.clone();
        self.strip = snapshot.strip.clone();
        self.states = snapshot.states.clone();
        self.underway = snapshot.underway.copy();
        (self.stance, self.metrics) = (snapshot.stance, snapshot.metrics);
        [self.force, self.cost, self.time_limit, self.pass_time, self.squared_error] = snapshot.figures;
        (self.seed, self.episode, self.passes) = (snapshot.seed, snapshot.episode, snapshot.passes);
    }
}
