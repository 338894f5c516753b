//! How much may be baked at once.

use std::sync::{Condvar, Mutex, PoisonError};

/// A number of bricks that jobs share; a job waits until its share is free.
pub(super) struct Room {
    most: f64,
    used: Mutex<f64>,
    freed: Condvar,
}

/// A share of a room, free again when dropped.
pub(super) struct Share<'a> {
    room: &'a Room,
    bricks: f64,
}

impl Room {
    pub(super) fn new(most: f64) -> Self {
        Self { most, used: Mutex::new(0.0), freed: Condvar::new() }
    }

    /// Waits for room; a job alone always gets it.
    pub(super) fn share(&self, bricks: f64) -> Share<'_> {
        let used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = |used: &mut f64| *used > 0.0 && *used + bricks > self.most;
        let mut used = self.freed.wait_while(used, is_full).unwrap_or_else(PoisonError::into_inner);
        *used += bricks;
        Share { room: self, bricks }
    }
}

impl Drop for Share<'_> {
    fn drop(&mut self) {
        *self.room.used.lock().unwrap_or_else(PoisonError::into_inner) -= self.bricks;
        self.room.freed.notify_all();
    }
}
