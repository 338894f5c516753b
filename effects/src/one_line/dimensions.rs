//! Infers the dimensions of undeclared names from the formula that uses them.
//!
//! Each undeclared name is an unknown. Each operation that requires equal dimensions, or a dimensionless argument, is
//! one equation that is linear in the exponents. Equations are solved in the order in which they are met.

use super::super::dimension::Dimension;
use super::super::op::Op;
use super::super::syntax::{Expr, Node};
use super::OneLineError;

/// A dimension that depends on those of the unknowns: a known factor times powers of theirs.
#[derive(Clone, Debug, PartialEq)]
struct PartialDimension {
    known: Dimension,
    /// Exponent of each unknown.
    powers: Vec<f64>,
}

/// The linear equations between dimensions that are solved so far.
pub(super) struct Dimensions<'a> {
    text: &'a str,
    unknowns: &'a [String],
    /// Returns the dimension of a declared name.
    declared: &'a dyn Fn(&str) -> Option<Dimension>,
    solved: Vec<Option<PartialDimension>>,
}

type Found = Result<Option<PartialDimension>, OneLineError>;

impl<'a> Dimensions<'a> {
    /// Returns the dimension of each unknown if the formula has dimension `of`; dimensionless if the formula leaves it
    /// open.
    ///
    /// # Errors
    /// Two parts whose dimensions cannot agree.
    pub(super) fn solve(
        (text, tree): (&'a str, &Expr),
        of: Dimension,
        unknowns: &'a [String],
        declared: &'a dyn Fn(&str) -> Option<Dimension>,
    ) -> Result<Vec<Dimension>, OneLineError> {
        let mut all = Self { text, unknowns, declared, solved: vec![None; unknowns.len()] };
        let found = all.of(tree)?;
        all.equal(found, Some(all.plain(of)), tree)?;
        let resolved = (0..unknowns.len()).map(|unknown| all.resolved(&all.alone(unknown)).known).collect();
        Ok(resolved)
    }

    fn plain(&self, known: Dimension) -> PartialDimension {
        PartialDimension { known, powers: vec![0.0; self.unknowns.len()] }
    }

    fn alone(&self, unknown: usize) -> PartialDimension {
        let mut open = self.plain(Dimension::NONE);
        open.powers[unknown] = 1.0;
        open
    }

    /// Substitutes the solved unknowns.
    fn resolved(&self, open: &PartialDimension) -> PartialDimension {
        let mut result = PartialDimension { known: open.known, powers: vec![0.0; open.powers.len()] };
        for (unknown, power) in open.powers.iter().enumerate().filter(|(_, power)| **power != 0.0) {
            match &self.solved[unknown] {
                None => result.powers[unknown] += power,
                Some(value) => {
                    let value = self.resolved(value);
                    result.known = result.known * value.known.to_power(*power).unwrap_or(Dimension::NONE);
                    result.powers.iter_mut().zip(&value.powers).for_each(|(sum, own)| *sum += power * own);
                }
            }
        }
        result
    }

    /// Requires two dimensions to be equal; `None` stands for zero, which fits any dimension.
    fn equal(&mut self, a: Option<PartialDimension>, b: Option<PartialDimension>, part: &Expr) -> Found {
        let (Some(a), Some(b)) = (a.clone(), b.clone()) else { return Ok(a.or(b)) };
        let (a, b) = (self.resolved(&a), self.resolved(&b));
        let powers: Vec<f64> = a.powers.iter().zip(&b.powers).map(|(a, b)| a - b).collect();
        let ratio = a.known / b.known;
        match powers.iter().position(|power| power.abs() > 1e-9) {
            None if ratio.is_none() => {}
            None => return Err(self.clash(part, a.known, b.known)),
            Some(unknown) => {
                let by = -1.0 / powers[unknown];
                let known = ratio.to_power(by).ok_or_else(|| self.clash(part, a.known, b.known))?;
                let mut rest: Vec<f64> = powers.iter().map(|power| by * power).collect();
                rest[unknown] = 0.0;
                self.solved[unknown] = Some(PartialDimension { known, powers: rest });
            }
        }
        Ok(Some(self.resolved(&a)))
    }

    fn clash(&self, part: &Expr, found: Dimension, expected: Dimension) -> OneLineError {
        OneLineError::Dimension { part: self.text[part.span.clone()].to_owned(), found, expected }
    }

    fn number(&mut self, found: Option<PartialDimension>, part: &Expr) -> Found {
        self.equal(found, Some(self.plain(Dimension::NONE)), part)
    }

    fn of(&mut self, expr: &Expr) -> Found {
        match &expr.node {
            Node::Number(_, dimension) => Ok(dimension.map(|known| self.plain(known))),
            Node::Name(name) => Ok(Some(match self.unknowns.iter().position(|unknown| unknown == name) {
                Some(unknown) => self.alone(unknown),
                None => self.plain((self.declared)(name).unwrap_or(Dimension::NONE)),
            })),
            Node::Apply(op, parts) => {
                let found = parts.iter().map(|part| self.of(part)).collect::<Result<Vec<_>, _>>()?;
                self.applied(*op, parts, found)
            }
        }
    }

    fn applied(&mut self, op: Op, parts: &[Expr], found: Vec<Option<PartialDimension>>) -> Found {
        let plain = Some(self.plain(Dimension::NONE));
        match op {
            Op::Add | Op::Sub | Op::Min | Op::Max => self.equal(found[0].clone(), found[1].clone(), &parts[1]),
            Op::Less | Op::LessEqual | Op::Equal => {
                self.equal(found[0].clone(), found[1].clone(), &parts[1]).map(|_| plain)
            }
            Op::If => {
                self.number(found[0].clone(), &parts[0])?;
                self.equal(found[1].clone(), found[2].clone(), &parts[2])
            }
            Op::Mul => Ok(self.product(&found, 1.0)),
            Op::Div => Ok(self.product(&found, -1.0)),
            Op::Neg | Op::Abs => Ok(found[0].clone()),
            Op::Sign => Ok(plain),
            Op::Exp | Op::Log | Op::Sin | Op::Cos | Op::Tanh => self.number(found[0].clone(), &parts[0]).map(|_| plain),
            Op::Sqrt => self.raised(found[0].clone(), 0.5, &parts[0]),
            Op::Pow => {
                self.number(found[1].clone(), &parts[1])?;
                match parts[1].literal() {
                    Some(power) => self.raised(found[0].clone(), power, &parts[0]),
                    None => self.number(found[0].clone(), &parts[0]).map(|_| plain),
                }
            }
        }
    }

    /// Returns one dimension times a power of another; `None` if either is a zero.
    fn product(&self, found: &[Option<PartialDimension>], power: f64) -> Option<PartialDimension> {
        let (a, b) = (found[0].as_ref()?, found[1].as_ref()?);
        let known = if power > 0.0 { a.known * b.known } else { a.known / b.known };
        Some(PartialDimension { known, powers: a.powers.iter().zip(&b.powers).map(|(a, b)| a + power * b).collect() })
    }

    fn raised(&self, found: Option<PartialDimension>, power: f64, part: &Expr) -> Found {
        let Some(found) = found else { return Ok(None) };
        let found = self.resolved(&found);
        let known = found.known.to_power(power).ok_or_else(|| self.clash(part, found.known, Dimension::NONE))?;
        Ok(Some(PartialDimension { known, powers: found.powers.iter().map(|own| power * own).collect() }))
    }
}
