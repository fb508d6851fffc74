//! Programs: expressions of the syntax tree with every name looked up, ready to be run many times.
//!
//! A program is a list of operations for a stack machine, so that running it never recurses to the
//! depth of the text. Two kinds: [`Program`] yields symbolic values, [`IndexProgram`] the exact
//! numbers that set indices, ranges and filters.

use super::functions::Builtin;
use super::names::Entity;
use crate::expr::{ExprId, Symbol};
use crate::number::Number;
use crate::precision::Function;
use crate::span::Span;
use crate::syntax::Comparison;

/// A compiled expression.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    pub(super) ops: Vec<(Op, Span)>,
    pub(super) span: Span,
}

/// A field of a row of a table.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) table: usize,
    pub(super) row: IndexProgram,
    pub(super) column: usize,
}

/// One operation on the stack of values.
#[derive(Clone, Debug)]
pub(super) enum Op {
    Literal(ExprId),
    /// What could not be compiled; the mistake is reported already.
    Broken,
    Time,
    /// A number made of indices, table fields and parameters.
    Number(IndexProgram),
    Field(Field),
    /// A declared quantity: a member, a slice or the whole family.
    Read {
        entity: Entity,
        indices: Box<[IndexProgram]>,
    },
    Prime,
    Negate,
    /// From here on numbers are part of the expression's form, not slots.
    BeginExponent,
    EndExponent,
    Power,
    Product(Box<[bool]>),
    Sum(Box<[bool]>),
    /// A vector, or a matrix by its rows.
    Vector(usize),
    /// Values side by side, whatever their shapes are.
    Together(usize),
    Component(Box<[IndexProgram]>),
    Call(Builtin, usize),
    SumOver(Box<SumProgram>),
    /// The integral of what a program gives, over a variable between the two bounds on the stack.
    Integral(Symbol, Box<Program>),
}

/// `sum(…)` inside an expression.
#[derive(Clone, Debug)]
pub(super) struct SumProgram {
    pub(super) binders: Vec<Binder>,
    pub(super) filter: Option<IndexProgram>,
    pub(super) body: Program,
}

/// One index of a sum: what it runs over. The slots follow the order of the indices.
#[derive(Clone, Debug)]
pub(super) struct Binder {
    pub(super) ends: [IndexProgram; 2],
    pub(super) span: Span,
}

impl Binder {
    /// Whether it runs over the same values whatever other indices are.
    pub(super) fn is_fixed(&self) -> bool {
        !self.ends.iter().any(IndexProgram::varies)
    }
}

/// A compiled index, bound or condition.
#[derive(Clone, Debug)]
pub(super) struct IndexProgram {
    pub(super) ops: Vec<(IndexOp, Span)>,
    pub(super) form: IndexForm,
    pub(super) span: Span,
}

/// The frequent forms are told apart, since they are run once an instance of a sum.
#[derive(Clone, Copy, Debug)]
pub(super) enum IndexForm {
    Constant(i64),
    /// An index variable plus a constant.
    Shifted {
        slot: usize,
        shift: i64,
    },
    /// The field of the row that an index variable holds.
    RowField {
        table: usize,
        slot: usize,
        column: usize,
    },
    General,
}

/// One operation on the stack of exact numbers.
#[derive(Clone, Debug)]
pub(super) enum IndexOp {
    Number(Number),
    /// What could not be compiled; the mistake is reported already.
    Broken,
    Pi,
    Variable(usize),
    /// Pops as many indices as stand here.
    Parameter {
        family: usize,
        indices: usize,
    },
    /// Pops the row.
    Field {
        table: usize,
        column: usize,
    },
    Negate,
    Power,
    Product(Box<[bool]>),
    Sum(Box<[bool]>),
    Mod,
    Floor,
    Sqrt,
    Norm(usize),
    Apply(Function),
    Compare(Comparison),
    Not,
    And(usize),
    Or(usize),
}

impl IndexOp {
    /// How many numbers it takes from the stack.
    pub(super) fn operands(&self) -> usize {
        match self {
            Self::Number(_) | Self::Broken | Self::Pi | Self::Variable(_) => 0,
            Self::Negate | Self::Field { .. } | Self::Floor | Self::Sqrt | Self::Apply(_) | Self::Not => 1,
            Self::Power | Self::Mod | Self::Compare(_) => 2,
            Self::Parameter { indices: count, .. } | Self::Norm(count) | Self::And(count) | Self::Or(count) => *count,
            Self::Product(signs) | Self::Sum(signs) => signs.len(),
        }
    }
}
