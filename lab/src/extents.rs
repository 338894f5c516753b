//! Least and greatest values of variables and states in the data, from one simulation weighted with the removal.

use effects::{CompiledModel, Extent, Library, Model, NamedState, OneLine, Process, Unit, Variable};

use super::evidence::{Evidence, EvidenceError, Split};
use super::rows::RowEvidence;
use super::scans::ScanEvidence;
use super::simulated::Simulated;
use trials::table::Row;

/// Name of the effect that accumulates sums and changes nothing.
const WATCH: &str = "extent-sums";

/// Names with their ranges in the data [SI].
pub type Extents = Vec<(String, Extent)>;

/// Data that know the range of each variable and state of a formula.
pub trait Reaches {
    /// States that formulas may read by name in addition to those of a library.
    fn measured_states(&self) -> Vec<NamedState>;

    /// Range in the data of each variable and state that a line reads [SI]; names without one are left out.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn extents(&self, line: &OneLine, model: &Model, library: &Library) -> Result<Extents, EvidenceError>;
}

impl Reaches for ScanEvidence<'_> {
    fn measured_states(&self) -> Vec<NamedState> {
        Vec::new()
    }

    fn extents(&self, line: &OneLine, model: &Model, library: &Library) -> Result<Extents, EvidenceError> {
        let process = self.process();
        let is_watched =
            |name: &&str| Variable::find(name, effects::Hook::WorkpieceCell).is_some() || line.has_state(name);
        let names: Vec<&str> = line.reads().filter(is_watched).collect();
        let Ok(library) = library.with(&[(format!("{WATCH}.toml"), watch(process, &names, &line.state_sections()))])
        else {
            return Ok(Vec::new());
        };
        let model = model.clone().with(WATCH);
        let Ok(model) = CompiledModel::new(&model, &library, self.rows()) else { return Ok(Vec::new()) };
        let simulated = Simulated::all(self, &[&model])?.remove(0);
        let known = |(k, name): (usize, &&str)| Some(((*name).to_owned(), extent(self, &simulated, (k, names.len()))?));
        Ok(names.iter().enumerate().filter_map(known).collect())
    }
}

/// Effect file of the sums: the removal, then the removal times each name.
fn watch(process: Process, names: &[&str], states: &str) -> String {
    let removal = process.signal().rate().name();
    let sum = |(k, factor): (usize, String)| {
        format!("[state.sum_{k}]\nper = \"workpiece_cell\"\nrate = \"{removal}{factor}\"\n")
    };
    let factors = std::iter::once(String::new()).chain(names.iter().map(|name| format!(" * {name}")));
    let sums: String = factors.enumerate().map(sum).collect();
    format!(
        "name = \"{WATCH}\"\ntitle = \"Sums of what each place meets\"\nsource = \"none\"\nsignature = \"nothing\"\n\
         confused_with = []\n\n[parameters.none]\nsymbol = \"n\"\nunit = \"1\"\nnull = 0.0\nrange = [0.0, 1.0]\n\
         default = 0.0\nfree = false\nabout = \"nothing\"\n\n{states}{sums}\n[modify]\n{removal} = \"{removal} * (1 + none)\"\n"
    )
}

/// Range over the worked pixels of the removal-weighted mean of a name.
fn extent(evidence: &ScanEvidence, simulated: &Simulated, (name, names): (usize, usize)) -> Option<Extent> {
    let mut found: Option<Extent> = None;
    for view in evidence.of(Split::Calibration) {
        let covariates = simulated.pass(view).covariates.as_ref()?;
        let pixels = &evidence.simulation.trials()[view.trial].trial.scans.before.pixels;
        let first = covariates.states.len() - names - 1;
        let at = |sum: usize| {
            let known = covariates.states[first + sum].iter().map(|value| if value.is_finite() { *value } else { 0.0 });
            covariates.at(pixels, &known.collect::<Vec<f64>>())
        };
        let (removed, sums) = (at(0), at(1 + name));
        for (_, pixel) in view.data.tiles().pixels() {
            let mean = sums[pixel] / removed[pixel];
            if removed[pixel] > 0.0 && mean.is_finite() {
                let own = found.get_or_insert(Extent { least: mean, greatest: mean });
                (own.least, own.greatest) = (own.least.min(mean), own.greatest.max(mean));
            }
        }
    }
    found
}

impl Reaches for RowEvidence<'_> {
    fn measured_states(&self) -> Vec<NamedState> {
        let is_name = |name: &str| {
            name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        let own = self.table.usage.iter().filter(|usage| is_name(&usage.name));
        own.filter_map(|usage| {
            let unit = if usage.unit == "degC" { "K" } else { &usage.unit };
            Some(NamedState::measured(&usage.name, unit, Unit::parse(unit).ok()?.dimension))
        })
        .collect()
    }

    fn extents(&self, line: &OneLine, _: &Model, _: &Library) -> Result<Extents, EvidenceError> {
        let rows = || self.of(Split::Calibration).iter().map(|&at| &self.table.rows[at]);
        let over = |value: &dyn Fn(&Row) -> Option<f64>| {
            let known: Vec<f64> = rows().filter_map(value).filter(|value| value.is_finite()).collect();
            let least = known.iter().copied().reduce(f64::min)?;
            Some(Extent { least, greatest: known.iter().copied().fold(least, f64::max) })
        };
        let of_name = |name: &str| {
            if let Some(usage) = self.table.usage.iter().position(|usage| usage.name == name) {
                return over(&|row| row.usage.get(usage).copied());
            }
            match name {
                "force" | "force_setpoint" | "force_reading" => over(&|row| row.force),
                "pressure" | "pressure_mean" => over(&|row| row.pressure),
                "sliding_speed" | "slip_speed" => over(&|row| row.speed),
                "contact_time" => over(&|row| row.duration),
                "ground_distance" | "sliding_distance" | "run_distance" => {
                    let way = rows().filter_map(|row| Some(row.speed? * row.duration?)).sum::<f64>();
                    (way > 0.0).then_some(Extent { least: 0.0, greatest: way })
                }
                "ground_volume" | "worked_volume" => {
                    let all = rows().filter_map(|row| Some(row.removal_rate? * row.duration?)).sum::<f64>();
                    (all > 0.0).then_some(Extent { least: 0.0, greatest: all })
                }
                _ => None,
            }
        };
        Ok(line.reads().filter_map(|name| Some((name.to_owned(), of_name(name)?))).collect())
    }
}
