//! Syntax trees of formulas, each node with its position in the text.

use std::ops::Range;

use super::dimension::Dimension;
use super::op::Op;

/// A formula or a subexpression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Kind and contents.
    pub node: Node,
    /// Byte range in the formula's text.
    pub span: Range<usize>,
}

/// Kinds of node.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A number [SI]. Zero without a unit fits any dimension.
    Number(f64, Option<Dimension>),
    /// A variable, parameter, state or definition.
    Name(String),
    /// An operation on other formulas.
    Apply(Op, Vec<Expr>),
}

impl Expr {
    /// Names that occur in it, in the order of the text, with repetitions.
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

    /// Value of a formula that is a plain number.
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
