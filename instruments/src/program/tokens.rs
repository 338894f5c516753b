//! Tokens of a line in a robot's language: words, numbers and signs.

/// A part of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    /// A name as written.
    Word(String),
    Number(f64),
    /// Text in quotes.
    Text,
    Sign(char),
}

/// Splits a line into tokens. Comments begin with `comment`; names may contain `$`, `_` and digits, and a point if
/// `is_dotted`. The error describes the text that is not a token.
pub(super) fn tokens(line: &str, comment: char, is_dotted: bool) -> Result<Vec<Token>, String> {
    let mut found = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        if first == comment {
            break;
        }
        let length = if first.is_alphabetic() || first == '$' || first == '_' {
            let is_part = |c: char| c.is_alphanumeric() || c == '$' || c == '_' || c == '.' && is_dotted;
            let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            found.push(Token::Word(rest[..length].to_owned()));
            length
        } else if first == '"' || first == '\'' {
            let length = rest[1..].find(first).map(|end| end + 2).ok_or("a text without its end")?;
            found.push(Token::Text);
            length
        } else if let Some((number, length)) = number(rest, &found) {
            found.push(Token::Number(number));
            length
        } else {
            found.push(Token::Sign(first));
            first.len_utf8()
        };
        rest = rest[length..].trim_start();
    }
    Ok(found)
}

/// The number at the start of a text, and its length; after a number or a closing bracket it has no sign.
fn number(text: &str, before: &[Token]) -> Option<(f64, usize)> {
    let is_after_value = matches!(before.last(), Some(Token::Number(_) | Token::Sign(')' | ']')));
    let bytes = text.as_bytes();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    if sign == 1 && is_after_value {
        return None;
    }
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut end = sign + digits(sign);
    if bytes.get(end) == Some(&b'.') {
        end += 1 + digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let length = digits(exponent.min(bytes.len()));
        end = if length > 0 { exponent + length } else { end };
    }
    let number: f64 = text[..end].parse().ok()?;
    number.is_finite().then_some((number, end))
}

/// Reads tokens one by one.
pub(super) struct Reader<'a> {
    pub(super) rest: &'a [Token],
}

impl<'a> Reader<'a> {
    /// The next token if it is a name.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        match self.rest {
            [Token::Word(word), rest @ ..] => {
                self.rest = rest;
                Some(word)
            }
            _ => None,
        }
    }

    /// Takes the next token if it is this name, ignoring case.
    pub(super) fn keyword(&mut self, wanted: &str) -> bool {
        let is_next = matches!(self.rest, [Token::Word(word), ..] if word.eq_ignore_ascii_case(wanted));
        is_next && self.word().is_some()
    }

    /// The next token if it is a number.
    pub(super) fn number(&mut self) -> Option<f64> {
        match self.rest {
            [Token::Number(number), rest @ ..] => {
                self.rest = rest;
                Some(*number)
            }
            _ => None,
        }
    }

    /// Takes the next token if it is this sign; returns true if so.
    pub(super) fn sign(&mut self, wanted: char) -> bool {
        match self.rest {
            [Token::Sign(sign), rest @ ..] if *sign == wanted => {
                self.rest = rest;
                true
            }
            _ => false,
        }
    }

    /// Takes numbers with commas between them in square brackets; `None` for anything else.
    pub(super) fn list(&mut self) -> Option<Vec<f64>> {
        if !self.sign('[') {
            return None;
        }
        let mut numbers = vec![self.number()?];
        while self.sign(',') {
            numbers.push(self.number()?);
        }
        self.sign(']').then_some(numbers)
    }

    /// Skips a list in square brackets with all nested lists.
    pub(super) fn skip_list(&mut self) -> bool {
        let mut depth = 0_usize;
        while let [token, rest @ ..] = self.rest {
            match token {
                Token::Sign('[') => depth += 1,
                Token::Sign(']') => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && *token != Token::Sign(']') {
                return false;
            }
            self.rest = rest;
            if depth == 0 {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_cut_into_tokens() {
        let word = |text: &str| Token::Word(text.to_owned());
        let found = tokens("LIN {X -1.5e2,Y .5} C_DIS ; note", ';', true).expect("tokens");
        let signs = [Token::Sign('{'), Token::Sign(','), Token::Sign('}')];
        let [open, comma, close] = signs;
        let wanted = [
            word("LIN"),
            open,
            word("X"),
            Token::Number(-150.0),
            comma,
            word("Y"),
            Token::Number(0.5),
            close,
            word("C_DIS"),
        ];
        assert_eq!(found, wanted);
        assert_eq!(tokens("1-2", ';', true).expect("tokens").len(), 3);
        assert!(tokens("a \"b", ';', true).is_err());
    }
}
