//! What a study found, apart from its maps and curves.

use serde::Serialize;
use serde_json::Value;

use super::scan_data::{ComparedPass, CovariatePlot, PassVolume, ScanComparison, ScanSection, Waterfall};
use super::unit_text::with_raised_powers;
use lab::Proposal;

/// Everything a report shows. What a study has not (maps of a table, sections of a sanding) stays empty, and the page
/// leaves the section out or says that it is absent.
#[derive(Clone, Debug)]
pub struct StudyReport {
    /// What was compared with what.
    pub compared: Compared,
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict, or what was done, in one sentence.
    pub sentence: String,
    /// Whether anything is missing, test by test.
    pub tests: Vec<TestOfMissing>,
    /// How the error falls, step by step.
    pub waterfall: Waterfall,
    /// Removed volume of each pass.
    pub volumes: Vec<PassVolume>,
    /// Measured against simulated, scan by scan.
    pub scans: Vec<ScanComparison>,
    /// Sections through the scans.
    pub sections: Vec<ScanSection>,
    /// Residual against what the simulator knows of each place.
    pub covariates: Vec<CovariatePlot>,
    /// Effects that were scored, the likeliest first, then those that were not fitted.
    pub suspects: Vec<Suspect>,
    /// Fitted parameters of laws, effects and measurement.
    pub parameters: Vec<ParameterEstimate>,
    /// How the parameters' errors go together; `None` where fewer than two were fitted.
    pub correlations: Option<Correlations>,
    /// What these passes could have shown.
    pub detectable: Vec<Detectable>,
    /// The next trial; `None` where none would help.
    pub next_trial: Option<NextTrial>,
    /// The effect that is proposed for what no effect of the library describes.
    pub proposal: Option<Proposal>,
    /// From what and by what the report was made.
    pub provenance: Provenance,
    /// The answer of `diagnose --json`; embedded as it is.
    pub diagnosis: Value,
}

/// What was compared.
#[derive(Clone, Debug, Default)]
pub struct Compared {
    /// Name of the campaign.
    pub campaign: String,
    /// The model that was compared, in words: its law and effects.
    pub model: String,
    /// The tool in words.
    pub tool: String,
    /// Passes in order of time.
    pub passes: Vec<ComparedPass>,
    /// Distance between pixels of the scans [m]; `None` for tables.
    pub pitch: Option<f64>,
    /// Voxel of the simulation [m]; `None` for tables.
    pub voxel: Option<f64>,
    /// Standard deviation of the instrument's blur as it was found [m].
    pub blur: Option<f64>,
    /// How scans were laid on the model, and from what the noise floor comes; one sentence each.
    pub method: Vec<String>,
    /// What the reader understood of the files where it was not the plain case, one sentence each.
    pub notes: Vec<String>,
}

/// What a study may conclude: exactly one of these; before it does, that it is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// One effect explains what the base law misses.
    Identified,
    /// Several effects explain it, and these passes cannot tell them apart.
    Ambiguous,
    /// An effect is found, and structure remains.
    Partly,
    /// Something is missing that no known effect explains.
    Unknown,
    /// An effect shows that is too small to be named.
    Hint,
    /// The model agrees with the measurement within its noise.
    NothingMissing,
    /// These passes could not show what was asked.
    NotTestable,
    /// The model was fitted, and nothing was searched for yet.
    Calibrated,
    /// A model that was only compared leaves noise.
    Agrees,
    /// A model that was only compared leaves more than noise.
    Differs,
    /// Of two models the second is better.
    Better,
    /// Of two models the second is no better.
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
    /// What is tested, such as `excess of whitened squares`.
    pub name: String,
    /// Its statistic [1].
    pub statistic: f64,
    /// Chance of such a value if nothing is missing, not yet corrected for the number of tests [1].
    pub p_value: f64,
    /// Whether the test rejects after that correction.
    pub rejects: bool,
}

/// An effect that was scored.
#[derive(Clone, Debug)]
pub struct Suspect {
    /// Name in the library, such as `grit-dulling`.
    pub name: String,
    /// What it is, in a few words.
    pub title: String,
    /// Probability among all that were scored [1].
    pub probability: f64,
    /// Fall of the whitened sum of squares when it is added [1]; `None` where it was not fitted.
    pub delta_chi2: Option<f64>,
    /// Root mean square in evaluation passes before it is added, in [`Waterfall::misfit`]'s SI unit.
    pub evaluation_before: Option<f64>,
    /// The same afterwards.
    pub evaluation_after: Option<f64>,
    /// Names of effects that these passes cannot tell from it.
    pub look_alikes: Vec<String>,
    /// One sentence: why it is kept or ruled out.
    pub note: String,
}

/// A value with its unit for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// Unit as people write it, such as `MPa`; empty for plain numbers.
    pub unit: String,
    /// SI value of one such unit, such as 1e6.
    pub si_per_unit: f64,
}

impl Stated {
    /// A unit, whose powers may be written as `mm^3` or `mm³`, and its SI value.
    pub fn new(unit: &str, si_per_unit: f64) -> Self {
        Self { unit: with_raised_powers(unit), si_per_unit }
    }

    /// An SI value in this unit.
    pub fn of(&self, si: f64) -> f64 {
        si / self.si_per_unit
    }
}

/// A fitted parameter.
#[derive(Clone, Debug)]
pub struct ParameterEstimate {
    /// Name with its owner, such as `preston.k` or `grit-dulling.rate`.
    pub name: String,
    /// Unit for people.
    pub unit: Stated,
    /// Value, SI.
    pub value: f64,
    /// Ends of the 95 % interval, SI; `None` where there is none, or it was not fitted.
    pub interval: Option<[f64; 2]>,
    /// Whether the fit ended on an end of its range.
    pub on_bound: bool,
    /// Whether these passes determine it at all.
    pub identifiable: bool,
    /// Whether it was held fixed.
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
    /// Name in the library.
    pub name: String,
    /// Its parameter.
    pub parameter: String,
    /// Unit for people.
    pub unit: Stated,
    /// Least size at 5 % error and 80 % power, SI; `None` where no size shows.
    pub size: Option<f64>,
    /// Typical value in practice, SI.
    pub typical: Option<f64>,
    /// Root mean square of the map that the least size makes [m].
    pub map_rms: Option<f64>,
    /// One sentence, such as `looks like a change of k at one force and feed`.
    pub note: String,
}

/// The trial to do next.
#[derive(Clone, Debug, Default)]
pub struct NextTrial {
    /// What to do in one sentence.
    pub summary: String,
    /// Steps and set points: name and value with its unit.
    pub steps: Vec<(String, String)>,
    /// What it would settle, one sentence each.
    pub settles: Vec<String>,
    /// What it would leave open, one sentence each.
    pub leaves_open: Vec<String>,
    /// Probability that it names the right one [1].
    pub probability_right: Option<f64>,
    /// The trial itself, the next best ones and what would come after it; empty for tables.
    pub menu: Vec<MenuRow>,
}

/// A trial that could be made.
#[derive(Clone, Debug)]
pub struct MenuRow {
    /// Its place among all that were simulated, from 1.
    pub place: String,
    /// What to do.
    pub summary: String,
    /// Expected time [min].
    pub minutes: f64,
    /// New workpieces.
    pub workpieces: usize,
    /// Least expected information [nat].
    pub information: f64,
    /// The same for each minute [nat/min].
    pub information_per_minute: f64,
}

/// From what and by what a report was made. No date and no machine unless the caller states them.
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
