//! Queue of jobs, shared by the threads of this process and coordinated with other processes.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};

use crate::file_lock::LockWait;

/// Shared state of the threads.
struct QueueState<'a, T> {
    count: usize,
    next: AtomicUsize,
    /// Jobs that were locked by another process when their turn came.
    later: Mutex<Vec<usize>>,
    work: &'a (dyn Fn(usize, LockWait) -> Option<T> + Sync),
}

/// Runs the jobs `0..count` with `jobs` threads and calls `done` on this thread with each outcome, in order of
/// completion.
///
/// `work` returns `None` if another process holds the job and no waiting was requested. That job runs again at the end,
/// with unlimited waiting.
///
/// # Errors
/// The first error of `done`; jobs that have not started by then are skipped.
pub fn take_turns<T: Send, E>(
    count: usize,
    jobs: usize,
    work: impl Fn(usize, LockWait) -> Option<T> + Sync,
    mut done: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<(), E> {
    let turns = QueueState { count, next: AtomicUsize::new(0), later: Mutex::default(), work: &work };
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..jobs.min(count) {
            let (sender, turns) = (sender.clone(), &turns);
            scope.spawn(move || turns.take(&sender));
        }
        drop(sender);
        receiver.into_iter().try_for_each(|(turn, outcome)| done(turn, outcome))
    })
}

impl<T> QueueState<'_, T> {
    /// One thread: takes job after job, and at the end those of other processes, which have probably finished by then.
    fn take(&self, outcomes: &Sender<(usize, T)>) {
        let later = || self.later.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let turn = self.next.fetch_add(1, Ordering::Relaxed);
            let (turn, wait) = if turn < self.count {
                (turn, LockWait::None)
            } else {
                let Some(turn) = later().pop() else { return };
                (turn, LockWait::Endless)
            };
            let Some(outcome) = (self.work)(turn, wait) else {
                later().push(turn);
                continue;
            };
            // After an error in `done` the receiver is gone.
            if outcomes.send((turn, outcome)).is_err() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_turn_is_taken_once_and_the_impatient_ones_come_last() {
        let taken = Mutex::new(Vec::new());
        let work = |turn: usize, wait: LockWait| {
            if turn.is_multiple_of(5) && wait == LockWait::None {
                return None;
            }
            taken.lock().unwrap().push(turn);
            Some(2 * turn)
        };
        let mut outcomes = Vec::new();
        take_turns(50, 3, work, |turn, outcome| {
            assert_eq!(outcome, 2 * turn);
            outcomes.push(turn);
            Ok::<(), String>(())
        })
        .unwrap();
        outcomes.sort_unstable();
        assert_eq!(outcomes, (0..50).collect::<Vec<_>>());
        assert_eq!(taken.into_inner().unwrap().len(), 50);
    }

    #[test]
    fn an_error_ends_the_work_early() {
        let taken = AtomicUsize::new(0);
        let ended = take_turns(
            10_000,
            2,
            |turn, _| {
                taken.fetch_add(1, Ordering::Relaxed);
                std::thread::sleep(std::time::Duration::from_micros(50));
                Some(turn)
            },
            |_, _| Err("enough"),
        );
        assert!(ended.is_err());
        assert!(taken.into_inner() < 10_000);
    }
}
