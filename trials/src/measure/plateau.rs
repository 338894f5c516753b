//! The plateau of a ground track: the pixels in which the tool removed most of each section.

use sdf_bake::PixelGrid;

/// Share of a section's greatest removal above which a pixel belongs to the plateau.
const PLATEAU: f64 = 0.5;
/// Minimum number of pixels of a section with a plateau.
const LEAST_PIXELS: usize = 4;

/// Direction of the sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SectionAxis {
    /// Along x, for a path along y.
    X,
    /// Along y, for a path along x.
    Y,
}

/// The pixels of a plateau, section by section.
#[derive(Clone, Debug, PartialEq)]
pub struct Plateau {
    pixels: PixelGrid,
    across: SectionAxis,
    sections: Vec<Vec<usize>>,
}

/// Finds the plateau of a pass.
///
/// - `removed`: removed depth at each pixel [m], NaN where it is unknown
/// - `least`: depth below which nothing counts as removed [m]
pub fn plateau_pixels(pixels: PixelGrid, removed: &[f64], least: f64, across: SectionAxis) -> Plateau {
    let section = |line: Vec<usize>| {
        let most = line.iter().map(|&at| removed[at]).filter(|depth| depth.is_finite()).fold(0.0, f64::max);
        let keeps = |at: &usize| most > least && removed[*at] >= PLATEAU * most;
        line.into_iter().filter(keeps).collect::<Vec<usize>>()
    };
    let line = |k: usize| match across {
        SectionAxis::Y => (0..pixels.ny).map(|j| pixels.at(k, j)).collect::<Vec<usize>>(),
        SectionAxis::X => (0..pixels.nx).map(|i| pixels.at(i, k)).collect(),
    };
    let lines = if across == SectionAxis::Y { pixels.nx } else { pixels.ny };
    let sections = (0..lines).map(|k| section(line(k))).filter(|section| section.len() >= LEAST_PIXELS).collect();
    Plateau { pixels, across, sections }
}

impl Plateau {
    /// Returns true if no section has a plateau.
    pub fn is_empty(&self) -> bool {
        self.sections.is_empty()
    }

    /// Returns true if a pixel belongs to the plateau.
    pub fn holds(&self, at: usize) -> bool {
        self.sections.iter().any(|section| section.contains(&at))
    }

    fn place(&self, at: usize) -> f64 {
        let place = self.pixels.position(at % self.pixels.nx, at / self.pixels.nx);
        if self.across == SectionAxis::Y { place.y } else { place.x }
    }

    /// Pixels and weights whose weighted sum over a map is the mean over the plateau, restricted to pixels that `knows`
    /// accepts.
    pub fn mean_weights(&self, knows: impl Fn(usize) -> bool) -> Vec<(usize, f64)> {
        let known: Vec<usize> = self.sections.iter().flatten().copied().filter(|&at| knows(at)).collect();
        let weight = 1.0 / known.len() as f64;
        known.into_iter().map(|at| (at, weight)).collect()
    }

    /// Weights whose sum over a map is the slope across the path [1/m], by least squares. The slope is common to all
    /// sections, their heights may differ.
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
