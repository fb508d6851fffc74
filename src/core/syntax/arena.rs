//! The memory of a tree: what is read is an [`Expr`] or a [`Unit`], which borrows its lists and texts from here.

use std::fmt::{self, Debug, Formatter};
use std::ops::Range;
use std::sync::Arc;

use hashbrown::HashSet;

use super::ast::{Comparison, Expr, ExprKind, ExprRef, Indices, Member, Name, Unit, UnitKind, UnitRef};
use super::reuse::Shift;
use crate::span::Span;

/// An expression as it is kept; see [`ExprKind`].
#[derive(Clone)]
pub(super) enum Kept {
    Number(Arc<str>),
    Name(Arc<str>),
    Index(ExprRef, Box<[ExprRef]>),
    Field(ExprRef, Box<Name>),
    Prime(ExprRef),
    Negate(ExprRef),
    Power(ExprRef, ExprRef),
    Product(Box<[Member]>),
    Sum(Box<[Member]>),
    Call(Box<(Name, Box<[ExprRef]>)>),
    SumOver(Box<Indices>, ExprRef),
    IntegralOver(Box<Indices>, ExprRef),
    Vector(Box<[ExprRef]>),
    Compare(Comparison, ExprRef, ExprRef),
    Not(ExprRef),
    And(Box<[ExprRef]>),
    Or(Box<[ExprRef]>),
}

impl Kept {
    fn read(&self) -> ExprKind<'_> {
        match self {
            Self::Number(text) => ExprKind::Number(text),
            Self::Name(text) => ExprKind::Name(text),
            Self::Index(base, indices) => ExprKind::Index { base: *base, indices },
            Self::Field(base, field) => ExprKind::Field { base: *base, field },
            Self::Prime(inner) => ExprKind::Prime(*inner),
            Self::Negate(inner) => ExprKind::Negate(*inner),
            Self::Power(base, exponent) => ExprKind::Power { base: *base, exponent: *exponent },
            Self::Product(members) => ExprKind::Product(members),
            Self::Sum(members) => ExprKind::Sum(members),
            Self::Call(own) => ExprKind::Call { function: &own.0, arguments: &own.1 },
            Self::SumOver(indices, body) => ExprKind::SumOver { indices, body: *body },
            Self::IntegralOver(indices, body) => ExprKind::IntegralOver { indices, body: *body },
            Self::Vector(members) => ExprKind::Vector(members),
            Self::Compare(operator, left, right) => {
                ExprKind::Compare { operator: *operator, left: *left, right: *right }
            }
            Self::Not(inner) => ExprKind::Not(*inner),
            Self::And(members) => ExprKind::And(members),
            Self::Or(members) => ExprKind::Or(members),
        }
    }
}

/// A unit as it is kept; see [`UnitKind`].
#[derive(Clone)]
pub(super) enum KeptUnit {
    One,
    Name(Box<str>),
    Product(Box<[(bool, UnitRef)]>),
    Power(UnitRef, i32, i32),
}

impl KeptUnit {
    fn read(&self) -> UnitKind<'_> {
        match self {
            Self::One => UnitKind::One,
            Self::Name(name) => UnitKind::Name(name),
            Self::Product(factors) => UnitKind::Product(factors),
            Self::Power(base, numerator, denominator) => {
                UnitKind::Power { base: *base, numerator: *numerator, denominator: *denominator }
            }
        }
    }
}

/// All expressions of a file, each numbered by its [`ExprRef`]; children before parents.
#[derive(Clone, Default)]
pub struct Expressions {
    nodes: Vec<(Span, Kept)>,
    /// Each text once.
    texts: HashSet<Arc<str>>,
}

/// All units of a file, each numbered by its [`UnitRef`]; children before parents.
#[derive(Clone, Default)]
pub struct Units {
    nodes: Vec<(Span, KeptUnit)>,
}

/// How an arena is read.
macro_rules! reading {
    ($arena:ident, $number:ident, $read:ident, $shift:ident) => {
        impl $arena {
            /// Those of a statement: statement by statement they are in the order of the text.
            pub(super) fn places(&self, statement: Span) -> Range<usize> {
                let before = |end: u32| self.nodes.partition_point(|(span, _)| span.start < end);
                before(statement.start)..before(statement.end)
            }

            /// Adds some of another file, moved.
            pub(super) fn copy(&mut self, from: &Self, own: Range<usize>, shift: Shift) {
                self.nodes.extend(from.nodes.get(own).unwrap_or_default().iter().cloned().map(
                    |(mut span, mut kept)| {
                        shift.span(&mut span);
                        shift.$shift(&mut kept);
                        (span, kept)
                    },
                ));
            }

            /// How many there are.
            #[must_use]
            pub fn len(&self) -> usize {
                self.nodes.len()
            }

            /// Whether there are none.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                self.nodes.is_empty()
            }

            /// All of them, children before parents.
            pub fn iter(&self) -> impl ExactSizeIterator<Item = $read<'_>> + DoubleEndedIterator {
                self.nodes.iter().map(|(span, kept)| $read { span: *span, kind: kept.read() })
            }

            /// The one of that number, if there is one.
            #[must_use]
            pub fn get(&self, at: $number) -> Option<$read<'_>> {
                let (span, kept) = self.nodes.get(at.0 as usize)?;
                Some($read { span: *span, kind: kept.read() })
            }
        }

        impl PartialEq for $arena {
            fn eq(&self, other: &Self) -> bool {
                self.iter().eq(other.iter())
            }
        }

        impl Debug for $arena {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.debug_list().entries(self.iter()).finish()
            }
        }
    };
}

reading!(Expressions, ExprRef, Expr, kept);
reading!(Units, UnitRef, Unit, unit);

impl Expressions {
    fn text(&mut self, text: &str) -> Arc<str> {
        if let Some(known) = self.texts.get(text) {
            return known.clone();
        }
        let own: Arc<str> = text.into();
        self.texts.insert(own.clone());
        own
    }

    /// Adds an expression, whose children are there already.
    pub fn push(&mut self, expr: Expr<'_>) -> ExprRef {
        let kept = match expr.kind {
            ExprKind::Number(text) => Kept::Number(self.text(text)),
            ExprKind::Name(text) => Kept::Name(self.text(text)),
            ExprKind::Index { base, indices } => Kept::Index(base, indices.into()),
            ExprKind::Field { base, field } => Kept::Field(base, field.clone().into()),
            ExprKind::Prime(inner) => Kept::Prime(inner),
            ExprKind::Negate(inner) => Kept::Negate(inner),
            ExprKind::Power { base, exponent } => Kept::Power(base, exponent),
            ExprKind::Product(members) => Kept::Product(members.into()),
            ExprKind::Sum(members) => Kept::Sum(members.into()),
            ExprKind::Call { function, arguments } => Kept::Call(Box::new((function.clone(), arguments.into()))),
            ExprKind::SumOver { indices, body } => Kept::SumOver(indices.clone().into(), body),
            ExprKind::IntegralOver { indices, body } => Kept::IntegralOver(indices.clone().into(), body),
            ExprKind::Vector(members) => Kept::Vector(members.into()),
            ExprKind::Compare { operator, left, right } => Kept::Compare(operator, left, right),
            ExprKind::Not(inner) => Kept::Not(inner),
            ExprKind::And(members) => Kept::And(members.into()),
            ExprKind::Or(members) => Kept::Or(members.into()),
        };
        self.nodes.push((expr.span, kept));
        ExprRef(self.nodes.len() as u32 - 1)
    }

    /// Gives back what is not needed for reading.
    pub(super) fn finish(&mut self) {
        self.nodes.shrink_to_fit();
        self.texts = HashSet::new();
    }
}

impl Units {
    /// Adds a unit, whose parts are there already.
    pub fn push(&mut self, unit: Unit<'_>) -> UnitRef {
        let kept = match unit.kind {
            UnitKind::One => KeptUnit::One,
            UnitKind::Name(name) => KeptUnit::Name(name.into()),
            UnitKind::Product(factors) => KeptUnit::Product(factors.into()),
            UnitKind::Power { base, numerator, denominator } => KeptUnit::Power(base, numerator, denominator),
        };
        self.nodes.push((unit.span, kept));
        UnitRef(self.nodes.len() as u32 - 1)
    }
}
