//! Results of a study, apart from its maps and curves.

use serde_json::Value;

use super::pass_tiles::PassTiles;
use super::scan_data::{ComparedPass, CovariatePlot, PassVolume, ScanComparison, ScanSection, Waterfall};
use super::unit_text::with_raised_powers;
use lab::{
    Correlation, Detectable, EffectSummary, NextTrial, ParameterSummary, Proposal, StructureTest, Unfitted, Verdict,
};

/// All contents of a report. Parts that a study lacks (maps of a table, sections of a sanding) stay empty, and the page
/// leaves the section out or says that it is absent.
#[derive(Clone, Debug)]
pub struct StudyReport {
    /// The compared measurements and model.
    pub compared: Compared,
    /// Conclusion of the study, or of the step that it has reached.
    pub conclusion: Conclusion,
    /// The conclusion in one sentence.
    pub sentence: String,
    /// Tests of structure, one by one.
    pub tests: Vec<StructureTest>,
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
    /// Residuals and covariates of the tiles of each scan, with the model of the maps; empty where nothing shows them.
    pub tiles: Vec<PassTiles>,
    /// Effects that were fitted, by search, the most probable first.
    pub suspects: Vec<EffectSummary>,
    /// Effects that a search looked at and did not fit.
    pub unfitted: Vec<Unfitted>,
    /// Parameters of laws, effects and measurement.
    pub parameters: Vec<ParameterSummary>,
    /// Correlations of the parameters' errors; empty if fewer than two were fitted.
    pub correlations: Vec<Correlation>,
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

/// Conclusion of a study, or of the step that it has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conclusion {
    /// Verdict of a search.
    Searched(Verdict),
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

impl Conclusion {
    /// Word on the page.
    pub fn word(self) -> &'static str {
        match self {
            Self::Searched(verdict) => verdict.word(),
            Self::Calibrated => "calibrated",
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Better => "better",
            Self::NotBetter => "not-better",
        }
    }
}

/// A unit for display with its SI value.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Symbol of the unit, such as `MPa`; empty for plain numbers.
    pub unit: String,
    /// SI value of one such unit, such as 1e6.
    pub si_per_unit: f64,
}

impl DisplayUnit {
    /// Builds a unit, whose powers may be written as `mm^3` or `mm³`, with its SI value.
    pub fn new(unit: &str, si_per_unit: f64) -> Self {
        Self { unit: with_raised_powers(unit), si_per_unit }
    }

    /// Converts an SI value to this unit.
    pub fn of(&self, si: f64) -> f64 {
        si / self.si_per_unit
    }
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
