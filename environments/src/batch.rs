//! Many environments, stepped together over threads.

use std::sync::Arc;

use rayon::prelude::*;

use crate::action::ACTION;
use crate::environment::{Environment, Outcome, Setup};
use crate::error::EnvironmentError;
use crate::metrics::METRICS;

/// Environments of one setup. One whose episode has ended begins the next one in the step after, whose action it ignores.
pub struct Batch {
    environments: Vec<Environment>,
    ended: Vec<bool>,
    size: usize,
}

/// Where a batch writes what its environments came to, one row for each.
pub struct Outputs<'a> {
    /// Observations, shape `[environments, ...]`.
    pub observations: &'a mut [f32],
    /// Shape `[environments]`.
    pub rewards: &'a mut [f64],
    /// Shape `[environments]`.
    pub terminated: &'a mut [bool],
    /// Shape `[environments]`.
    pub truncated: &'a mut [bool],
    /// Figures of the episodes so far, shape `[environments, METRICS]`.
    pub metrics: &'a mut [f64],
}

impl Batch {
    /// So many environments, with seeds that follow each other.
    ///
    /// # Errors
    /// Without environments or tasks.
    pub fn new(setup: Setup, count: usize, seed: u64) -> Result<Self, EnvironmentError> {
        if count == 0 || setup.tasks.is_empty() {
            return Err(EnvironmentError::None(if count == 0 { "environments" } else { "tasks" }));
        }
        let (size, setup) = (setup.observation.size(), Arc::new(setup));
        let make = |k: usize| Environment::new(setup.clone(), seed.wrapping_add(k as u64));
        let environments = (0..count).into_par_iter().map(make).collect();
        Ok(Self { environments, ended: vec![false; count], size })
    }

    /// The environments.
    pub fn environments(&self) -> &[Environment] {
        &self.environments
    }

    /// One of them, to be put back.
    ///
    /// # Panics
    /// If there is none of this number.
    pub fn environment_mut(&mut self, number: usize) -> &mut Environment {
        self.ended[number] = false;
        &mut self.environments[number]
    }

    /// Begins an episode in those environments that a mask names: the first of a seed where one is given, else the next one.
    /// Writes all observations.
    ///
    /// # Errors
    /// Arrays that do not fit.
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
    /// Arrays that do not fit, or the first pass that failed.
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
