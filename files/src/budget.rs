//! Budget shared by concurrent jobs.

use std::sync::{Condvar, Mutex, PoisonError};

/// A shared amount, such as a memory budget; a job waits until its share is free.
pub struct Budget {
    most: f64,
    used: Mutex<f64>,
    freed: Condvar,
}

/// A share of a budget, released when dropped.
pub struct Reservation<'a> {
    budget: &'a Budget,
    amount: f64,
}

impl Budget {
    /// A budget of a size.
    pub fn new(most: f64) -> Self {
        Self { most, used: Mutex::new(0.0), freed: Condvar::new() }
    }

    /// Waits for a share; a job that runs alone always gets it.
    pub fn reserve(&self, amount: f64) -> Reservation<'_> {
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = |used: &mut f64| *used > 0.0 && *used + amount > self.most;
        let mut used = self.freed.wait_while(used, is_full).unwrap_or_else(PoisonError::into_inner);
        *used += amount;
        Reservation { budget: self, amount }
    }
}

impl Drop for Reservation<'_> {
    fn drop(&mut self) {
        *self.budget.used.lock().unwrap_or_else(PoisonError::into_inner) -= self.amount;
        self.budget.freed.notify_all();
    }
}
