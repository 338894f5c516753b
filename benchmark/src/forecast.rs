//! Stated probabilities, and their reliability.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::answer::{CaseAnswer, ExpectedAnswer};
use super::cases::Case;
use super::rate::Rate;

/// Bins of the reliability diagram.
const BINS: usize = 10;
/// Least probability that counts as a statement [1]: dozens of effects have almost none, and a correct zero is trivial.
const LEAST_STATED: f64 = 0.01;

/// Probabilities stated by a first search.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// Name and probability of each effect that was weighed.
    pub effects: Vec<(String, f64)>,
    /// Probability that the cause is no effect of the library.
    pub none: f64,
}

impl Forecast {
    /// Reads the answer of `diagnose --json`. If it states no probability of "none", that is 1 minus the sum over the
    /// effects.
    pub fn of(diagnosis: &Value) -> Self {
        let suspects = diagnosis["suspects"].as_array().map_or(&[][..], Vec::as_slice);
        let first = suspects.iter().filter(|suspect| suspect["search"].as_u64().unwrap_or(1) == 1);
        let stated = |suspect: &Value| {
            Some((suspect["name"].as_str()?.to_owned(), suspect["probability"].as_f64().filter(|p| *p > 0.0)?))
        };
        let effects: Vec<(String, f64)> = first.filter_map(stated).collect();
        let left = (1.0 - effects.iter().map(|(_, p)| p).sum::<f64>()).max(0.0);
        Self { effects, none: diagnosis["none_probability"].as_f64().unwrap_or(left) }
    }

    /// Puts all probability on an answer.
    pub fn sure(said: &CaseAnswer) -> Self {
        match said.named.first() {
            Some(named) => Self { effects: vec![(named.name.clone(), 1.0)], none: 0.0 },
            None => Self { effects: Vec::new(), none: 1.0 },
        }
    }

    /// Each probability, with true if its statement is true. "None" is true if no effect of the library that could show
    /// is hidden.
    pub fn statements(&self, case: &Case) -> Vec<(f64, bool)> {
        let is_none = match case.asked() {
            ExpectedAnswer::Names => false,
            ExpectedAnswer::Unknown | ExpectedAnswer::Nothing => true,
        };
        let effects = self.effects.iter().map(|(name, p)| (*p, case.is_there(name)));
        effects.chain([(self.none, is_none)]).collect()
    }

    /// Brier score (1950): from 0, all probability on the true statement, to 2, all on a false one. If several
    /// statements are true, their probabilities are summed.
    pub fn brier(&self, case: &Case) -> f64 {
        let statements = self.statements(case);
        let truth: f64 = statements.iter().filter(|(_, is_true)| *is_true).map(|(p, _)| p).sum();
        let rest: f64 = statements.iter().filter(|(_, is_true)| !is_true).map(|(p, _)| p * p).sum();
        (1.0 - truth).powi(2) + rest
    }
}

/// Statements of similar probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Least and greatest probability.
    pub range: [f64; 2],
    /// Mean stated probability.
    pub stated: f64,
    /// Share of these statements that are true.
    pub is_true: Rate,
}

/// Agreement of stated probabilities with the share of statements that are true.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reliability {
    /// Ten bins of equal width; empty ones are left out.
    pub bins: Vec<Bin>,
    /// Mean difference between stated probability and share of true statements, weighted by the number of statements.
    pub calibration_error: f64,
}

impl Reliability {
    /// Computes the bins from probabilities, each with true if its statement is true.
    pub fn new(statements: &[(f64, bool)]) -> Self {
        let stated: Vec<(f64, bool)> = statements.iter().filter(|(p, _)| *p >= LEAST_STATED).copied().collect();
        let place = |p: f64| ((p * BINS as f64) as usize).min(BINS - 1);
        let bin = |k: usize| {
            let own: Vec<(f64, bool)> = stated.iter().filter(|(p, _)| place(*p) == k).copied().collect();
            let mean = own.iter().map(|(p, _)| p).sum::<f64>() / own.len() as f64;
            let range = [k, k + 1].map(|end| end as f64 / BINS as f64);
            (!own.is_empty()).then(|| Bin { range, stated: mean, is_true: Rate::new(own.iter().map(|(_, is)| *is)) })
        };
        let bins: Vec<Bin> = (0..BINS).filter_map(bin).collect();
        let off = |bin: &Bin| bin.is_true.of as f64 * (bin.stated - bin.is_true.share()).abs();
        let calibration_error = bins.iter().map(off).sum::<f64>() / stated.len().max(1) as f64;
        Self { bins, calibration_error }
    }
}

/// The most probable statement.
pub fn most_probable(statements: &[(f64, bool)]) -> Option<(f64, bool)> {
    statements.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use effects::Process;
    use serde_json::json;
    use virtual_lab::{FrontEnd, Plan};

    use super::super::cases::{Design, Family};
    use super::*;

    fn case(family: Family, hidden: &[&str]) -> Case {
        let design = Design { process: Process::Grinding, plan: Plan::Varied, front: FrontEnd::Clean, seed: 1 };
        Case { family, number: 0, design, hidden: hidden.iter().map(|&name| name.to_owned()).collect(), rung: 1.0 }
    }

    #[test]
    fn a_forecast_is_that_of_the_first_search_and_none_is_what_is_left_unless_stated() {
        let suspect = |name: &str, p: f64, search: usize| json!({"name": name, "probability": p, "search": search});
        let suspects = [suspect("a", 0.5, 1), suspect("b", 0.2, 1), suspect("c", 0.0, 1), suspect("d", 1.0, 2)];
        let read = Forecast::of(&json!({"suspects": suspects}));
        assert_eq!(read.effects, [("a".to_owned(), 0.5), ("b".to_owned(), 0.2)]);
        assert!((read.none - 0.3).abs() < 1e-12);
        assert_eq!(Forecast::of(&json!({"suspects": suspects, "none_probability": 0.25})).none, 0.25);
        assert_eq!(Forecast::of(&json!({})).none, 1.0);
    }

    #[test]
    fn briers_score_by_hand() {
        let forecast =
            Forecast { effects: vec![("tool-tilt".to_owned(), 0.7), ("break-in".to_owned(), 0.2)], none: 0.1 };
        let score = |family, hidden: &[&str]| forecast.brier(&case(family, hidden));
        // (1 − 0.7)² + 0.2² + 0.1², and so on.
        assert!((score(Family::S, &["tool-tilt"]) - 0.14).abs() < 1e-12);
        assert!((score(Family::S, &["break-in"]) - (0.64 + 0.49 + 0.01)).abs() < 1e-12);
        assert!((score(Family::S, &["coolant"]) - (1.0 + 0.49 + 0.04 + 0.01)).abs() < 1e-12, "not even weighed");
        assert!((score(Family::U, &["stick-slip"]) - (0.81 + 0.49 + 0.04)).abs() < 1e-12);
        assert!((score(Family::D, &["tool-tilt", "break-in"]) - (0.01 + 0.01)).abs() < 1e-12, "either is true");
        assert!((score(Family::A, &["tool-tilt"]) - score(Family::N, &[])).abs() < 1e-12, "none that could show");
    }

    #[test]
    fn bins_and_calibration_error_by_hand() {
        let statements =
            [(0.95, true), (1.0, true), (0.92, false), (0.35, true), (0.31, false), (0.004, false), (0.05, false)];
        let Reliability { bins, calibration_error } = Reliability::new(&statements);
        assert_eq!(
            bins.iter().map(|bin| (bin.range[0], bin.is_true.of)).collect::<Vec<_>>(),
            [(0.0, 1), (0.3, 2), (0.9, 3)]
        );
        assert!((bins[1].stated - 0.33).abs() < 1e-12 && bins[1].is_true.hits == 1);
        // (1 · 0.05 + 2 · |0.33 − 0.5| + 3 · |0.95667 − 0.66667|) / 6
        assert!((calibration_error - (0.05 + 0.34 + 0.87) / 6.0).abs() < 1e-9, "{calibration_error}");
        assert_eq!(most_probable(&statements), Some((1.0, true)));
    }
}
