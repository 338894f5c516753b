//! Formulas as trees, each node with its place in the text.

use std::ops::Range;

use super::dimension::Dimension;
use super::op::Op;

/// A formula or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it is.
    pub node: Node,
    /// Its bytes in the formula's text.
    pub span: Range<usize>,
}

/// Kinds of formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A number [SI]. Zero without a unit has no dimension of its own: it fits any.
    Number(f64, Option<Dimension>),
    /// A variable, parameter, state or definition.
    Name(String),
    /// An operation on other formulas.
    Apply(Op, Vec<Expr>),
}

impl Expr {
    /// The names that occur in it, in the order of the text, with repetitions.
    pub fn names(&self) -> Vec<(&str, Range<usize>)> {
        let mut names = Vec::new();
        self.collect_names(&mut names);
        names
    }

    fn collect_names<'a>(&'a self, names: &mut Vec<(&'a str, Range<usize>)>) {
        match &self.node {
            Node::Number(..) => {}
            Node::Name(name) => names.push((name, self.span.clone())),
            Node::Apply(_, arguments) => arguments.iter().for_each(|argument| argument.collect_names(names)),
        }
    }

    /// Number of nodes.
    pub fn size(&self) -> usize {
        match &self.node {
            Node::Apply(_, arguments) => 1 + arguments.iter().map(Self::size).sum::<usize>(),
            _ => 1,
        }
    }

    /// The value of a formula of plain numbers.
    pub fn literal(&self) -> Option<f64> {
        match &self.node {
            Node::Number(value, None | Some(Dimension::NONE)) => Some(*value),
            Node::Number(..) | Node::Name(_) => None,
            Node::Apply(op, arguments) => {
                let mut values = [0.0; 3];
                for (value, argument) in values.iter_mut().zip(arguments) {
                    *value = argument.literal()?;
                }
                Some(op.apply(values))
            }
        }
    }
}
