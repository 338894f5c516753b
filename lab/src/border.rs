//! Border between exposed and unexposed pixels as a set of points, and the distance of other places from it.

use glam::DVec2;
use sdf_bake::PixelGrid;

/// Border of the region in which a field is positive.
#[derive(Clone, Debug)]
pub struct Border {
    places: Vec<DVec2>,
}

/// A place relative to a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderDistance {
    /// Signed distance to the border [m], positive where the field is.
    pub distance: f64,
    /// Direction in which the distance increases; zero on the border and out of reach.
    pub away: DVec2,
    /// Nearest point of the border, if one is within reach.
    pub nearest: Option<DVec2>,
}

impl Border {
    /// Finds the zero crossings of a field between neighbouring pixels along x and y. The field has one value per
    /// pixel, NaN where it is unknown.
    pub fn new(field: &[f64], pixels: PixelGrid) -> Self {
        let mut places = Vec::new();
        for at in 0..field.len() {
            let (i, j) = (at % pixels.nx, at / pixels.nx);
            let next = [(i + 1 < pixels.nx, i + 1, j), (j + 1 < pixels.ny, i, j + 1)];
            for (_, i1, j1) in next.into_iter().filter(|(inside, _, _)| *inside) {
                let (a, b) = (field[at], field[pixels.at(i1, j1)]);
                if a.is_finite() && b.is_finite() && (a > 0.0) != (b > 0.0) {
                    places.push(pixels.position(i, j).lerp(pixels.position(i1, j1), a / (a - b)));
                }
            }
        }
        Self { places }
    }

    /// Number of pixel edges that the border crosses.
    pub fn crossings(&self) -> usize {
        self.places.len()
    }

    /// Locates a place, whose side is known, relative to the border; distances are clamped to `reach` [m].
    pub fn distance_from(&self, place: DVec2, is_above: bool, reach: f64) -> BorderDistance {
        let sign = if is_above { 1.0 } else { -1.0 };
        let nearest = self.places.iter().min_by(|a, b| a.distance_squared(place).total_cmp(&b.distance_squared(place)));
        let Some(nearest) = nearest.filter(|nearest| nearest.distance(place) < reach) else {
            return BorderDistance { distance: sign * reach, away: DVec2::ZERO, nearest: None };
        };
        let way = place - *nearest;
        BorderDistance { distance: sign * way.length(), away: sign * way.normalize_or_zero(), nearest: Some(*nearest) }
    }
}
