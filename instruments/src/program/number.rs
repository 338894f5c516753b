//! Formatting of numbers.

/// A number with at most `digits` decimals, without trailing zeros.
pub(super) fn shown(number: f64, digits: usize) -> String {
    let text = format!("{number:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Numbers joined by a separator.
pub(super) fn joined(numbers: impl IntoIterator<Item = f64>, digits: usize, mark: &str) -> String {
    numbers.into_iter().map(|number| shown(number, digits)).collect::<Vec<_>>().join(mark)
}
