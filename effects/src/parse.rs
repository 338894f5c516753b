//! Parses formula text to a tree, by recursive descent.
//!
//! ```text
//! comparison = sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
//! sum        = product { ("+" | "-") product }
//! product    = signed { ("*" | "/") signed }
//! signed     = [ "-" | "+" ] signed | power
//! power      = atom [ "^" signed ]
//! atom       = number [ unit ] | name | name "(" comparison { "," comparison } ")" | "(" comparison ")"
//! unit       = name [ "^" number ] | "[" unit text "]"
//! ```

use std::ops::Range;

use super::dimension::Dimension;
use super::op::{FUNCTIONS, Op};
use super::syntax::{Expr, Node};
use super::unit::Unit;

/// Greatest nesting depth of brackets.
const MOST_DEEP: usize = 64;
/// Greatest number of nodes of a formula.
const MOST_NODES: usize = 4096;

/// Greatest integer power that is expanded to products.
const MOST_FACTORS: f64 = 16.0;

/// Reason why a text is not a formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found {found}, {expected} is expected")]
pub struct SyntaxError {
    /// Byte range of the text.
    pub span: Range<usize>,
    /// Text found there.
    pub found: String,
    /// Accepted text.
    pub expected: String,
}

/// Parses a formula.
///
/// # Errors
/// The first position at which the text is not a formula.
pub fn parse(text: &str) -> Result<Expr, SyntaxError> {
    let mut parser = Parser { text, at: 0, depth: 0, operators: 0 };
    let formula = parser.comparison()?;
    if !parser.rest().is_empty() {
        return Err(parser.unexpected("an operator or the end"));
    }
    if formula.size() > MOST_NODES {
        let found = format!("a formula of {} parts", formula.size());
        return Err(SyntaxError { span: 0..text.len(), found, expected: format!("one of at most {MOST_NODES}") });
    }
    Ok(formula)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    operators: usize,
}

impl<'a> Parser<'a> {
    /// Remaining text, without leading blanks.
    fn rest(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let trimmed = rest.trim_start();
        self.at += rest.len() - trimmed.len();
        trimmed
    }

    fn take(&mut self, sign: &str) -> bool {
        let taken = self.rest().starts_with(sign);
        if taken {
            self.at += sign.len();
        }
        taken
    }

    fn unexpected(&mut self, expected: impl Into<String>) -> SyntaxError {
        let rest = self.rest();
        let length = word_length(rest).max(rest.chars().next().map_or(0, char::len_utf8));
        let found = if rest.is_empty() { "the end".to_owned() } else { format!("`{}`", &rest[..length]) };
        SyntaxError { span: self.at..self.at + length, found, expected: expected.into() }
    }

    /// Counts operators, because a long row of them makes a deep tree.
    fn count_operator(&mut self) -> Result<(), SyntaxError> {
        self.operators += 1;
        if self.operators <= MOST_NODES { Ok(()) } else { Err(self.unexpected("the end of so long a formula")) }
    }

    fn comparison(&mut self) -> Result<Expr, SyntaxError> {
        let left = self.sum()?;
        for (sign, op, swapped) in [
            ("<=", Op::LessEqual, false),
            (">=", Op::LessEqual, true),
            ("==", Op::Equal, false),
            ("!=", Op::Equal, true),
            ("<", Op::Less, false),
            (">", Op::Less, true),
        ] {
            if self.take(sign) {
                let right = self.sum()?;
                let span = left.span.start..right.span.end;
                return Ok(match (op, swapped) {
                    (Op::Equal, true) => binary(Op::Sub, number(1.0, &span), binary(Op::Equal, left, right)),
                    (_, true) => Expr { node: Node::Apply(op, vec![right, left]), span },
                    (_, false) => binary(op, left, right),
                });
            }
        }
        Ok(left)
    }

    fn sum(&mut self) -> Result<Expr, SyntaxError> {
        let mut sum = self.product()?;
        loop {
            let op = match self.rest().bytes().next() {
                Some(b'+') => Op::Add,
                Some(b'-') => Op::Sub,
                _ => return Ok(sum),
            };
            self.at += 1;
            self.count_operator()?;
            sum = binary(op, sum, self.product()?);
        }
    }

    fn product(&mut self) -> Result<Expr, SyntaxError> {
        let mut product = self.signed()?;
        loop {
            let op = match self.rest().bytes().next() {
                Some(b'*') => Op::Mul,
                Some(b'/') => Op::Div,
                _ => return Ok(product),
            };
            self.at += 1;
            self.count_operator()?;
            product = binary(op, product, self.signed()?);
        }
    }

    fn signed(&mut self) -> Result<Expr, SyntaxError> {
        self.rest();
        let start = self.at;
        self.depth += 1;
        if self.depth > MOST_DEEP {
            return Err(self.unexpected(format!("a formula nested at most {MOST_DEEP} deep")));
        }
        let formula = if self.take("-") {
            let operand = self.signed()?;
            let span = start..operand.span.end;
            Ok(Expr { node: Node::Apply(Op::Neg, vec![operand]), span })
        } else if self.take("+") {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        formula
    }

    fn power(&mut self) -> Result<Expr, SyntaxError> {
        let base = self.atom()?;
        if !self.take("^") {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(raised(base, exponent))
    }

    fn atom(&mut self) -> Result<Expr, SyntaxError> {
        let rest = self.rest();
        let start = self.at;
        match rest.bytes().next() {
            Some(b'(') => {
                self.at += 1;
                let inside = self.comparison()?;
                if self.take(")") { Ok(inside) } else { Err(self.unexpected("an operator or `)`")) }
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'a'..=b'z' | b'A'..=b'Z' | b'_') => {
                let name = &rest[..word_length(rest)];
                self.at += name.len();
                if self.take("(") {
                    return self.call(name, start);
                }
                Ok(Expr { node: Node::Name(name.to_owned()), span: start..start + name.len() })
            }
            _ => Err(self.unexpected("a number, a name, a function or `(`")),
        }
    }

    fn call(&mut self, name: &str, start: usize) -> Result<Expr, SyntaxError> {
        let name_span = start..start + name.len();
        let Some(&(_, op, arity)) = FUNCTIONS.iter().find(|row| row.0 == name) else {
            let known: Vec<&str> = FUNCTIONS.iter().map(|row| row.0).collect();
            let expected = format!("one of the functions {}", known.join(", "));
            return Err(SyntaxError { span: name_span, found: format!("`{name}`"), expected });
        };
        let mut arguments = vec![self.comparison()?];
        while self.take(",") {
            arguments.push(self.comparison()?);
        }
        if !self.take(")") {
            return Err(self.unexpected("an operator, `,` or `)`"));
        }
        let more = matches!(name, "min" | "max");
        if arguments.len() != arity && !(more && arguments.len() > arity) {
            let found = format!("{} arguments of `{name}`", arguments.len());
            let expected = format!("{arity}{}", if more { " or more" } else { "" });
            return Err(SyntaxError { span: start..self.at, found, expected });
        }
        let span = start..self.at;
        let mut formula = if name == "clamp" { clamped(arguments) } else { folded(op, arguments) };
        formula.span = span;
        Ok(formula)
    }

    fn number(&mut self) -> Result<Expr, SyntaxError> {
        let start = self.at;
        let rest = self.rest();
        let digits = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let exponent = exponent_length(&rest[digits..]);
        let text = &rest[..digits + exponent];
        let Ok(value) = text.parse::<f64>() else {
            return Err(self.unexpected("a number"));
        };
        self.at += text.len();
        let (value, dimension) = match self.unit()? {
            Some(unit) => (unit.to_si(value), Some(unit.dimension)),
            None => (value, (value != 0.0).then_some(Dimension::NONE)),
        };
        Ok(Expr { node: Node::Number(value, dimension), span: start..self.at })
    }

    /// Parses the unit after a number, if there is one.
    fn unit(&mut self) -> Result<Option<Unit>, SyntaxError> {
        let rest = self.rest();
        let start = self.at;
        if let Some(inside) = rest.strip_prefix('[') {
            let Some(length) = inside.find(']') else {
                return Err(self.unexpected("a unit in square brackets"));
            };
            self.at += length + 2;
            let unit = Unit::parse(&inside[..length]);
            return unit.map(Some).map_err(|error| SyntaxError {
                span: start..self.at,
                found: format!("`{}`", &rest[..length + 2]),
                expected: format!("a unit ({error})"),
            });
        }
        let length = rest.find(|c: char| !(c.is_alphabetic() || c == '%')).unwrap_or(rest.len());
        if length == 0 {
            return Ok(None);
        }
        let after = &rest[length..];
        let power = after.strip_prefix('^').map_or(0, |power| {
            let digits = power.strip_prefix('-').unwrap_or(power);
            1 + power.len() - digits.trim_start_matches(|c: char| c.is_ascii_digit()).len()
        });
        let Ok(unit) = Unit::parse(&rest[..length + power]) else {
            return Err(self.unexpected("an operator or a unit"));
        };
        self.at += length + power;
        Ok(Some(unit))
    }
}

/// Length of an exponent such as `e-3` after a number; 0 if there is none, as in `2 e`, where a unit is expected.
fn exponent_length(rest: &str) -> usize {
    let Some(after) = rest.strip_prefix(['e', 'E']) else {
        return 0;
    };
    let digits = after.strip_prefix(['+', '-']).unwrap_or(after);
    let length = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    if length == 0 { 0 } else { rest.len() - digits.len() + length }
}

fn word_length(text: &str) -> usize {
    text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(text.len())
}

fn number(value: f64, span: &Range<usize>) -> Expr {
    Expr { node: Node::Number(value, Some(Dimension::NONE)), span: span.clone() }
}

fn binary(op: Op, left: Expr, right: Expr) -> Expr {
    let span = left.span.start.min(right.span.start)..left.span.end.max(right.span.end);
    Expr { node: Node::Apply(op, vec![left, right]), span }
}

/// Folds `min(a, b, c)` to `min(min(a, b), c)`.
fn folded(op: Op, arguments: Vec<Expr>) -> Expr {
    if op.arity() != 2 {
        let span = 0..0;
        return Expr { node: Node::Apply(op, arguments), span };
    }
    let mut arguments = arguments.into_iter();
    let first = arguments.next().expect("a call has an argument");
    arguments.fold(first, |folded, argument| binary(op, folded, argument))
}

/// Expands `clamp(x, low, high)` to `min(max(x, low), high)`.
fn clamped(arguments: Vec<Expr>) -> Expr {
    let mut arguments = arguments.into_iter();
    let mut next = || arguments.next().expect("clamp has three arguments");
    let (x, low, high) = (next(), next(), next());
    binary(Op::Min, binary(Op::Max, x, low), high)
}

/// Expands small integer powers to products, which keep exact values exact; the power one half becomes a square root.
fn raised(base: Expr, exponent: Expr) -> Expr {
    let span = base.span.start..exponent.span.end;
    let whole = |power: f64| power.abs() <= MOST_FACTORS && power == power.trunc() && power != 0.0;
    let formula = match exponent.literal() {
        Some(0.5) => Expr { node: Node::Apply(Op::Sqrt, vec![base]), span: span.clone() },
        Some(power) if whole(power) && base.size() * MOST_FACTORS as usize <= MOST_NODES => {
            let factors = (1..power.abs() as usize).map(|_| base.clone());
            let product = factors.fold(base.clone(), |product, factor| binary(Op::Mul, product, factor));
            if power < 0.0 { binary(Op::Div, number(1.0, &span), product) } else { product }
        }
        _ => binary(Op::Pow, base, exponent),
    };
    Expr { span, ..formula }
}
