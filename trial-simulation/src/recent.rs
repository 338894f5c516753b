//! The latest results of a campaign's simulation: a fit often asks again for the model that it has just ended at.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use effects::CompiledModel;

use crate::simulation::SimulatedPass;

/// Number of results that are kept; two threads that fit different models share them.
const KEPT: usize = 4;

/// Passes of each trial.
type Passes = Vec<Vec<SimulatedPass>>;

/// Results by model, the latest last.
#[derive(Default)]
pub(crate) struct Recent(Mutex<VecDeque<(CompiledModel, Arc<Passes>)>>);

impl Recent {
    /// The first passes of each trial as the same model made them, if its kept result has them.
    ///
    /// - `passes`: number of passes of each trial
    /// - `groups`: trials that share a tool, so that each depends on all passes of those before it
    pub fn find(&self, model: &CompiledModel, passes: &[usize], groups: &[Range<usize>]) -> Option<Passes> {
        let found = {
            let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let holds = |(other, ran): &&(CompiledModel, Arc<Passes>)| {
                model.is_same(other) && groups.iter().all(|group| covers(&ran[group.clone()], &passes[group.clone()]))
            };
            kept.iter().rev().find(holds)?.1.clone()
        };
        Some(found.iter().zip(passes).map(|(ran, count)| ran[..*count].to_vec()).collect())
    }

    /// Keeps a result, and forgets the oldest.
    pub fn keep(&self, model: &CompiledModel, ran: &Passes) {
        let entry = (model.clone(), Arc::new(ran.clone()));
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_back(entry);
        if kept.len() > KEPT {
            kept.pop_front();
        }
    }

    /// Forgets the results with a pass of at least this many steps.
    pub fn forget_longer(&mut self, most: usize) {
        let kept = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(_, ran)| ran.iter().flatten().all(|pass| pass.record.steps < most));
    }
}

/// True if the trials of a group were simulated as far as asked, and those before the last one exactly as far.
fn covers(ran: &[Vec<SimulatedPass>], passes: &[usize]) -> bool {
    let last = passes.iter().rposition(|count| *count > 0).unwrap_or(0);
    let mut trials = ran.iter().map(Vec::len).zip(passes).enumerate();
    trials.all(|(k, (ran, count))| if k < last { ran == *count } else { ran >= *count })
}
