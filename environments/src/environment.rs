//! One environment: a tool on a workpiece, moved by actions.

use std::ops::Range;
use std::sync::Arc;

use effects::{CompiledModel, Signal, States};
use glam::DQuat;
use random::Stream;
use robot::{Controller, Tool};
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sim::{Pass, PassError, PassRecord, PassSettings, Path, PathSample, TOOL_CELLS, Underway, run_stretch};

use crate::action::{ACTION, Limits, Stance};
use crate::metrics::Metrics;
use crate::observation::Observation;
use crate::randomisation::Randomisation;
use crate::reward::{cost, is_done, is_spoilt};
use crate::strip::Strip;
use crate::task::Task;

/// Height of the tool above the weld at the start of a pass [m].
const CLEARANCE: f64 = 2e-4;
/// Reward lost to elapsed time over a whole episode [1].
const TIME_PENALTY: f64 = 0.1;
/// Assumed greatest depth of the tool in the surface [m]; the changed stretch of surface follows from it.
const SINK: f64 = 3e-4;
/// Default time for sanding, in travels to and fro at a tenth of the greatest feed [1].
const SANDINGS: f64 = 2.0;

/// Settings that all environments of a batch share.
#[derive(Clone)]
pub struct Setup {
    /// Tasks; one is drawn for each episode.
    pub tasks: Vec<Arc<Task>>,
    /// Tool of all environments.
    pub tool: Tool,
    /// Laws and effects before randomisation.
    pub model: Arc<CompiledModel>,
    /// Parameters drawn for each episode.
    pub randomisations: Vec<Randomisation>,
    /// Limits of actions.
    pub limits: Limits,
    /// Force controller.
    pub controller: Controller,
    /// Type of observation.
    pub observation: Observation,
    /// Duration of an episode [s]; by default it follows from the task.
    pub time_limit: Option<f64>,
}

/// Reward and end flags of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Reward: the fall of the cost, minus the share of elapsed time.
    pub reward: f64,
    /// True if the task is done or the part is spoilt.
    pub terminated: bool,
    /// True if the time is up.
    pub truncated: bool,
}

/// A tool on a workpiece.
pub struct Environment {
    pub(crate) setup: Arc<Setup>,
    pub(crate) task: Arc<Task>,
    pub(crate) model: Arc<CompiledModel>,
    pub(crate) part: Arc<BrickGrid>,
    pub(crate) strip: Strip,
    pub(crate) states: States,
    pub(crate) underway: Underway,
    pub(crate) stance: Stance,
    pub(crate) metrics: Metrics,
    /// Force at the end of the last step [N].
    pub(crate) force: f64,
    pub(crate) cost: f64,
    pub(crate) time_limit: f64,
    pub(crate) seed: u64,
    pub(crate) episode: u64,
    /// Number of passes so far; a pass begins when the tool comes down.
    pub(crate) passes: usize,
    /// Time since the current pass began [s].
    pub(crate) pass_time: f64,
    /// Integral of the squared error of the force in contact [N² s].
    pub(crate) squared_error: f64,
}

impl Environment {
    /// Makes an environment at the first episode of a seed.
    pub fn new(setup: Arc<Setup>, seed: u64) -> Self {
        let (task, model) = (setup.tasks[0].clone(), setup.model.clone());
        let mut environment = Self {
            part: Arc::new(BrickGrid::empty(task.part.voxel, task.part.band, task.part.origin, glam::IVec3::ZERO)),
            strip: task.strip.clone(),
            states: States::new(&model, TOOL_CELLS),
            underway: Underway::default(),
            stance: Stance::default(),
            metrics: Metrics::default(),
            force: 0.0,
            cost: 0.0,
            time_limit: 0.0,
            seed,
            episode: 0,
            passes: 0,
            pass_time: 0.0,
            squared_error: 0.0,
            setup,
            task,
            model,
        };
        environment.reset(Some(seed));
        environment
    }

    /// Begins the next episode, or the first one of a seed.
    pub fn reset(&mut self, seed: Option<u64>) {
        (self.seed, self.episode) = seed.map_or((self.seed, self.episode + 1), |seed| (seed, 0));
        let mut stream = Stream::of(self.seed, &format!("episode {}", self.episode));
        let Setup { tasks, model, randomisations, time_limit, .. } = &*self.setup;
        self.task = tasks[stream.below(tasks.len())].clone();
        self.model = model.clone();
        if !randomisations.is_empty() {
            let drawn = Arc::make_mut(&mut self.model);
            randomisations.iter().for_each(|randomisation| randomisation.draw(drawn, &mut stream));
        }
        self.time_limit = time_limit.unwrap_or_else(|| self.usual_time());
        self.part = Arc::new(self.fresh_part());
        self.strip = self.task.strip.clone();
        self.states = States::new(&self.model, TOOL_CELLS);
        (self.underway, self.stance, self.metrics) = Default::default();
        (self.force, self.pass_time, self.squared_error, self.passes) = (0.0, 0.0, 0.0, 0);
        self.cost = cost(&self.task, &self.strip);
        self.metrics.look(&self.task, &self.strip);
    }

    /// Returns a copy of the task's part. For photographs it records the removed depth, by which ground metal shines.
    fn fresh_part(&self) -> BrickGrid {
        let mut part = self.task.part.clone();
        if self.setup.observation == Observation::Rgb {
            part.scalar_or_zero(Scalar::Removed);
        }
        part
    }

    /// Returns the default time limit [s]: for grinding, twice the removal time at half the greatest force, plus one
    /// travel to and fro; for sanding, [`SANDINGS`].
    fn usual_time(&self) -> f64 {
        let limits = &self.setup.limits;
        let way = 2.0 * self.task.curve.length() / limits.feed;
        match self.model.law_value("grind_rate") {
            Some(rate) if self.task.process.signal() == Signal::Height => {
                2.0 * self.task.volume / (rate * 0.5 * limits.force) + way
            }
            _ => 10.0 * SANDINGS * way,
        }
    }

    /// Returns the metrics of the episode so far.
    pub fn metrics(&self) -> &Metrics {
        &self.metrics
    }

    /// Returns the workpiece.
    pub fn part(&self) -> &Arc<BrickGrid> {
        &self.part
    }

    /// Writes the observation.
    pub fn observe(&self, out: &mut [f32]) {
        self.setup.observation.look(self, out);
    }

    /// Does one step under an action.
    ///
    /// # Errors
    /// Those of [`run_stretch`].
    pub fn step(&mut self, action: &[f32; ACTION]) -> Result<Outcome, PassError> {
        let period = self.setup.limits.period;
        let (before, room) = (self.stance, (&self.task.curve, 0.5 * self.task.weld.width));
        self.stance = before.after(action, &self.setup.limits, room);
        if self.stance.setpoint > 0.0 {
            let record = self.press(&before)?;
            self.count(&record);
            let touched = self.touched(&before);
            self.strip.measure(&self.part, touched);
            self.metrics.look(&self.task, &self.strip);
        } else {
            self.lift();
        }
        self.metrics.time += period;
        let last = std::mem::replace(&mut self.cost, cost(&self.task, &self.strip));
        let reward = last - self.cost - TIME_PENALTY * period / self.time_limit;
        self.metrics.total += reward;
        Ok(Outcome {
            reward,
            terminated: is_done(&self.task, &self.strip) || is_spoilt(&self.strip),
            truncated: self.metrics.time > self.time_limit - 0.5 * period,
        })
    }

    /// Presses the tool while it moves to the stance.
    fn press(&mut self, before: &Stance) -> Result<PassRecord, PassError> {
        let Setup { tool, limits, controller, .. } = &*self.setup;
        if self.pass_time == 0.0 {
            self.passes += 1;
        }
        let until = self.pass_time + limits.period;
        let places = [(before, self.pass_time), (&self.stance, until)];
        let samples = places.map(|(stance, time)| self.sample(stance, time)).to_vec();
        let path = Path::from_samples(samples).expect("times that increase");
        let settings =
            PassSettings { controller: *controller, force_setpoint: self.stance.setpoint, ..PassSettings::default() };
        let trial_time = self.metrics.time - self.pass_time;
        let pass = Pass { number: self.passes, trial_time, ..Pass::first(tool, &path, &settings, &self.model) };
        let part = Arc::make_mut(&mut self.part);
        let record = run_stretch(part, pass, &mut self.states, (&mut self.underway, until))?;
        self.underway.settle(part);
        self.pass_time = until;
        Ok(record)
    }

    /// Lifts the tool, which ends the pass.
    fn lift(&mut self) {
        self.underway = Underway::default();
        (self.pass_time, self.force) = (0.0, 0.0);
    }

    /// Returns the path's sample of a stance, at the crown of the weld; the controller moves down from there.
    fn sample(&self, stance: &Stance, time: f64) -> PathSample {
        let station = self.task.curve.at(stance.arc);
        let level = CLEARANCE + if self.task.process.signal() == Signal::Height { self.task.weld.height } else { 0.0 };
        let turn =
            DQuat::from_axis_angle(station.tangent, stance.roll) * DQuat::from_axis_angle(station.side(), stance.pitch);
        let approach = turn * station.normal;
        let position = station.position + station.side() * stance.offset + station.normal * level;
        PathSample { time, position, approach, axis: turn * station.side() }
    }

    fn count(&mut self, record: &PassRecord) {
        self.force = record.log.last().map_or(0.0, |row| row.force);
        self.metrics.removed_volume += record.removed_volume;
        self.squared_error += record.force_rms_error.powi(2) * record.contact_time;
        self.metrics.contact_time += record.contact_time;
        if self.metrics.contact_time > 0.0 {
            self.metrics.force_error = (self.squared_error / self.metrics.contact_time).sqrt();
        }
    }

    /// Returns the stations whose surface the tool may have changed in a step.
    fn touched(&self, before: &Stance) -> Range<usize> {
        let (reach, _) = self.setup.tool.half_footprint(SINK);
        let (pitch, stations) = (self.task.curve.pitch(), self.strip.shape()[0]);
        let low = (before.arc.min(self.stance.arc) - reach) / pitch;
        let high = (before.arc.max(self.stance.arc) + reach) / pitch;
        (low.max(0.0) as usize).min(stations)..(high.ceil() as usize + 1).min(stations)
    }
}
