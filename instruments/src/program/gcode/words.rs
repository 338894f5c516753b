//! Words of a block, each a letter and a number. Source: NIST, "The NIST RS274/NGC Interpreter, Version 3", 2000,
//! section 3.

/// A letter and its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Word {
    /// In upper case.
    pub(super) letter: char,
    pub(super) value: f64,
}

/// The words of a line, without comments, line numbers and checksums; the error describes the text that is not a word.
pub(super) fn words(line: &str) -> Result<Vec<Word>, String> {
    let code = without_comments(line)?;
    let code = code.split('*').next().unwrap_or_default().trim();
    // Program markers, and blocks that a switch may skip.
    let code = if code.starts_with('%') { "" } else { code.strip_prefix('/').unwrap_or(code) };
    let mut words = Vec::new();
    let mut rest = code.trim_start();
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_alphabetic() {
            return Err(format!("{letter:?} where a word begins"));
        }
        rest = rest[1..].trim_start();
        let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-');
        let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
        let letter = letter.to_ascii_uppercase();
        let value: Option<f64> = rest[..length].parse().ok();
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return Err(format!("the word {letter}{}", rest.chars().take(12).collect::<String>()));
        };
        if !matches!(letter, 'N' | 'O') {
            words.push(Word { letter, value });
        }
        rest = rest[length..].trim_start();
    }
    Ok(words)
}

fn without_comments(line: &str) -> Result<String, String> {
    let mut code = String::new();
    let mut is_comment = false;
    for c in line.chars() {
        match c {
            '(' if !is_comment => is_comment = true,
            ')' if is_comment => is_comment = false,
            ';' if !is_comment => break,
            _ if is_comment => {}
            c => code.push(c),
        }
    }
    if is_comment { Err("a comment without its end".to_owned()) } else { Ok(code) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_with_and_without_blanks() {
        let word = |letter, value| Word { letter, value };
        let wanted = [word('G', 1.0), word('X', -1.5), word('Y', 0.25)];
        for line in ["N10 G1 X-1.5 Y.25", "g01x-1.5y.25 (a note) ; more", "/G1X -1.5Y0.25*71"] {
            assert_eq!(words(line).expect(line), wanted, "{line}");
        }
        assert!(words("%").expect("a mark").is_empty());
        assert!(words("X#1").is_err() && words("X[1+2]").is_err() && words("G1 (open").is_err());
    }
}
