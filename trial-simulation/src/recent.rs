//! The latest result of a campaign's simulation: a fit often asks again for the model that it has just ended at.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use effects::CompiledModel;

use crate::simulation::SimulatedPass;

/// Passes of each trial.
type Passes = Vec<Vec<SimulatedPass>>;

/// The latest result with its model. It is only one, because the passes of a large scan take much memory.
#[derive(Default)]
pub(crate) struct Recent(Mutex<Option<(CompiledModel, Arc<Passes>)>>);

impl Recent {
    /// The first passes of each trial, if the latest result is of the same model and has them.
    ///
    /// - `passes`: number of passes of each trial
    /// - `groups`: trials that share a tool, so that each depends on all passes of those before it
    pub fn find(&self, model: &CompiledModel, passes: &[usize], groups: &[Range<usize>]) -> Option<Passes> {
        let (of, ran) = self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        let is_covered = |group: &Range<usize>| covers(&ran[group.clone()], &passes[group.clone()]);
        let holds = model.is_same(&of) && groups.iter().all(is_covered);
        holds.then(|| ran.iter().zip(passes).map(|(ran, count)| ran[..*count].to_vec()).collect())
    }

    /// Keeps a result in place of the one before. Maps of covariates are not kept: they are large, and asked for once.
    pub fn keep(&self, model: &CompiledModel, ran: &Passes) {
        if ran.iter().flatten().any(|pass| pass.covariates.is_some()) {
            return;
        }
        let latest = Some((model.clone(), Arc::new(ran.clone())));
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = latest;
    }

    /// Forgets a result with a pass of at least this many steps.
    pub fn forget_longer(&mut self, most: usize) {
        let latest = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        latest.take_if(|(_, ran)| ran.iter().flatten().any(|pass| pass.record.steps >= most));
    }
}

/// True if the trials of a group were simulated as far as asked, and those before the last one exactly as far.
fn covers(ran: &[Vec<SimulatedPass>], passes: &[usize]) -> bool {
    let last = passes.iter().rposition(|count| *count > 0).unwrap_or(0);
    let mut trials = ran.iter().map(Vec::len).zip(passes).enumerate();
    trials.all(|(k, (ran, count))| if k < last { ran == *count } else { ran >= *count })
}
