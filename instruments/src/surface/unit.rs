//! Units of length by their names in files.

/// Names and SI values [m]; messages use the first name of each length.
const UNITS: [(&str, f64); 25] = [
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("µm", 1e-6),
    ("nm", 1e-9),
    ("pm", 1e-12),
    ("Å", 1e-10),
    ("inch", 0.0254),
    ("meter", 1.0),
    ("metre", 1.0),
    ("meters", 1.0),
    ("metres", 1.0),
    ("millimeter", 1e-3),
    ("millimetre", 1e-3),
    ("millimeters", 1e-3),
    ("millimetres", 1e-3),
    ("um", 1e-6),
    ("μm", 1e-6),
    ("\u{fffd}m", 1e-6),
    // The micro sign in the code page of MS-DOS, read as Latin-1.
    ("æm", 1e-6),
    ("micron", 1e-6),
    ("microns", 1e-6),
    ("micrometer", 1e-6),
    ("in", 0.0254),
    ("nanometer", 1e-9),
];

/// SI value of a unit of length [m].
pub(super) fn metres(name: &str) -> Option<f64> {
    let name = name.trim();
    let exact = UNITS.iter().find(|(known, _)| *known == name);
    // A capital M is mega, so short names are compared with case.
    let lower = || UNITS.iter().find(|(known, _)| known.len() > 3 && known.eq_ignore_ascii_case(name));
    exact.or_else(lower).map(|(_, metres)| *metres)
}

/// Name of the unit with this SI value [m].
pub(super) fn name(metres: f64) -> &'static str {
    UNITS.iter().find(|(_, known)| *known == metres).map_or("m", |(name, _)| name)
}
