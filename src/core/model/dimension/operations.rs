//! What operations do to dimensions.

use super::error::Inferred;
use super::solve::{Combination, Solver};
use super::{BASE, Dimension, DimensionError};
use crate::number::Number;
use crate::span::Span;

/// The dimension of a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Quantity {
    /// Fits everything: zero, and what has a mistake already.
    Any,
    /// A number, or a list or family all of whose elements are alike.
    Of(Combination),
    /// A list of things that are not alike, or not known to be.
    List(Vec<Quantity>),
}

impl Quantity {
    pub(super) fn number() -> Self {
        Self::Of(Combination::default())
    }

    /// A list; one whose elements are alike is as good as one of them.
    pub(super) fn list(parts: Vec<Quantity>) -> Self {
        match parts.split_first() {
            // A zero among others says nothing about its place.
            Some((first @ (Self::Any | Self::Of(_)), rest)) if rest.iter().all(|part| part == first) => first.clone(),
            _ => Self::List(parts),
        }
    }

    /// What all of it is, where that is one thing and known to be.
    pub(super) fn of(&self) -> Option<&Combination> {
        if let Self::Of(own) = self { Some(own) } else { None }
    }

    fn map(self, f: &impl Fn(Combination) -> Combination) -> Self {
        match self {
            Self::Any => Self::Any,
            Self::Of(own) => Self::Of(f(own)),
            Self::List(parts) => Self::list(parts.into_iter().map(|part| part.map(f)).collect()),
        }
    }

    pub(super) fn power(self, exponent: &Number) -> Self {
        self.map(&|own| own.power(exponent))
    }

    /// The time derivative.
    pub(super) fn rate(self) -> Self {
        let time = base("s");
        self.map(&|own| own.over(&time))
    }

    /// What gives a power with the time derivative: of a coordinate the force.
    pub(super) fn conjugate(self) -> Self {
        self.map(&|own| energy().over(&own))
    }

    /// The element of a list, from 0.
    pub(super) fn element(&self, at: usize) -> Option<Self> {
        match self {
            Self::List(parts) => parts.get(at).cloned(),
            Self::Any | Self::Of(_) => Some(self.clone()),
        }
    }
}

/// What a contradiction is called.
pub(super) enum Context<'a> {
    Sum,
    Arguments(&'a str),
}

/// The equations and the mistakes so far.
#[derive(Debug, Default)]
pub(super) struct Equations {
    pub(super) solver: Solver,
    pub(super) errors: Vec<DimensionError>,
}

impl Equations {
    /// The dimension as far as it is to be told; unknown ones count as numbers.
    pub(super) fn known(&self, own: &Combination) -> Option<Dimension> {
        self.solver.resolve(own)?.dimension()
    }

    /// Requires two sides to be equal, the `error` of which gets what they are, and a name that makes one of them so; `false` if
    /// they differ.
    pub(super) fn require(
        &mut self,
        sides: [&Combination; 2],
        span: Span,
        error: impl FnOnce(Dimension, Dimension, Option<Inferred>) -> DimensionError,
    ) -> bool {
        let [found, wanted] = sides;
        let equal = self.solver.equate(found, wanted, span);
        if !equal && let (Some(left), Some(right)) = (self.known(found), self.known(wanted)) {
            let inferred = sides.iter().find_map(|side| self.solver.last_found(side));
            self.errors.push(error(left, right, inferred));
        }
        equal
    }

    /// Requires terms, or arguments, to be alike; what they are.
    pub(super) fn alike(&mut self, terms: &[(Quantity, Span)], context: &Context<'_>) -> Quantity {
        let mut lengths = terms
            .iter()
            .filter_map(|(term, _)| if let Quantity::List(parts) = term { Some(parts.len()) } else { None });
        if let Some(length) = lengths.next() {
            // Shapes that don't fit are told elsewhere.
            if lengths.any(|other| other != length) {
                return Quantity::Any;
            }
            let parts = (0..length).map(|at| {
                let own: Vec<(Quantity, Span)> =
                    terms.iter().filter_map(|(term, span)| Some((term.element(at)?, *span))).collect();
                self.alike(&own, context)
            });
            return Quantity::list(parts.collect());
        }
        let own: Vec<(&Combination, Span)> =
            terms.iter().filter_map(|(term, span)| Some((term.of()?, *span))).collect();
        let Some((reference, at)) = self.commonest(&own) else { return Quantity::Any };
        let mut contradiction = false;
        for (term, span) in &own {
            let (span, other_span) = (*span, at);
            let unlike = |found, other, inferred| match context {
                Context::Sum => DimensionError::UnlikeTerms { found, span, other, other_span, unnamed: None, inferred },
                Context::Arguments(what) => {
                    let what = (*what).to_owned();
                    DimensionError::UnlikeArguments { what, found, span, other, other_span, unnamed: None, inferred }
                }
            };
            // The first one is told.
            if contradiction {
                self.solver.equate(term, reference, span);
            } else {
                contradiction = !self.require([term, reference], span, unlike);
            }
        }
        if contradiction { Quantity::Any } else { Quantity::Of(reference.clone()) }
    }

    /// The term that the others are held against: of those fully known the commonest kind, lest one
    /// slip be told of all the others.
    fn commonest<'a>(&self, terms: &[(&'a Combination, Span)]) -> Option<(&'a Combination, Span)> {
        let mut kinds: Vec<(Dimension, usize, usize)> = Vec::new();
        for (position, (term, _)) in terms.iter().enumerate() {
            if let Some(dimension) = self.known(term) {
                match kinds.iter().position(|(kind, ..)| *kind == dimension) {
                    Some(at) => kinds[at].2 += 1,
                    // More kinds than this are past sorting out.
                    None if kinds.len() < 8 => kinds.push((dimension, position, 1)),
                    None => {}
                }
            }
        }
        let most = kinds.iter().map(|(_, _, count)| *count).max().unwrap_or(0);
        let best = kinds.iter().find(|(_, _, count)| *count == most);
        let position = best.map_or(0, |(_, position, _)| *position);
        terms.get(position).copied()
    }

    /// Requires a pure number.
    pub(super) fn number(&mut self, value: &Quantity, what: &str, span: Span) {
        match value {
            Quantity::Any => {}
            Quantity::Of(own) => {
                let error =
                    |found, _, inferred| DimensionError::NotANumber { what: what.to_owned(), found, span, inferred };
                self.require([own, &Combination::default()], span, error);
            }
            Quantity::List(parts) => parts.iter().for_each(|part| self.number(part, what, span)),
        }
    }

    /// One dimension for all elements.
    pub(super) fn uniform(&mut self, value: Quantity, what: &str, span: Span) -> Quantity {
        match value {
            Quantity::Any | Quantity::Of(_) => value,
            Quantity::List(parts) => {
                let parts: Vec<(Quantity, Span)> =
                    parts.into_iter().map(|part| (self.uniform(part, what, span), span)).collect();
                self.alike(&parts, &Context::Arguments(what))
            }
        }
    }

    /// `left * right` or `left / right`; lists as vectors and matrices.
    pub(super) fn product(&mut self, left: Quantity, right: Quantity, divided: bool, span: Span) -> Quantity {
        match (left, right) {
            (Quantity::Any, _) | (_, Quantity::Any) => Quantity::Any,
            (left, Quantity::Of(b)) if divided => left.map(&|own| own.over(&b)),
            (left, Quantity::Of(b)) => left.map(&|own| own.times(&b)),
            (Quantity::Of(a), list) if !divided => list.map(&|own| own.times(&a)),
            (Quantity::List(rows), Quantity::List(column)) if !divided => {
                let parts = rows.into_iter().map(|row| match row {
                    Quantity::List(_) => self.dot(&row, &Quantity::List(column.clone()), span),
                    Quantity::Of(_) => {
                        let column = Quantity::List(column.clone());
                        let terms = self.product(row, column, false, span);
                        self.uniform(terms, "the terms of a product of matrices", span)
                    }
                    Quantity::Any => Quantity::Any,
                });
                Quantity::list(parts.collect())
            }
            (Quantity::Of(_) | Quantity::List(_), Quantity::List(_)) => Quantity::Any,
        }
    }

    /// The product of a row with a vector, or with the rows of a matrix.
    pub(super) fn dot(&mut self, u: &Quantity, v: &Quantity, span: Span) -> Quantity {
        let length = match (u, v) {
            (Quantity::List(parts), _) | (_, Quantity::List(parts)) => parts.len(),
            _ => return self.product(u.clone(), v.clone(), false, span),
        };
        let terms = (0..length).filter_map(|at| {
            let (a, b) = (u.element(at)?, v.element(at)?);
            Some((self.product(a, b, false, span), span))
        });
        let terms: Vec<(Quantity, Span)> = terms.collect();
        self.alike(&terms, &Context::Sum)
    }
}

/// The generators of an energy.
pub(super) fn energy() -> Combination {
    Combination::from_exponents([1, 2, -2, 0, 0, 0, 0].map(Number::from))
}

/// The generators of a power.
pub(super) fn power() -> Combination {
    Combination::from_exponents([1, 2, -3, 0, 0, 0, 0].map(Number::from))
}

/// The generator of a base unit.
pub(super) fn base(symbol: &str) -> Combination {
    let place = (0..).zip(BASE).find(|(_, own)| *own == symbol);
    place.map_or_else(Combination::default, |(at, _)| Combination::generator(at))
}
