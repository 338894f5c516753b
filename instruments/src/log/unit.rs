//! Units in headers.

/// Canonical spelling of a unit, and other spellings in lower case.
const UNITS: [(&str, &[&str]); 26] = [
    ("s", &["sec", "secs", "second", "seconds", "sek", "sekunden"]),
    ("ms", &["msec", "millisec", "milliseconds", "millis"]),
    ("us", &["µs", "μs", "usec", "microseconds"]),
    ("ns", &["nsec", "nanosec", "nanoseconds"]),
    ("min", &["minutes"]),
    ("h", &["hours"]),
    ("m", &["meter", "metre", "meters", "metres"]),
    ("mm", &["millimeter", "millimetre", "millimeters", "millimetres"]),
    ("um", &["µm", "μm", "micron", "microns"]),
    ("N", &["n", "newton", "newtons"]),
    ("kN", &["kn"]),
    ("Nm", &["n*m", "n·m", "n m"]),
    (
        "rpm",
        &["1/min", "min-1", "min^-1", "min⁻¹", "u/min", "r/min", "tr/min", "rev/min", "revs/min", "umdr/min", "r.p.m."],
    ),
    ("rad/s", &["rad/sec", "rad_s", "rad*s^-1"]),
    ("deg/s", &["°/s", "deg_s"]),
    ("rad", &["radian", "radians"]),
    ("deg", &["°", "degree", "degrees", "grad"]),
    ("mm/s", &["mm_s", "mm/sec"]),
    ("m/s", &["m_s", "m/sec"]),
    ("°C", &["°c", "degc", "deg_c", "deg c", "c", "celsius"]),
    ("K", &["k", "kelvin"]),
    ("Hz", &["hz"]),
    ("A", &["a", "ampere"]),
    ("V", &["v", "volt"]),
    ("%", &["pct", "percent"]),
    ("kg", &[]),
];
/// Units that may follow the last underscore of a name. `min` is excluded because it means a minimum, single letters
/// because they are names.
const SUFFIXES: [&str; 25] = [
    "s", "sec", "ms", "us", "ns", "nsec", "m", "mm", "um", "n", "kn", "rpm", "rad_s", "rad", "deg_s", "deg", "mm_s",
    "m_s", "degc", "deg_c", "celsius", "kelvin", "hz", "pct", "newton",
];

/// The canonical spelling of a unit, if it is known.
pub(super) fn known(text: &str) -> Option<&'static str> {
    let text = text.trim();
    // Nanometres and newton metres differ only in a capital.
    if text == "nm" {
        return None;
    }
    let lower = text.to_lowercase();
    UNITS
        .into_iter()
        .find(|(unit, others)| *unit == text || others.contains(&lower.as_str()) || is_same(unit, &lower))
        .map(|(unit, _)| unit)
}

/// True if a unit longer than a letter matches, ignoring case.
fn is_same(unit: &str, lower: &str) -> bool {
    unit.len() > 1 && unit != "Nm" && unit.to_lowercase() == *lower
}

/// The unit in a cell of a line of units, with or without brackets.
pub(super) fn of_cell(cell: &str) -> Option<String> {
    let inner = bracketed(cell, true).filter(|(base, _)| base.is_empty()).map_or(cell, |(_, unit)| unit).trim();
    (!inner.is_empty() && inner != "-").then(|| known(inner).map_or_else(|| inner.to_owned(), str::to_owned))
}

/// True for a cell that contains a unit or is empty.
pub(super) fn is_unit_cell(cell: &str) -> bool {
    let is_bracket = bracketed(cell, true).is_some_and(|(base, _)| base.is_empty());
    cell.is_empty() || cell == "-" || cell == "1" || is_bracket || known(cell).is_some()
}

/// Splits a header cell into its name and its unit.
pub(crate) fn split(header: &str) -> (&str, Option<String>) {
    let header = header.trim();
    if let Some((base, inner)) = bracketed(header, false).filter(|(base, _)| !base.is_empty()) {
        let is_square = header.ends_with(']');
        match known(inner) {
            Some(unit) => return (base, Some(unit.to_owned())),
            None if is_square && !is_index(inner) => return (base, Some(inner.trim().to_owned())),
            None => {}
        }
    }
    for mark in [" in ", " / ", "/", ", "] {
        let parts = header.rsplit_once(mark).filter(|(base, _)| !base.is_empty() && !base.contains('/'));
        if let Some((base, Some(unit))) = parts.map(|(base, unit)| (base, known(unit))) {
            return (base.trim(), Some(unit.to_owned()));
        }
    }
    let lower = header.to_ascii_lowercase();
    let suffix = SUFFIXES.into_iter().filter_map(|suffix| {
        let base = lower.strip_suffix(suffix)?.strip_suffix('_')?;
        (!base.is_empty()).then(|| (base.len(), known(suffix)))
    });
    match suffix.min_by_key(|(base, _)| *base) {
        Some((base, Some(unit))) => (&header[..base], Some(unit.to_owned())),
        _ if lower.ends_with("_c") && lower.contains("temp") => (&header[..header.len() - 2], Some("°C".to_owned())),
        _ => (header, None),
    }
}

/// Text before trailing brackets, and the text in them.
fn bracketed(text: &str, may_be_empty: bool) -> Option<(&str, &str)> {
    let open = match text.trim_end().chars().last()? {
        ']' => '[',
        ')' => '(',
        '}' => '{',
        '>' => '<',
        _ => return None,
    };
    let text = text.trim_end();
    let (base, rest) = text.split_once(open)?;
    let inner = &rest[..rest.len() - 1];
    (may_be_empty || !inner.trim().is_empty()).then_some((base.trim(), inner.trim()))
}

/// True if brackets contain an index, as in `pose[0]`, instead of a unit.
fn is_index(inner: &str) -> bool {
    inner.chars().all(|c| c.is_ascii_digit()) || matches!(inner, "x" | "y" | "z" | "X" | "Y" | "Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_split_from_names_in_every_style() {
        let cases = [
            ("Fz [N]", "Fz", Some("N")),
            ("Fz (N)", "Fz", Some("N")),
            ("Drehzahl [1/min]", "Drehzahl", Some("rpm")),
            ("force_n", "force", Some("N")),
            ("x_mm", "x", Some("mm")),
            ("x/mm", "x", Some("mm")),
            ("v_mm_s", "v", Some("mm/s")),
            ("omega_rad_s", "omega", Some("rad/s")),
            ("Time in ms", "Time", Some("ms")),
            ("x_min", "x_min", None),
            ("pose[0]", "pose[0]", None),
            ("TCP (tool)", "TCP (tool)", None),
            ("Weg [inch]", "Weg", Some("inch")),
            ("temperature_c", "temperature", Some("°C")),
            ("/ft/wrench/force/z", "/ft/wrench/force/z", None),
            ("actual_TCP_pose_0", "actual_TCP_pose_0", None),
            ("t", "t", None),
        ];
        for (header, name, unit) in cases {
            assert_eq!(split(header), (name, unit.map(str::to_owned)), "{header}");
        }
    }

    #[test]
    fn a_line_of_units_is_known() {
        assert!(["s", "[mm]", "(N)", "-", ""].iter().all(|cell| is_unit_cell(cell)));
        assert!(!is_unit_cell("Fz"));
        assert_eq!(of_cell("[MM]").as_deref(), Some("mm"));
        assert_eq!(of_cell("U/min").as_deref(), Some("rpm"));
        assert_eq!(of_cell("-"), None);
    }
}
