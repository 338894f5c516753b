//! The plateau that a tool leaves along its path: where it took off most of each section.

use sdf_bake::PixelGrid;

/// Share of a section's greatest removal from which a pixel belongs to the plateau.
const PLATEAU: f64 = 0.5;
/// Fewest pixels of a section that make a plateau.
const LEAST_PIXELS: usize = 4;

/// Which way sections run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Along x, for a path along y.
    X,
    /// Along y, for a path along x.
    Y,
}

/// The pixels of a plateau, section by section.
#[derive(Clone, Debug, PartialEq)]
pub struct Plateau {
    pixels: PixelGrid,
    across: Across,
    sections: Vec<Vec<usize>>,
}

/// Finds the plateau of a pass.
///
/// - `removed`: depth removed at each pixel [m], NaN where it is not known
/// - `least`: depth below which nothing counts as removed [m]
pub fn plateau_pixels(pixels: PixelGrid, removed: &[f64], least: f64, across: Across) -> Plateau {
    let section = |line: Vec<usize>| {
        let most = line.iter().map(|&at| removed[at]).filter(|depth| depth.is_finite()).fold(0.0, f64::max);
        let keeps = |at: &usize| most > least && removed[*at] >= PLATEAU * most;
        line.into_iter().filter(keeps).collect::<Vec<usize>>()
    };
    let line = |k: usize| match across {
        Across::Y => (0..pixels.ny).map(|j| pixels.at(k, j)).collect::<Vec<usize>>(),
        Across::X => (0..pixels.nx).map(|i| pixels.at(i, k)).collect(),
    };
    let lines = if across == Across::Y { pixels.nx } else { pixels.ny };
    let sections = (0..lines).map(|k| section(line(k))).filter(|section| section.len() >= LEAST_PIXELS).collect();
    Plateau { pixels, across, sections }
}

impl Plateau {
    /// Whether no section has one.
    pub fn is_empty(&self) -> bool {
        self.sections.is_empty()
    }

    /// Whether a pixel belongs to it.
    pub fn holds(&self, at: usize) -> bool {
        self.sections.iter().any(|section| section.contains(&at))
    }

    fn place(&self, at: usize) -> f64 {
        let place = self.pixels.position(at % self.pixels.nx, at / self.pixels.nx);
        if self.across == Across::Y { place.y } else { place.x }
    }

    /// Weights whose sum over a map is the mean over the plateau: pixel and weight, of the pixels that `knows` takes.
    pub fn mean_weights(&self, knows: impl Fn(usize) -> bool) -> Vec<(usize, f64)> {
        let known: Vec<usize> = self.sections.iter().flatten().copied().filter(|&at| knows(at)).collect();
        let weight = 1.0 / known.len() as f64;
        known.into_iter().map(|at| (at, weight)).collect()
    }

    /// Weights whose sum over a map is the slope across the path [1/m], the same in all sections, whose heights may
    /// differ: least squares.
    pub fn slope_weights(&self, knows: impl Fn(usize) -> bool) -> Vec<(usize, f64)> {
        let mut weights = Vec::new();
        for section in &self.sections {
            let known: Vec<usize> = section.iter().copied().filter(|&at| knows(at)).collect();
            let middle = known.iter().map(|&at| self.place(at)).sum::<f64>() / known.len().max(1) as f64;
            weights.extend(known.into_iter().map(|at| (at, self.place(at) - middle)));
        }
        let square: f64 = weights.iter().map(|(_, arm)| arm * arm).sum();
        weights.iter_mut().for_each(|(_, arm)| *arm /= square);
        weights
    }
}
