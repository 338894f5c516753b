//! The pixels at which a surface without pixels of its own is sampled.

use glam::DVec2;
use sdf_bake::PixelGrid;

use super::{MOST_PIXELS, Source};
use crate::misread::{Misread, Place};

/// Tolerance of a surface's end at the last pixel [pixels].
const LAST_PIXEL: f64 = 1e-6;

/// The rectangle covered by a surface, seen from above.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Lowest x and y [m].
    low: DVec2,
    /// Highest x and y [m].
    high: DVec2,
    /// Number of points of the surface.
    points: usize,
}

impl Extent {
    /// The extent of positions [m] that represent a number of points spread evenly over it.
    pub(super) fn of(places: impl Iterator<Item = DVec2>, points: usize) -> Self {
        let nothing = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = places.fold(nothing, |(low, high), place| (low.min(place), high.max(place)));
        Self { low, high, points }
    }

    /// The pixels of the source's window. Without a pitch, there are as many pixels as points; without an origin, the
    /// first pixel is the surface's lowest corner; without a shape, pixels extend to its end.
    ///
    /// # Errors
    /// [`Misread`] if the surface lies outside the window, or there are too many pixels.
    pub(super) fn pixels(&self, source: &Source) -> Result<PixelGrid, Misread> {
        let span = self.high - self.low;
        let window = source.window;
        let pitch = window.pitch.unwrap_or_else(|| (span.x * span.y / self.points.max(1) as f64).sqrt());
        let origin = window.origin.unwrap_or(self.low);
        let last = (self.high - origin) / pitch + LAST_PIXEL;
        if !(pitch > 0.0 && last.cmpge(DVec2::ZERO).all() && last.max_element() < MOST_PIXELS as f64) {
            return Err(self.beside(source));
        }
        let (nx, ny) = window.shape.unwrap_or((last.x as usize + 1, last.y as usize + 1));
        if nx.saturating_mul(ny) > MOST_PIXELS {
            let accepted = format!("at most {MOST_PIXELS} are expected");
            return Err(Place::file(source.file).bad(format!("{nx} x {ny} pixels"), accepted));
        }
        Ok(PixelGrid { origin, pitch, nx, ny })
    }

    /// An error for a surface outside the window.
    pub(super) fn beside(&self, source: &Source) -> Misread {
        let (low, high) = (self.low * 1e3, self.high * 1e3);
        let found = format!("the surface spans x {:.2} to {:.2} mm, y {:.2} to {:.2} mm", low.x, high.x, low.y, high.y);
        let accepted = match source.window.origin.map(|origin| origin * 1e3) {
            Some(DVec2 { x, y }) => format!("a surface over pixels from x {x:.2} mm, y {y:.2} mm on is expected"),
            None => "a surface with an area, seen from above, is expected".to_owned(),
        };
        Place::file(source.file).bad(found, accepted)
    }
}
