//! The border between what is exposed and what is not, as places, and how far others are from it.

use glam::DVec2;
use sdf_bake::PixelGrid;

/// The border of the pixels on which a field is above zero.
#[derive(Clone, Debug)]
pub struct Border {
    places: Vec<DVec2>,
}

/// A place seen from a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Distance to the border [m], above zero where the field is above zero.
    pub distance: f64,
    /// Direction in which the distance rises; zero on the border and out of reach.
    pub away: DVec2,
    /// The nearest place of the border, if one is in reach.
    pub nearest: Option<DVec2>,
}

impl Border {
    /// Where a field with one value per pixel, NaN where it is unknown, passes zero between a pixel and the next along x or y.
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

    /// A place, its side known, seen from the border; distances beyond `reach` [m] count as that.
    pub fn seen_from(&self, place: DVec2, is_above: bool, reach: f64) -> Seen {
        let sign = if is_above { 1.0 } else { -1.0 };
        let nearest = self.places.iter().min_by(|a, b| a.distance_squared(place).total_cmp(&b.distance_squared(place)));
        let Some(nearest) = nearest.filter(|nearest| nearest.distance(place) < reach) else {
            return Seen { distance: sign * reach, away: DVec2::ZERO, nearest: None };
        };
        let way = place - *nearest;
        Seen { distance: sign * way.length(), away: sign * way.normalize_or_zero(), nearest: Some(*nearest) }
    }
}
