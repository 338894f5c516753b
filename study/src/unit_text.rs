//! Units for display.

/// Returns a text with the powers of units, such as `mm^3`, as superscripts: `mm³`.
pub fn with_raised_powers(text: &str) -> String {
    let mut parts = text.split('^');
    let mut raised = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let sign = usize::from(part.starts_with('-'));
        let digits = part[sign..].bytes().take_while(u8::is_ascii_digit).count();
        let (power, rest) = part.split_at(sign + digits);
        match power.parse() {
            Ok(power) => raised += &superscript(power),
            Err(_) => raised = format!("{raised}^{power}"),
        }
        raised += rest;
    }
    raised
}

/// Returns an integer in superscript digits.
pub fn superscript(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    power.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_units_are_raised_and_other_text_stays() {
        assert_eq!(with_raised_powers("mm^3"), "mm³");
        assert_eq!(with_raised_powers("m^3/(N m) of 12 mm^-1"), "m³/(N m) of 12 mm⁻¹");
        assert_eq!(with_raised_powers("MPa, 10 mm²"), "MPa, 10 mm²");
        assert_eq!(with_raised_powers("a^b"), "a^b");
    }
}
