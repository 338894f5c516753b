//! Many environments, stepped together over threads.

use std::sync::Arc;

use rayon::prelude::*;

use crate::action::ACTION;
use crate::environment::{Environment, Outcome, Setup};
use crate::error::EnvironmentError;
use crate::metrics::METRICS;

/// Environments of one setup. An environment whose episode has ended begins the next one in the following step, and
/// ignores that step's action.
pub struct Batch {
    environments: Vec<Environment>,
    ended: Vec<bool>,
    size: usize,
}

/// Output arrays of a batch, one row for each environment.
pub struct Outputs<'a> {
    /// Observations, shape `[environments, ...]`.
    pub observations: &'a mut [f32],
    /// Rewards of the step, shape `[environments]`.
    pub rewards: &'a mut [f64],
    /// True where the task is done or the part is spoilt, shape `[environments]`.
    pub terminated: &'a mut [bool],
    /// True where the time is up, shape `[environments]`.
    pub truncated: &'a mut [bool],
    /// Metrics of the episodes so far, shape `[environments, METRICS]`.
    pub metrics: &'a mut [f64],
}

impl Batch {
    /// Makes `count` environments with consecutive seeds.
    ///
    /// # Errors
    /// If there are no environments or no tasks.
    pub fn new(setup: Setup, count: usize, seed: u64) -> Result<Self, EnvironmentError> {
        if count == 0 || setup.tasks.is_empty() {
            return Err(EnvironmentError::None(if count == 0 { "environments" } else { "tasks" }));
        }
        let (size, setup) = (setup.observation.size(), Arc::new(setup));
        let make = |k: usize| Environment::new(setup.clone(), seed.wrapping_add(k as u64));
        let environments = (0..count).into_par_iter().map(make).collect();
        Ok(Self { environments, ended: vec![false; count], size })
    }

    /// Returns the environments.
    pub fn environments(&self) -> &[Environment] {
        &self.environments
    }

    /// Returns one environment, to restore a snapshot.
    ///
    /// # Panics
    /// If there is no environment of this number.
    pub fn environment_mut(&mut self, number: usize) -> &mut Environment {
        self.ended[number] = false;
        &mut self.environments[number]
    }

    /// Begins an episode in each environment of a mask: the first one of a seed if one is given, else the next one.
    /// Writes all observations.
    ///
    /// # Errors
    /// If the arrays do not have the expected sizes.
    pub fn reset(
        &mut self,
        (seeds, mask): (&[Option<u64>], &[bool]),
        observations: &mut [f32],
    ) -> Result<(), EnvironmentError> {
        let count = self.environments.len();
        check("seeds", seeds.len(), count)?;
        check("mask", mask.len(), count)?;
        check("observations", observations.len(), count * self.size)?;
        let all = self.environments.par_iter_mut().zip(&mut self.ended).zip(observations.par_chunks_mut(self.size));
        all.enumerate().for_each(|(k, ((environment, ended), seen))| {
            if mask[k] {
                environment.reset(seeds[k]);
                *ended = false;
            }
            environment.observe(seen);
        });
        Ok(())
    }

    /// Steps all environments under actions, shape `[environments, ACTION]`.
    ///
    /// # Errors
    /// If the arrays do not have the expected sizes, or the error of the first pass that failed.
    pub fn step(&mut self, actions: &[f32], out: &mut Outputs) -> Result<(), EnvironmentError> {
        let count = self.environments.len();
        check("actions", actions.len(), count * ACTION)?;
        check("observations", out.observations.len(), count * self.size)?;
        check("rewards", out.rewards.len(), count)?;
        check("terminated", out.terminated.len(), count)?;
        check("truncated", out.truncated.len(), count)?;
        check("metrics", out.metrics.len(), count * METRICS.len())?;
        let (actions, _) = actions.as_chunks::<ACTION>();
        let (metrics, _) = out.metrics.as_chunks_mut::<{ METRICS.len() }>();
        let steps = self.environments.par_iter_mut().zip(&mut self.ended).zip(actions);
        let rows = steps.zip(out.observations.par_chunks_mut(self.size)).zip(metrics).enumerate();
        let outcomes: Vec<Outcome> = rows
            .map(|(k, ((((environment, ended), action), seen), figures))| {
                let outcome = match std::mem::take(ended) {
                    true => {
                        environment.reset(None);
                        Outcome::default()
                    }
                    false => {
                        environment.step(action).map_err(|error| EnvironmentError::Pass { environment: k, error })?
                    }
                };
                *ended = outcome.terminated || outcome.truncated;
                environment.observe(seen);
                *figures = environment.metrics().values();
                Ok(outcome)
            })
            .collect::<Result<_, EnvironmentError>>()?;
        for (k, outcome) in outcomes.into_iter().enumerate() {
            (out.rewards[k], out.terminated[k], out.truncated[k]) =
                (outcome.reward, outcome.terminated, outcome.truncated);
        }
        Ok(())
    }
}

fn check(name: &'static str, found: usize, expected: usize) -> Result<(), EnvironmentError> {
    if found == expected { Ok(()) } else { Err(EnvironmentError::Size { name, found, expected }) }
}
