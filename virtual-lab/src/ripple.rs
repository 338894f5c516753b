//! Ripple of the force: an effect of the robot that no library has, with random phases in each pass.

use std::f64::consts::TAU;

use effects::{CompiledModel, EffectError, Library, Model};

use random::Stream;

/// Name of the effect, and its file.
const NAME: &str = "force-ripple";
const FILE: (&str, &str) = ("force-ripple.toml", include_str!("force-ripple.toml"));
/// Phase parameters, and their frequencies relative to the slowest.
const WAVES: [(&str, f64); 3] = [("phase_slow", 1.0), ("phase_middle", 2.4), ("phase_fast", 5.6)];

/// The ripple in a pass.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ripple {
    swing: f64,
    /// Frequency of the slowest wave [Hz].
    frequency: f64,
    phases: [f64; WAVES.len()],
}

/// Adds a force ripple to a model.
///
/// - `swing`: standard deviation relative to the mean [1]
///
/// # Errors
/// If the library has an effect of this name.
pub(super) fn add(
    model: &mut Model,
    library: &Library,
    (swing, passes, seed): (f64, usize, u64),
) -> Result<Library, EffectError> {
    let library = library.with(&[(FILE.0.to_owned(), FILE.1.to_owned())])?;
    let mut stream = Stream::of(seed, NAME);
    model.effects.extend(Model::new(model.process).with(NAME).effects);
    model.set(NAME, "swing", &[swing]);
    for (phase, _) in WAVES {
        let phases: Vec<f64> = (0..passes).map(|_| stream.between([0.0, TAU])).collect();
        model.set(NAME, phase, &phases);
    }
    Ok(library)
}

impl Ripple {
    /// The ripple of a model in the pass with this row of parameters; `None` if it has none.
    pub(super) fn of(model: &CompiledModel, row: usize) -> Option<Self> {
        let value = |name: &str| {
            let own = model.parameters().iter().zip(model.values());
            let mut own = own.filter(|(slot, _)| slot.owner == NAME && slot.parameter == name);
            own.find(|(slot, _)| slot.row.is_none_or(|other| other == row)).map(|(_, &value)| value)
        };
        let phase = |(name, _): (&str, f64)| value(name).unwrap_or(0.0);
        Some(Self { swing: value("swing")?, frequency: value("frequency")?, phases: WAVES.map(phase) })
    }

    /// Force over its mean, minus one, at a time of the pass [s].
    pub(super) fn at(&self, time: f64) -> f64 {
        let waves = WAVES.iter().zip(self.phases);
        let sum: f64 = waves.map(|((_, ratio), phase)| (TAU * ratio * self.frequency * time + phase).sin()).sum();
        self.swing * (2.0 / WAVES.len() as f64).sqrt() * sum
    }
}

#[cfg(test)]
mod tests {
    use effects::{Process, RowCounts};

    use super::*;

    #[test]
    fn a_ripple_has_its_swing_and_other_phases_in_each_pass() {
        let mut model = Model::new(Process::Grinding);
        let library = add(&mut model, Library::builtin(), (0.1, 2, 5)).expect("the name is free");
        let rows = RowCounts { passes: 2, scans: 2 };
        let model = CompiledModel::new(&model, &library, rows).expect("a model");
        let [first, second] = [0, 1].map(|row| Ripple::of(&model, row).expect("a ripple"));
        assert_ne!(first.phases, second.phases);
        let square = (0..10_000).map(|k| first.at(1e-3 * f64::from(k)).powi(2)).sum::<f64>() / 1e4;
        assert!((square.sqrt() - 0.1).abs() < 2e-3, "{}", square.sqrt());
    }
}
