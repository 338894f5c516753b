//! Results of a study, apart from its maps and curves.

use serde::Serialize;
use serde_json::Value;

use super::scan_data::{ComparedPass, CovariatePlot, PassVolume, ScanComparison, ScanSection, Waterfall};
use super::unit_text::with_raised_powers;
use lab::Proposal;

/// All contents of a report. Parts that a study lacks (maps of a table, sections of a sanding) stay empty, and the page
/// leaves the section out or says that it is absent.
#[derive(Clone, Debug)]
pub struct StudyReport {
    /// The compared measurements and model.
    pub compared: Compared,
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict, or the step that was done, in one sentence.
    pub sentence: String,
    /// Tests of structure, one by one.
    pub tests: Vec<TestOfMissing>,
    /// Error after each step.
    pub waterfall: Waterfall,
    /// Removed volume of each pass.
    pub volumes: Vec<PassVolume>,
    /// Comparison of each scan with the simulation.
    pub scans: Vec<ScanComparison>,
    /// Sections through the scans.
    pub sections: Vec<ScanSection>,
    /// Residual over each covariate, which the simulator knows at each place.
    pub covariates: Vec<CovariatePlot>,
    /// Effects that were scored, the most probable first, then those that were not fitted.
    pub suspects: Vec<Suspect>,
    /// Fitted parameters of laws, effects and measurement.
    pub parameters: Vec<ParameterEstimate>,
    /// Correlations of the parameters' errors; `None` if fewer than two were fitted.
    pub correlations: Option<Correlations>,
    /// Detectable sizes of effects in these passes.
    pub detectable: Vec<Detectable>,
    /// The next trial; `None` if none would help.
    pub next_trial: Option<NextTrial>,
    /// Effect that is proposed if no effect of the library describes the data.
    pub proposal: Option<Proposal>,
    /// Inputs and program of the report.
    pub provenance: Provenance,
    /// The answer of `diagnose --json`, embedded unchanged.
    pub diagnosis: Value,
}

/// The compared measurements and model.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// Name of the campaign.
    pub campaign: String,
    /// The compared model, in words: its laws and effects.
    pub model: String,
    /// The tool in words.
    pub tool: String,
    /// Passes in order of time.
    pub passes: Vec<ComparedPass>,
    /// Distance between pixels of the scans [m]; `None` for tables.
    pub pitch: Option<f64>,
    /// Voxel of the simulation [m]; `None` for tables.
    pub voxel: Option<f64>,
    /// Standard deviation of the instrument's fitted blur [m].
    pub blur: Option<f64>,
    /// Methods of registration and of the noise floor; one sentence each.
    pub method: Vec<String>,
    /// Notes on ambiguous input files and how they were interpreted, one sentence each.
    pub notes: Vec<String>,
}

/// Verdict of a study, or of the step that it has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// One effect explains the misfit of the base law.
    Identified,
    /// Several effects explain it, and these passes cannot distinguish them.
    Ambiguous,
    /// An effect is found, and structure remains.
    Partly,
    /// Something is missing that no known effect explains.
    Unknown,
    /// An effect is significant but too small to be named.
    Hint,
    /// The model agrees with the measurement within its noise.
    NothingMissing,
    /// These passes cannot show most effects.
    NotTestable,
    /// The model was fitted, and no search was made yet.
    Calibrated,
    /// A model that was only compared leaves only noise.
    Agrees,
    /// A model that was only compared leaves more than noise.
    Differs,
    /// The second of two models is better.
    Better,
    /// The second of two models is not better.
    NotBetter,
}

impl Verdict {
    /// The word as `--json` writes it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::Ambiguous => "ambiguous",
            Self::Partly => "partly",
            Self::Unknown => "unknown",
            Self::Hint => "hint",
            Self::NothingMissing => "nothing-missing",
            Self::NotTestable => "not-testable",
            Self::Calibrated => "calibrated",
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Better => "better",
            Self::NotBetter => "not-better",
        }
    }
}

/// One test for structure in the residual of the base model.
#[derive(Clone, Debug)]
pub struct TestOfMissing {
    /// Name of the tested property, such as `excess of whitened squares`.
    pub name: String,
    /// Its statistic [1].
    pub statistic: f64,
    /// P-value, not yet corrected for the number of tests [1].
    pub p_value: f64,
    /// True if the test rejects after that correction.
    pub rejects: bool,
}

/// An effect that was scored.
#[derive(Clone, Debug)]
pub struct Suspect {
    /// Name in the library, such as `grit-dulling`.
    pub name: String,
    /// Title in a few words.
    pub title: String,
    /// Posterior probability among all scored effects [1].
    pub probability: f64,
    /// Fall of χ² when it is added [1]; `None` if it was not fitted.
    pub delta_chi2: Option<f64>,
    /// Root mean square in evaluation passes before it is added, in [`Waterfall::misfit`]'s SI unit.
    pub evaluation_before: Option<f64>,
    /// The same afterwards.
    pub evaluation_after: Option<f64>,
    /// Names of the effects that these passes cannot distinguish from it.
    pub look_alikes: Vec<String>,
    /// One sentence: the reason for which it is kept or ruled out.
    pub note: String,
}

/// A unit for display with its SI value.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// Symbol of the unit, such as `MPa`; empty for plain numbers.
    pub unit: String,
    /// SI value of one such unit, such as 1e6.
    pub si_per_unit: f64,
}

impl Stated {
    /// Builds a unit, whose powers may be written as `mm^3` or `mm³`, with its SI value.
    pub fn new(unit: &str, si_per_unit: f64) -> Self {
        Self { unit: with_raised_powers(unit), si_per_unit }
    }

    /// Converts an SI value to this unit.
    pub fn of(&self, si: f64) -> f64 {
        si / self.si_per_unit
    }
}

/// A fitted parameter.
#[derive(Clone, Debug)]
pub struct ParameterEstimate {
    /// Name with its owner, such as `preston.k` or `grit-dulling.rate`.
    pub name: String,
    /// Display unit.
    pub unit: Stated,
    /// Value, SI.
    pub value: f64,
    /// Ends of the 95 % interval, SI; `None` if there is none, or it was not fitted.
    pub interval: Option<[f64; 2]>,
    /// True if the fit ended on a bound.
    pub on_bound: bool,
    /// True if these passes determine it.
    pub identifiable: bool,
    /// True if it was held fixed.
    pub fixed: bool,
}

/// Correlations of fitted parameters.
#[derive(Clone, Debug)]
pub struct Correlations {
    /// Names, in the order of rows and columns.
    pub names: Vec<String>,
    /// Correlations [1], shape `[names, names]`, symmetric; NaN where not determined.
    pub values: Vec<f64>,
}

/// The least size of an effect that these passes would have shown.
#[derive(Clone, Debug)]
pub struct Detectable {
    /// Name of the effect in the library.
    pub name: String,
    /// Name of its parameter.
    pub parameter: String,
    /// Display unit.
    pub unit: Stated,
    /// Least size at a 5 % significance level and 80 % power, SI; `None` if no size is detectable.
    pub size: Option<f64>,
    /// Typical value in practice, SI.
    pub typical: Option<f64>,
    /// Root mean square of the map change by the least size [m].
    pub map_rms: Option<f64>,
    /// One sentence, such as `looks like a change of k at one force and feed`.
    pub note: String,
}

/// The proposed next trial.
#[derive(Clone, Debug, Default)]
pub struct NextTrial {
    /// Description in one sentence.
    pub summary: String,
    /// Steps and setpoints: name and value with its unit.
    pub steps: Vec<(String, String)>,
    /// Questions that it would settle, one sentence each.
    pub settles: Vec<String>,
    /// Questions that it would leave open, one sentence each.
    pub leaves_open: Vec<String>,
    /// Probability that it leads to the right effect [1].
    pub probability_right: Option<f64>,
    /// The trial itself, the next best ones and the one that would follow; empty for tables.
    pub menu: Vec<MenuRow>,
}

/// A candidate trial.
#[derive(Clone, Debug)]
pub struct MenuRow {
    /// Rank among all that were simulated, from 1.
    pub place: String,
    /// Description.
    pub summary: String,
    /// Expected time [min].
    pub minutes: f64,
    /// Number of new workpieces.
    pub workpieces: usize,
    /// Lower bound of the expected information [nat].
    pub information: f64,
    /// The same per minute [nat/min].
    pub information_per_minute: f64,
}

/// Inputs and program of a report. It holds no date and no machine unless the caller states them.
#[derive(Clone, Debug, Default)]
pub struct Provenance {
    /// Files that were read.
    pub inputs: Vec<Digest>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Programs and libraries with their versions.
    pub versions: Vec<(String, String)>,
    /// Options that were not default.
    pub options: Vec<(String, String)>,
    /// Date of the study, if the caller wants one on the page.
    pub date: Option<String>,
}

/// A file and its content's hash.
#[derive(Clone, Debug)]
pub struct Digest {
    /// Path within the campaign.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}
