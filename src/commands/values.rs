//! Parsers of flags' values, with one form of message for values that are not accepted.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parses a value of a library's enumeration.
///
/// - `known`: name and meaning of each value
pub(super) fn one_of<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    known: impl Fn(T) -> [&'static str; 2] + Clone + Send + Sync + 'static,
) -> impl TypedValueParser<Value = T> {
    let values = all.iter().map(|&value| known(value)).map(|[name, about]| PossibleValue::new(name).help(about));
    PossibleValuesParser::new(values.collect::<Vec<_>>()).map(move |name: String| {
        all.iter().copied().find(|&value| known(value)[0] == name).expect("other names are refused")
    })
}

/// Parses a whole number between bounds, both included.
pub(super) fn whole<T: TryFrom<u64>>(
    [least, most]: [u64; 2],
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    move |text| {
        let number = text.parse::<u64>().ok().filter(|number| (least..=most).contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| match most {
            u64::MAX => format!("a whole number of 64 bits, {least} or more, is accepted"),
            _ => format!("a whole number from {least} to {most} is accepted"),
        })
    }
}

/// Parses a number between bounds, both included.
pub(super) fn number([least, most]: [f64; 2]) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| {
        accepted(text, &format!("from {} to {}", shown(least), shown(most)), |number| (least..=most).contains(&number))
    }
}

/// Parses a finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    accepted(text, "above zero", |number| number > 0.0 && number.is_finite())
}

/// Parses a number, or two with `..` between: a range to draw from, both ends included. `end` parses each number.
pub(super) fn range(
    end: impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync,
) -> impl Fn(&str) -> Result<[f64; 2], String> + Clone + Send + Sync {
    move |text| match text.split_once("..") {
        None => Ok([end(text)?; 2]),
        Some((low, high)) => match [end(low.trim())?, end(high.trim())?] {
            [low, high] if low > high => Err(format!("{low} is above {high}; the lower end comes first")),
            range => Ok(range),
        },
    }
}

fn accepted(text: &str, range: &str, is_accepted: impl Fn(f64) -> bool) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(number) if is_accepted(number) => Ok(number),
        Ok(_) => Err(format!("a number {range} is accepted")),
        Err(_) => Err(format!("a number such as 0.5 or 2e-3 is accepted, {range}")),
    }
}

/// Formats a bound with few digits.
fn shown(bound: f64) -> String {
    if bound == 0.0 || (1e-3..1e5).contains(&bound.abs()) { format!("{bound}") } else { format!("{bound:e}") }
}
