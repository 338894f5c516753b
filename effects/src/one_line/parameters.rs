//! Null value, range and initial value of each parameter of a one-line effect.

use super::super::dimension::Dimension;
use super::super::library::check_file;
use super::super::unit::Unit;
use super::{OneLine, OneLineError, Unknown};

/// Common units of parameters; the first of a dimension is used.
const UNITS: [&str; 24] = [
    "1", "mm^3", "mm", "mm^2", "MPa", "s", "N", "W", "J", "K", "m/s", "m/s^2", "1/s", "1/mm", "1/mm^2", "1/mm^3",
    "1/MPa", "1/N", "1/K", "1/W", "s/m", "mm^3/s", "MPa/mm", "mm/N",
];
/// Candidate null values of a parameter, in the order of preference.
const NULLS: [f64; 3] = [0.0, f64::INFINITY, 1.0];
/// Candidate powers of a name in the scale of a parameter, in the order in which they are tried.
const POWERS: [i32; 4] = [1, -1, 2, -2];

/// Least and greatest value [SI] of a quantity in the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The least.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl Extent {
    fn size(self) -> f64 {
        self.least.abs().max(self.greatest.abs())
    }
}

/// Range and initial value of a parameter before any fit [SI].
struct Guess {
    range: [f64; 2],
    default: f64,
    is_log: bool,
}

impl OneLine {
    /// Returns the text of the effect file.
    ///
    /// - `name`: name of the effect
    /// - `extent`: extent of a variable or state in the data; `None` if the data do not give it
    /// - `given`: initial values [SI] of parameters for a fit
    ///
    /// # Errors
    /// A parameter whose magnitude cannot be inferred, or a formula that is the identity for no parameter value.
    pub fn file(
        &self,
        name: &str,
        extent: &dyn Fn(&str) -> Option<Extent>,
        given: &[(String, f64)],
    ) -> Result<String, OneLineError> {
        let sizes = self.unknowns.iter().map(|unknown| self.size(unknown, extent, given));
        let sizes: Vec<(f64, Option<Extent>)> = sizes.collect::<Result<_, _>>()?;
        for null in NULLS {
            for vanishing in 0..self.unknowns.len() {
                let text = self.text(name, &sizes, (vanishing, null), given);
                if check_file(&format!("{name}.toml"), &text).is_ok() {
                    return Ok(text);
                }
            }
        }
        Err(OneLineError::NoNull { line: self.line.clone(), value: self.value.name() })
    }

    /// Returns the scale of a parameter [SI] and the extent of the quantity that it is compared with. The scale is the
    /// given one, that of a name of the same dimension, or that of the simplest product of powers of names with this
    /// dimension.
    fn size(
        &self,
        unknown: &Unknown,
        extent: &dyn Fn(&str) -> Option<Extent>,
        given: &[(String, f64)],
    ) -> Result<(f64, Option<Extent>), OneLineError> {
        if let Some((_, value)) = given.iter().find(|(name, value)| *name == unknown.name && *value != 0.0) {
            return Ok((value.abs(), None));
        }
        let named: Vec<(Dimension, Extent)> = (self.declared.iter())
            .filter(|(name, _)| name != self.value.name())
            .filter_map(|(name, dimension)| Some((*dimension, extent(name).filter(|extent| extent.size() > 0.0)?)))
            .collect();
        let alike = named.iter().find(|(dimension, _)| *dimension == unknown.dimension && !dimension.is_none());
        if let Some((_, extent)) = alike {
            return Ok((extent.size(), Some(*extent)));
        }
        if unknown.dimension.is_none() {
            return Ok((1.0, None));
        }
        let size = product_of(&named, unknown.dimension);
        let unit = unit_of(unknown.dimension).1;
        size.map(|size| (size, None)).ok_or_else(|| OneLineError::NoExtent { name: unknown.name.clone(), unit })
    }

    fn text(
        &self,
        name: &str,
        sizes: &[(f64, Option<Extent>)],
        (vanishing, null): (usize, f64),
        given: &[(String, f64)],
    ) -> String {
        let parameter = |(k, unknown): (usize, &Unknown)| {
            let null = (k == vanishing).then_some(null);
            let (unit, unit_text) = unit_of(unknown.dimension);
            let start = given.iter().find(|(name, _)| *name == unknown.name).map(|(_, value)| *value);
            let guess = guess(sizes[k], null, start);
            let shown = |si: f64| format!("{:?}", rounded(unit.from_si(si)));
            let null = null.map_or(String::new(), |null| {
                if null.is_infinite() { "null = inf\n".to_owned() } else { format!("null = {null:?}\n") }
            });
            let [low, high] = guess.range.map(shown);
            format!(
                "[parameters.{own}]\nsymbol = \"{own}\"\nunit = \"{unit_text}\"\n{null}range = [{low}, {high}]\ndefault = {default}\n\
                 scale = \"{scale}\"\nabout = \"parameter of the formula\"\n\n",
                own = unknown.name,
                default = shown(guess.default),
                scale = if guess.is_log { "log" } else { "linear" },
            )
        };
        let parameters: String = self.unknowns.iter().enumerate().map(parameter).collect();
        let process = self.process.name();
        format!(
            "name = \"{name}\"\ntitle = \"{formula}\"\nprocess = \"{process}\"\nsource = \"a formula that was tried\"\n\
             signature = \"{value} changes\"\nconfused_with = []\n\n{parameters}{states}[modify]\n{value} = \"{formula}\"\n",
            formula = self.formula,
            value = self.value.name(),
            states = self.state_sections(),
        )
    }
}

/// Returns range and initial value [SI] of a parameter whose scale is known.
fn guess((size, extent): (f64, Option<Extent>), null: Option<f64>, start: Option<f64>) -> Guess {
    let mut guess = match (null, extent) {
        (Some(null), _) if null.is_infinite() => {
            Guess { range: [size / 30.0, 300.0 * size], default: size, is_log: true }
        }
        (Some(1.0), _) => Guess { range: [0.02, 50.0], default: 1.3, is_log: true },
        (Some(_), _) => Guess { range: [-10.0 * size, 10.0 * size], default: 0.3 * size, is_log: false },
        (None, Some(Extent { least, greatest })) if least < 0.0 => {
            let margin = 0.1 * (greatest - least);
            Guess { range: [least - margin, greatest + margin], default: 0.5 * (least + greatest), is_log: false }
        }
        (None, Some(_)) => Guess { range: [0.003 * size, 3.0 * size], default: 0.5 * size, is_log: true },
        (None, None) => Guess { range: [0.01 * size, 100.0 * size], default: size, is_log: true },
    };
    if let Some(start) = start {
        guess.default = start;
        if start <= 0.0 && guess.is_log {
            (guess.is_log, guess.range) = (false, [10.0 * start.min(-size), 10.0 * size]);
        }
        guess.range = [guess.range[0].min(start), guess.range[1].max(start)];
    }
    guess
}

/// Returns the scale of the simplest product of powers of at most two names that has a dimension.
fn product_of(named: &[(Dimension, Extent)], dimension: Dimension) -> Option<f64> {
    let powers: Vec<(Dimension, f64)> = (POWERS.into_iter())
        .flat_map(|power| {
            named
                .iter()
                .filter_map(move |(own, extent)| Some((own.to_power(f64::from(power))?, extent.size().powi(power))))
        })
        .collect();
    let one = powers.iter().find(|(own, _)| *own == dimension).map(|(_, size)| *size);
    let two = || {
        let pairs = powers.iter().flat_map(|a| powers.iter().map(move |b| (a.0 * b.0, a.1 * b.1)));
        pairs.into_iter().find(|(own, _)| *own == dimension).map(|(_, size)| size)
    };
    one.or_else(two)
}

/// Returns the common unit of a dimension.
fn unit_of(dimension: Dimension) -> (Unit, String) {
    let usual = UNITS.iter().filter_map(|text| Some((Unit::parse(text).ok()?, (*text).to_owned())));
    usual
        .into_iter()
        .find(|(unit, _)| unit.dimension == dimension)
        .unwrap_or_else(|| (Unit::si(dimension), dimension.to_string()))
}

/// Rounds a number to four significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
