//! A curve as an effect file: piecewise linear between points, with one size.

use super::action::Action;
use super::form::LEFT_LEAST;
use super::form_text::number;
use super::proposal::CurvePoint;
use super::variables::Variable;

/// Most points of a curve in a file.
const MOST_POINTS: usize = 13;

/// Name and text of the file.
///
/// - `source`: its `source` line
pub(crate) fn curve_file(
    (action, variable): (Action, &Variable),
    curve: &[CurvePoint],
    source: &str,
) -> (String, String) {
    let Variable { name, formula, state, unit, about, .. } = variable;
    let count = curve.len().clamp(1, MOST_POINTS);
    let point = |k: usize| &curve[(k * curve.len().saturating_sub(1)) / (count - 1).max(1)];
    let points: Vec<&CurvePoint> = (0..count.min(curve.len())).map(point).collect();
    let first = points.first().map_or(0.0, |point| point.change);
    let piece = |pair: &[&CurvePoint]| {
        let [low, high] = [pair[0].at, pair[1].at].map(|at| format!("{} [{unit}]", number(at)));
        let slope = number((pair[1].change - pair[0].change) / (pair[1].at - pair[0].at));
        format!(" + {slope} * (clamp({formula}, {low}, {high}) - {low}) / 1 [{unit}]")
    };
    let pieces: String = points.windows(2).map(piece).collect();
    let file = format!("closure-{}{name}", action.name());
    let gain = match action.shown() {
        _ if action.is_factor() => format!("max(1 + amount * change / 100, {LEFT_LEAST})"),
        (unit, _) => format!("amount * change * 1 [{unit}]"),
    };
    let text = format!(
        "name = \"{file}\"\ntitle = \"A curve of the {acts_on} over the {about}\"\nsource = \"{source}\"\n\
         signature = \"removal changes with the {about}\"\nconfused_with = []\n\n\
         [parameters.amount]\nsymbol = \"a\"\nunit = \"1\"\nnull = 0.0\nrange = [-3.0, 3.0]\ndefault = 1.0\n\
         about = \"size of the curve; 1 as it was found\"\n\n{state}\n[let]\nchange = \"{}{pieces}\"\n\
         gain = \"{gain}\"\n\n[modify]\n{modification}",
        number(first),
        acts_on = action.about(),
        modification = action.modification(),
    );
    (format!("{file}.toml"), text)
}
