//! The cells of a tool's working surface, for states that vary over it: bins across a wheel, rings of a disc.

use std::f64::consts::TAU;

use glam::DVec3;

use effects::{CompiledModel, Lanes, RunError, States, StepValues, Variable};
use robot::Tool;

/// Number of cells of every tool.
pub const COUNT: usize = 64;

/// The cells of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolCells {
    /// Coordinate at which the first cell begins [m].
    first: f64,
    /// Size of a cell [m].
    size: f64,
    /// Circumference of a wheel [m]; `None` for rings.
    circumference: Option<f64>,
}

impl ToolCells {
    /// The cells of a tool.
    pub fn of(tool: &Tool) -> Self {
        match tool {
            Tool::Wheel(wheel) => Self {
                first: -0.5 * wheel.width,
                size: wheel.width / COUNT as f64,
                circumference: Some(TAU * wheel.radius),
            },
            _ => Self { first: 0.0, size: tool.rim_radius() / COUNT as f64, circumference: None },
        }
    }

    /// Fractional index of a point of the tool's frame; an integer at a cell's middle.
    pub fn place(&self, at: DVec3) -> f64 {
        let coordinate = if self.circumference.is_some() { at.y } else { at.x.hypot(at.y) };
        ((coordinate - self.first) / self.size - 0.5).clamp(0.0, (COUNT - 1) as f64)
    }

    /// Coordinate of each cell's middle [m].
    pub fn middles(&self) -> Vec<f64> {
        (0..COUNT).map(|cell| self.first + (cell as f64 + 0.5) * self.size).collect()
    }

    /// Area of each cell of the tool's own surface [m²].
    pub fn face_areas(&self) -> Vec<f64> {
        let area = |middle: f64| self.circumference.unwrap_or(TAU * middle) * self.size;
        self.middles().into_iter().map(area).collect()
    }
}

/// A cell of the height field in contact, as input of the sums over tool cells.
pub struct CellLoad {
    /// Share of the cell in contact.
    pub share: f64,
    /// Mean pressure over the cell [Pa].
    pub load: f64,
    /// [m/s]
    pub slip_speed: f64,
    /// Mean recession speed [m/s].
    pub recession: f64,
    /// Mean dose per time [1/s].
    pub dose: f64,
    /// Area of the cell's surface [m²].
    pub surface: f64,
    /// Coating thickness [m].
    pub coating: f64,
}

/// Sums over the contact for each tool cell; a cell of the height field counts for the two tool cells whose middles it
/// lies between.
#[derive(Clone, Debug)]
pub struct CellSums {
    share: [f64; COUNT],
    pressure: [f64; COUNT],
    slip_speed: [f64; COUNT],
    rate: [f64; COUNT],
    dose_rate: [f64; COUNT],
    removal_rate: [f64; COUNT],
    dose_volume_rate: [f64; COUNT],
}

impl Default for CellSums {
    fn default() -> Self {
        let zero = [0.0; COUNT];
        Self {
            share: zero,
            pressure: zero,
            slip_speed: zero,
            rate: zero,
            dose_rate: zero,
            removal_rate: zero,
            dose_volume_rate: zero,
        }
    }
}

impl CellSums {
    /// Adds a height field cell at a fractional tool cell index.
    pub fn add(&mut self, place: f64, under: &CellLoad) {
        let first = place as usize;
        let fraction = place - first as f64;
        for (cell, weight) in [(first, 1.0 - fraction), ((first + 1).min(COUNT - 1), fraction)] {
            self.share[cell] += weight * under.share;
            self.pressure[cell] += weight * under.load;
            self.slip_speed[cell] += weight * under.share * under.slip_speed;
            self.rate[cell] += weight * under.recession;
            self.dose_rate[cell] += weight * under.dose;
            self.removal_rate[cell] += weight * under.recession * under.surface;
            self.dose_volume_rate[cell] += weight * under.dose * under.surface * under.coating;
        }
    }

    /// Turns sums over the height field's cells into means over the contact.
    pub fn means(mut self) -> Self {
        for values in [&mut self.pressure, &mut self.slip_speed, &mut self.rate, &mut self.dose_rate] {
            for (value, share) in values.iter_mut().zip(self.share) {
                *value = if share > 0.0 { *value / share } else { 0.0 };
            }
        }
        self
    }

    /// Advances the model's states by `dt` [s].
    ///
    /// # Errors
    /// A formula that gives no finite number.
    pub fn advance(
        &self,
        cells: &ToolCells,
        model: &CompiledModel,
        states: &mut States,
        at: (&StepValues, f64),
    ) -> Result<(), RunError> {
        let (middles, areas) = (cells.middles(), cells.face_areas());
        let lanes = Lanes::new(COUNT)
            .with(Variable::ToolY, &middles)
            .with(Variable::CellFaceArea, &areas)
            .with(Variable::Pressure, &self.pressure)
            .with(Variable::SlipSpeed, &self.slip_speed)
            .with(Variable::Rate, &self.rate)
            .with(Variable::DoseRate, &self.dose_rate)
            .with(Variable::CellRemovalRate, &self.removal_rate)
            .with(Variable::CellDoseVolumeRate, &self.dose_volume_rate);
        states.advance(model, at.1, at.0, &lanes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::{Pad, Wheel};

    #[test]
    fn cells_cover_the_working_surface() {
        let wheel = ToolCells::of(&Tool::from(Wheel::cylinder(0.05, 0.02)));
        assert!((wheel.face_areas().iter().sum::<f64>() - TAU * 0.05 * 0.02).abs() < 1e-12);
        assert!((wheel.place(DVec3::new(0.0, wheel.middles()[7], 0.0)) - 7.0).abs() < 1e-12);
        let pad = ToolCells::of(&Tool::from(Pad { radius: 0.025 }));
        assert!((pad.face_areas().iter().sum::<f64>() - 0.5 * TAU * 0.025 * 0.025).abs() < 1e-12);
        assert_eq!(pad.place(DVec3::ZERO), 0.0);
    }
}
